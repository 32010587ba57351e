// The table of metrics and costs of each case.

// get(run, channel) -> {value, reason}. The best is the least magnitude; `paid`: runs without a pass do not
// compete; `ranks: false`: values of different methods are not to be held against each other.
const metric = (path) => (run, channel) => lookUp(channelOf(run.metrics, channel), path);
const cost = (path) => (run) => lookUp(run, "cost." + path);
const inUnits = (get) => (run, channel) => {
  const found = get(run, channel);
  return {...found, value: inErrorUnits(found.value)};
};
const inPercent = (get) => (run, channel) => {
  const found = get(run, channel);
  return {...found, value: found.value === null ? null : 100 * found.value};
};

// What the headline's error is at the pixels of an own target that is known at a sample of them.
function sampledNote(own, channel) {
  if (!own.sampled) return "";
  const found = lookUp(channelOf(own.sampled.headline_metrics, channel), "rmse");
  return `; at ${plural(own.sampled.points || 0, "pixel")} drawn at random, where the headline error is ${
      found.value === null ? EN_DASH : number(inErrorUnits(found.value))}`;
}

function ownError(run, channel) {
  const own = run.own_target || {};
  const found = own.metrics ? lookUp(channelOf(own.metrics, channel), "rmse") :
                              {value: null, reason: own.metrics_reason || "not measured"};
  const doubt = own.distinguishable === false ? "; at or below that truth\u2019s uncertainty" : "";
  return {...found, value: inErrorUnits(found.value), note: "against " + targetName(own) + sampledNote(own, channel) + doubt};
}

const flip = (key) => (run, channel) =>
    (channel === "luminance" ? lookUp(run.metrics, key) :
                               {value: null, reason: "FLIP is a value of the whole colour"});

// Where an experiment asks for it.
const ofWhole = (get) => (run, channel) =>
    (channel === "luminance" ? get(run, channel) : {value: null, reason: "a value of luminance alone"});
const LEAK_COLUMNS = [
  {
    group: "Leak",
    name: "energy",
    unit: "%",
    get: ofWhole(inPercent(metric("leak.energy"))),
    help: "leak.energy: with each surface in view lit alone in turn, sum over the pixels of the dark surfaces of " +
        "|luminance| / sum of the truth\u2019s luminance over the lit surface\u2019s pixels; both sums over all turns. " +
        "The truth is 0: light does not cross from one connected piece of skin to another"
  },
  {
    group: "Leak",
    name: "peak",
    unit: "%",
    get: ofWhole(inPercent(metric("leak.peak"))),
    help: "leak.peak: the largest luminance of a dark pixel / the scene\u2019s largest irradiance"
  }
];

const seen = (key) => flip("visible." + key);
const SEEN_COLUMNS = [
  {
    group: "Seen",
    name: "mean",
    unit: "",
    get: seen("mean"),
    help: "visible.mean: mean over skin of FLIP between the final picture and the truth\u2019s: albedo, specular light, tone " +
        "curve, at the stated pixels a degree"
  },
  {group: "Seen", name: "p95", unit: "", get: seen("p95"), help: "visible.p95: 95 % quantile of that FLIP"},
  {
    group: "Seen",
    name: "> 0.05",
    unit: "%",
    get: inPercent(seen("above_005")),
    help: "visible.above_005: share of skin pixels at which that FLIP is above 0.05"
  },
  {
    group: "Seen",
    name: "> 0.1",
    unit: "%",
    get: inPercent(seen("above_01")),
    help: "visible.above_01: share of skin pixels at which that FLIP is above 0.1"
  }
];

