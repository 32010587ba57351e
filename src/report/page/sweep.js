// Where methods break: curves of error along one difficulty, the table of where they pass 2, 5 and 10 %, and
// how their errors spread over views.

const sweep = results.sweep;
const BREAK_LEVELS = ["2%", "5%", "10%"];
const SWEEP = {
  width: 760,
  height: 340,
  left: 58,
  right: 190,
  top: 14,
  bottom: 44
};
const SWEEP_QUANTITIES = [
  {value: "rel_rmse", text: "relative RMSE", unit: "%", scale: 100, levels: true},
  {value: "own_rel_rmse", text: "against its own target", unit: "%", scale: 100, levels: true},
  {value: "halo_peak", text: "halo peak", unit: "%", scale: 100},
  {value: "p99", text: "99 % quantile", unit: "", scale: 1},
  {value: "max", text: "largest", unit: "", scale: 1},
  ...hasSeen ? [{value: "visible_mean", text: "FLIP as seen, mean", unit: "", scale: 1}] : []
];

// Curves of one view under one profile belong in one chart.
const sweepGroups = () => unique(list((sweep || {}).curves).map((curve) => JSON.stringify([
                            curve.view, curve.profile
                          ]))).map((key) => {
  const [view, profile] = JSON.parse(key);
  return {view, profile, curves: sweep.curves.filter((c) => c.view === view && c.profile === profile)};
});
const sweepUnit = () => (sweep.unit ? " " + sweep.unit : "");

// From left to right: from easy to hard.
function sweepAxis(axis) {
  return withRoom(
      {
        title: sweep.title + (sweep.unit ? ", " + sweep.unit : "") + "; harder to the right",
        scale: sweep.scale === "log" ? "log" : "linear",
        from: axis[0],
        to: axis[axis.length - 1],
        wanted: 8,
        prefix: sweep.title + " ",
        suffix: sweepUnit()
      },
      0.02);
}

function sweepSeries(group, curve, quantity) {
  const {colour, dash, shape} = styleOf(curve.label);
  const points = curve.points.map((point) => {
    const y = Math.abs(quantity.scale * point[quantity.value]);
    const c = cases.find((other) => other.view === point.view && other.profile === group.profile);
    return {
      x: point.axis,
      y: isNumber(point[quantity.value]) && y > 0 ? y : null,
      tip: `${curve.label}  ${number(y)} ${quantity.unit}`.trim(),
      pick: c && (() => openViewer(c, curve.label, "magnitude"))
    };
  });
  return {name: curve.label, colour, dash, line: 1.6, marker: shape, size: DOT, points};
}

function sweepChart(group, quantity) {
  const series = group.curves.map((curve) => sweepSeries(group, curve, quantity))
                     .filter((one) => drawnPoints(one).length > 0);
  if (series.length === 0) return h("p", {class: "empty"}, "not measured");
  const [from, to] = logDomain(series.flatMap((one) => drawnPoints(one).map((point) => point.y)), 1.3);
  const y = {title: quantity.text + (quantity.unit ? ", " + quantity.unit : ""), scale: "log", from, to};
  const levels = quantity.levels ? BREAK_LEVELS.filter((level) => isOn(y, parseFloat(level))) : [];
  return chartElement({
    name: `${quantity.text} against ${sweep.title}`,
    attributes: {class: "sweep"},
    size: SWEEP,
    x: sweepAxis(group.curves[0].points.map((point) => point.axis)),
    y,
    hover: "column",
    named: true,
    levels: levels.map((level) => ({axis: "y", at: parseFloat(level), kind: "level", text: level})),
    series
  });
}

function breakCell(breaks, level) {
  const reason = breaks[level + "_reason"];
  if (isNumber(breaks[level]))
    return h("td", {"data-value": breaks[level]}, number(breaks[level]) + sweepUnit());
  return h("td", {class: "muted", title: reason}, (reason || "").split(":")[0]);
}