const COLUMNS = [
  {
    group: "Headline",
    name: "rel. RMSE",
    unit: "%",
    get: inPercent(metric("rel_rmse")),
    bar: true,
    help: "rel_rmse: RMSE / RMS of the truth over skin pixels; RMS = sqrt((1/n) sum truth\u00b2)"
  },
  {
    group: "RMSE",
    name: "headline",
    unit: errorUnit,
    get: inUnits(metric("rmse")),
    help: "rmse: sqrt((1/n) sum e\u00b2) against the headline target, e = test \u2212 truth"
  },
  {
    group: "RMSE",
    name: "own",
    unit: errorUnit,
    get: ownError,
    ranks: false,
    help: "The same against the integral that the method itself aims at: the filter\u2019s error. What " +
        "the headline RMSE has beyond it is the model\u2019s."
  },
  {group: "Error", name: "MAE", unit: errorUnit, get: inUnits(metric("mae")), help: "mae: (1/n) sum |e|"}, {
    group: "Error",
    name: "bias",
    unit: errorUnit,
    get: inUnits(metric("bias")),
    signed: true,
    help: "bias: (1/n) sum e; + is too bright"
  },
  {group: "Error", name: "p50", unit: errorUnit, get: inUnits(metric("p50")), help: "p50: median of |e|"}, {
    group: "Error",
    name: "p95",
    unit: errorUnit,
    get: inUnits(metric("p95")),
    help: "p95: 95 % quantile of |e|"
  },
  {
    group: "Error",
    name: "p99",
    unit: errorUnit,
    get: inUnits(metric("p99")),
    help: "p99: 99 % quantile of |e|"
  },
  {group: "Error", name: "max", unit: errorUnit, get: inUnits(metric("max")), help: "max: largest |e|"},
  {
    group: "Error",
    name: "FLIP",
    unit: "",
    get: flip("flip"),
    help: "flip: mean over skin of LDR-FLIP, 0 to 1, with the largest irradiance as the display\u2019s white " +
        "(Andersson et al. 2020; 67 pixels a degree)"
  },
  {
    group: "Error",
    name: "HDR-FLIP",
    unit: "",
    get: flip("flip_hdr"),
    help: "flip_hdr: mean over skin of the largest LDR-FLIP over exposures, from where the truth\u2019s " +
        "largest luminance to where its median is mapped to 0.85 (Andersson et al. 2021)"
  },
  {
    group: "Halo",
    name: "peak",
    unit: "%",
    get: inPercent(metric("halo.peak")),
    help: "halo.peak: largest |relative error| of a bin of \u03b4; of a bin: sum(test \u2212 truth) / " +
        "sum(truth)"
  },
  {
    group: "Halo",
    name: "width",
    unit: "mm",
    get: metric("halo.width_mm"),
    help: "halo.width_mm: smallest \u03b4 beyond which every bin up to 6s is within 1 %"
  },
  {
    group: "Halo",
    name: "energy",
    unit: "%",
    get: inPercent(metric("halo.energy")),
    help: "halo.energy: sum |e| within 3s of a silhouette / sum truth there"
  },
  {
    group: "Halo",
    name: "contrast",
    unit: "",
    get: metric("halo.contrast"),
    ranks: false,
    help: "halo.contrast: RMSE within 3s / RMSE beyond 6s"
  },
  ...(runs.some((run) => (run.metrics || {}).visible) ? SEEN_COLUMNS : []),
  ...(runs.some((run) => (run.metrics || {}).leak !== undefined) ? LEAK_COLUMNS : []), {
    group: "Cost",
    name: "frame",
    unit: "ms",
    get: cost("frame_ms.median"),
    paid: true,
    ranks: !timesShared,
    spread: true,
    help: "frame_ms: every pass that the method adds to the shared G-buffer; median [least..most]"
  },
  {
    group: "Cost",
    name: "set-up",
    unit: "ms",
    get: cost("setup_ms"),
    paid: true,
    ranks: !timesShared,
    help: "setup_ms: once, not per frame"
  },
  {
    group: "Cost",
    name: "passes",
    unit: "",
    get: cost("passes"),
    paid: true,
    format: count,
    help: "Draws per frame"
  },
  {
    group: "Cost",
    name: "fetches",
    unit: "/px",
    get: cost("fetches_per_pixel"),
    paid: true,
    help: "Texture fetches per skin pixel, counted by an instrumented, untimed run"
  },
  {
    group: "Cost",
    name: "bytes",
    unit: "/px",
    get: cost("bytes_per_pixel"),
    paid: true,
    format: count,
    help: "Stored texels read per skin pixel, in bytes; no cache model"
  }
];

const tableState = {
  channel: "luminance"
};
const columnKey = (column) => `${column.group}.${column.name}`.replaceAll(" ", "");

const sortHead = (key, text, attributes, unit) =>
    h("th", {"data-sort": key, ...attributes}, text, unit && h("small", {}, unit));

// The best of a column among a case's runs; nothing where there is no contest.
function bestOf(column, caseRuns, channel) {
  if (column.ranks === false) return null;
  const values = caseRuns.filter((run) => !(column.paid && isFree(run)))
                     .map((run) => column.get(run, channel).value)
                     .filter(isNumber)
                     .map(Math.abs);
  return values.length > 1 ? Math.min(...values) : null;
}

// Numbers of a column stand with their decimal points in line: the missing decimals become spaces as wide.
function decimalsOf(text) {
  const at = text.indexOf(".");
  return at < 0 ? 0 : text.length - at;
}

function aligned(text, most) {
  const missing = most - decimalsOf(text);
  if (missing <= 0) return text;
  const point = decimalsOf(text) === 0 ? "\u2008" : "";
  return text + point + "\u2007".repeat(missing - (point ? 1 : 0));
}

function valueCell(column, run, found, text, isBest, largest) {
  const title = [found.value === null ? found.reason : "", found.note || ""].filter(Boolean).join("; ");
  const spread =
      column.spread && [lookUp(run, "cost.frame_ms.min").value, lookUp(run, "cost.frame_ms.max").value];
  const free = column.paid && isFree(run) && column.name !== "passes";
  return h(
      "td", {
        class:
            [isBest ? "best" : "", found.value === null ? "dash" : "", title ? "noted" : ""].join(" ").trim(),
        title: title || null,
        "data-value": found.value === null ? "" : found.value
      },
      column.bar &&
          h("span", {class: "bar"}, h("i", {
              style: `width:${100 * (found.value || 0) / largest}%;background:${styleOf(run.label).colour}`
            })),
      h("span", {class: "value"}, free && found.value < 0.001 ? aligned("0", decimalsOf(text)) : text),
      spread && isNumber(spread[0]) && !isFree(run) &&
          h("small", {}, `${number(spread[0])}..${number(spread[1])}`));
}

function tableRows(c, channel) {
  const ordered = [...c.runs].sort(byError);
  const columns = COLUMNS.map((column) => {
    const found = ordered.map((run) => column.get(run, channel));
    const texts = found.map((f) => (column.format || number)(f.value, column.signed));
    const most = Math.max(0, ...texts.map(decimalsOf));
    return {
      column,
      found,
      texts: texts.map((t) => (t === EN_DASH ? t : aligned(t, most))),
      best: bestOf(column, ordered, channel),
      largest: Math.max(1e-12, ...found.map((f) => f.value || 0))
    };
  });
  return ordered.map(
      (run, i) =>
          h("tr", {},
            h("th", {scope: "row"}, methodName(run.label),
              !isDistinguishable(run) && h("div", {}, errorText(run))),
            columns.map(({column, found, texts, best: bestValue, largest}) => {
              const competes = !(column.paid && isFree(run));
              return valueCell(
                  column, run, found[i], texts[i],
                  competes && bestValue !== null && Math.abs(found[i].value) === bestValue &&
                      found[i].value !== null,
                  largest);
            })));
}

function skippedRows(c) {
  return c.all.filter((run) => run.skipped)
      .map(
          (run) =>
              h("tr", {class: "skipped"}, h("th", {scope: "row"}, methodName(run.label)),
                h("td", {colspan: COLUMNS.length}, "skipped: " + run.skipped)));
}

function tableHead() {
  const groups = unique(COLUMNS.map((column) => column.group));
  const isFirst = (column) => COLUMNS.find((other) => other.group === column.group) === column;
  return h(
      "thead", {},
      h("tr", {class: "groups"}, h("th", {}),
        groups.map(
            (group) => h("th", {colspan: COLUMNS.filter((column) => column.group === group).length}, group))),
      h("tr", {}, sortHead("method", "Method", {}),
        COLUMNS.map(
            (column) => sortHead(
                columnKey(column), column.name,
                {title: column.help, class: isFirst(column) ? "first-of-group" : ""},
                column.unit || "\u00a0"))));
}