function breakTable(group) {
  return h(
      "div", {class: "scroll panel"},
      sortable(
          h("table", {class: "metrics breaks"},
            h("thead", {},
              h("tr", {}, h("th", {}), h("th", {colspan: 3}, "Relative RMSE passes"),
                h("th", {colspan: 3}, "That against its own target passes"), h("th", {})),
              h("tr", {},
                ["Method", ...BREAK_LEVELS, ...BREAK_LEVELS, "curve"].map((text) => h("th", {}, text)))),
            h("tbody", {},
              group.curves.map(
                  (curve) =>
                      h("tr", {}, h("th", {scope: "row"}, methodName(curve.label)),
                        BREAK_LEVELS.map((level) => breakCell(curve.breaks_at, level)),
                        BREAK_LEVELS.map((level) => breakCell(curve.own_breaks_at, level)),
                        h("td", {}, curve.only_rises ? "rises" : "falls somewhere"))))),
          "breaks"));
}

function sweepSection() {
  if (!sweep) return null;
  const groups = sweepGroups();
  const cards = (name) => groups.map(
      (group) =>
          h("div", {class: "panel card"},
            groups.length > 1 ? h("h3", {}, `${group.view}, ${profileTitle(group.profile)}`) : null,
            sweepChart(group, SWEEP_QUANTITIES.find((quantity) => quantity.value === name))));
  const body = h("div", {}, cards("rel_rmse"));
  const quantity =
      choice("Error", SWEEP_QUANTITIES, "rel_rmse", (value) => body.replaceChildren(...cards(value)));
  return section(
      "sweep", "Where each method breaks",
      "One difficulty, from easy to hard. A method breaks where its error first passes a level, interpolated " +
          "between the values around it. Where the error against its own target stays small, it is the model " +
          "that breaks, else the filter. A click on the chart shows the pictures of that place.",
      h("div", {class: "controls"}, quantity.element), body, chartNote(), groups.map(breakTable));
}

// --- over views ---

const STABILITY_KINDS = {
  orbit: "view dependence (orbit)",
  dolly: "flicker (dolly)",
  jitter: "flicker (jitter)"
};
const stabilityRuns = runs.filter((run) => (run.metrics || {}).stability);

function stabilityTable(c) {
  const kinds = Object.keys(STABILITY_KINDS).filter((kind) => c.some((run) => run.metrics.stability[kind]));
  const cell = (run, kind, key) => {
    const found = lookUp(run.metrics.stability, `${kind}.${key}`);
    return h(
        "td", {
          title: found.value === null ? found.reason : null,
          "data-value": found.value === null ? "" : found.value
        },
        found.value === null ? EN_DASH : percent(found.value));
  };
  return h(
      "div", {class: "scroll panel"},
      sortable(
          h("table", {class: "metrics"},
            h("thead", {},
              h("tr", {}, h("th", {}), kinds.map((kind) => h("th", {colspan: 3}, STABILITY_KINDS[kind]))),
              h("tr", {},
                ["Method", ...kinds.flatMap(() => ["RMS", "95 %", "max"])].map((text) => h("th", {}, text)))),
            h("tbody", {},
              c.map(
                  (run) => h(
                      "tr", {}, h("th", {scope: "row"}, methodName(run.label)),
                      kinds.map(
                          (kind) => ["rel_rms", "rel_p95", "rel_max"].map((key) => cell(run, kind, key))))))),
          "stability"));
}

function stabilitySection() {
  if (stabilityRuns.length === 0) return null;
  const tables =
      cases.map((c) => ({c, of: c.runs.filter((run) => run.metrics.stability)}))
          .filter(({of}) => of.length > 0)
          .map(({c, of}) => h("div", {class: "case-table"}, h("h3", {}, caseName(c)), stabilityTable(of)));
  return section(
      "stability", "Over views",
      "True convolution depends on the surface alone. Points of it are followed through views derived from " +
          "this one; at each, the standard deviation over the views that see it of test \u2212 truth, the truth " +
          "taken at each pixel\u2019s own surface point. RMS, 95 % quantile and maximum over the points, relative " +
          "to the RMS of the truth.",
      tables);
}