// Why a dash stands where it does.
function dashNotes(c, channel) {
  const notes =
      c.runs.flatMap((run) => COLUMNS.map((column) => ({run, column, found: column.get(run, channel)})))
          .filter(({found}) => found.value === null)
          .map(({run, column, found}) => JSON.stringify([columnName(column), found.reason, run.label]));
  const byNote = new Map();
  for (const note of notes) {
    const [name, reason, label] = JSON.parse(note), key = `${name}: ${reason}`;
    byNote.set(key, [...(byNote.get(key) || []), label]);
  }
  return byNote.size > 0 &&
      h("p", {class: "dash-notes"},
        [...byNote].map(
            ([text, all]) =>
                `${EN_DASH} ${text} (${all.length === c.runs.length ? "all" : all.join(", ")}). `));
}

const columnName = (column) => ["Halo", "Leak", "Seen"].includes(column.group) ?
    `${column.group.toLowerCase()} ${column.name}` :
    column.group === "RMSE"                            ? `RMSE, ${column.name}` :
                                                         column.name;

function caseTable(c, channel) {
  return h(
      "div", {class: "case-table"},
      h("h3", {}, caseName(c),
        channel === "luminance" ? null : h("span", {class: "muted"}, ` ${channelName(channel)} channel`),
        h("span", {class: "muted"}, measuredNote(c))),
      h("div", {class: "scroll panel"},
        sortable(
            h("table", {class: "metrics"}, tableHead(), h("tbody", {}, tableRows(c, channel), skippedRows(c))),
            "metrics")),
      dashNotes(c, channel), fitTable(c, channel), pathTable(c));
}

function measuredNote(c) {
  const pixels = c.runs.map((run) => lookUp(run, "metrics.pixels").value).find(isNumber);
  const low = (c.truth || {}).low_mass_pixels;
  return `  ${count(pixels)} skin pixels` +
      (low > 0 ? `; ${count(low)} more with mass below 0.5 not measured` : "");
}

function definitions() {
  const entries = COLUMNS.map((column) => [columnName(column), column.help.replace(/^[a-z_0-9.]+: /, "")]);
  return h(
      "div", {class: "definitions"}, h("h3", {}, "How to read the columns"),
      h("p", {class: "muted"},
        "e = test \u2212 truth at each of the n skin pixels that are measured; luminance is 0.2126 R + 0.7152 G + " +
            "0.0722 B of linear light; quantiles are by nearest rank."),
      h("dl", {}, entries.map(([name, text]) => h("div", {}, h("dt", {}, name), h("dd", {}, text)))));
}

function showTables() {
  tableState.element.replaceChildren(...cases.map((c) => caseTable(c, tableState.channel)));
}

function tableSection() {
  tableState.element = h("div", {});
  if (saved.sort) {
    sortStates.set("metrics", {column: saved.sort.replace(/^-/, ""), descending: saved.sort.startsWith("-")});
  }
  showTables();
  const channel = choice("Channel", CHANNELS, tableState.channel, (value) => {
    tableState.channel = value;
    showTables();
  });
  return section(
      "metrics", "Metrics and costs",
      [
        h("b", {}, `Headline target: ${headlineTarget}`),
        ". Every table sorts by a click on a column\u2019s head, this one by relative RMSE until then; the best of each column is lit (methods without a pass do not " +
            "compete on cost). ",
        "Own-target RMSE is the filter\u2019s error, against the very integral that the method aims at; " +
            "the rest of the headline RMSE is the model\u2019s error, of aiming at that integral. ",
        `Errors are in units of irradiance${errorExponent === 0 ? "" : `, here ${errorUnit}`}. `, timingNote()
      ],
      h("div", {class: "controls"}, channel.element), tableState.element, definitions());
}
