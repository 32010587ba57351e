// The Pareto front of a grid of settings: what several sums of Gaussians for one diffusion profile, and
// several sizes of one camera's frame, are settings of, beside the methods' own. One chart by time, by
// fetches and by bytes, the fronts numbered alike in all three.

// Cases of one camera and one diffusion profile: [{name, cases, sizes, sums, pixels}].
function paretoGroups() {
  const groups = new Map();
  for (const c of cases) {
    const view = viewOf(c.view), of = (profileOf(c.profile).of || {}).title;
    const camera = view.camera ? JSON.stringify(view.camera) : c.view;
    const key = JSON.stringify([camera, of || c.profile]);
    if (!groups.has(key)) groups.set(key, {of: of || profileTitle(c.profile), cases: []});
    groups.get(key).cases.push(c);
  }
  return [...groups.values()].map(
      (group) => ({
        ...group,
        name: `${unique(group.cases.map((c) => c.view)).join(" and ")}, ${group.of}`,
        sizes: unique(group.cases.map((c) => c.view)).length,
        sums: unique(group.cases.map((c) => c.profile)).length,
        pixels: Math.max(...group.cases.map((c) => viewOf(c.view).skin_pixels || 0))
      }));
}

// Against the truth of the diffusion profile itself where there is one: leaving Gaussians out is paid for.
const settingError = (run) =>
    run.profile_error ? lookUp(run, "profile_error.metrics.rel_rmse").value : relativeError(run);

function settingName(group, run) {
  const gaussians = list(profileOf(run.profile).gaussians).length, view = viewOf(run.view);
  return [
    run.label, group.sums > 1 && (gaussians > 0 ? plural(gaussians, "Gaussian") : run.profile),
    group.sizes > 1 && `${view.width_px}${TIMES}${view.height_px}`
  ].filter(Boolean)
      .join(", ");
}

// What a setting costs: all of a frame, over the skin"s pixels of its camera's largest one.
const frameShare = (group, run) => (viewOf(run.view).skin_pixels || 0) / (group.pixels || 1);
const PARETO_AXES = [
  {key: "time", label: "Frame time, ms", whiskers: true, cost: (group, run) => frameMs(run)}, {
    key: "fetches",
    label: "Texture fetches per skin pixel",
    cost: (group, run) => isNumber(fetches(run)) ? frameShare(group, run) * fetches(run) : null
  },
  {
    key: "bytes",
    label: "Bytes per skin pixel",
    cost: (group, run) => {
      const bytes = lookUp(run, "cost.bytes_per_pixel").value;
      return isNumber(bytes) ? frameShare(group, run) * bytes : null;
    }
  }
];

// [{run, name, error: percent, costs: {time, fetches, bytes}}]; a free run costs nothing.
function settingsOf(group) {
  return group.cases.flatMap((c) => c.runs)
      .filter((run) => settingError(run) > 0 && run.cost)
      .map((run) => ({
             run,
             name: settingName(group, run),
             error: 100 * settingError(run),
             costs: Object.fromEntries(
                 PARETO_AXES.map((axis) => [axis.key, isFree(run) ? 0 : axis.cost(group, run)]))
           }));
}

const frontBy = (settings, key) =>
    paretoFront(
        settings.filter((x) => isNumber(x.costs[key])).map((x) => ({...x, setting: x, cost: x.costs[key]})))
        .map((point) => point.setting);

// Every setting on some front, by time: [{setting, number, on: {time, fetches, bytes}}].
function frontsOf(settings) {
  const fronts = PARETO_AXES.map((axis) => ({key: axis.key, front: frontBy(settings, axis.key)}));
  return unique(fronts.flatMap((f) => f.front))
      .sort((a, b) => a.costs.time - b.costs.time || b.error - a.error)
      .map((setting, i) => ({
             setting,
             number: i + 1,
             on: Object.fromEntries(fronts.map((f) => [f.key, f.front.includes(setting)]))
           }));
}

const settingTip = (group, x) => [x.name, `error ${number(x.error)} %`, runTip(x.run)].join("\n");

// What has a colour and a shape of its own.
const kindsOf = (settings) => unique(settings.map((setting) => methodOf.get(setting.run.label)));

function paretoPoint(group, setting, axis, numbered) {
  return {
    x: setting.costs[axis.key],
    y: setting.error,
    tip: settingTip(group, setting),
    hollow: !isDistinguishable(setting.run),
    faint: !numbered,
    label: numbered && String(numbered.number),
    pick: () => showRun(setting.run),
    ...(axis.whiskers && numbered ? runWhisker(setting.run) : {})
  };
}

function paretoChart(group, settings, fronts, axis, yDomain) {
  const paid = settings.filter((setting) => setting.costs[axis.key] > 0);
  const ends = axis.whiskers ? paid.map((setting) => runWhisker(setting.run)) : [];
  const domain =
      logDomain([...paid.map((setting) => setting.costs[axis.key]), ...ends.flatMap(Object.values)], 1.35);
  const x = {title: axis.label, scale: "log", from: domain[0], to: domain[1]};
  const y = {title: "RMSE / RMS of truth, %", scale: "log", from: yDomain[0], to: yDomain[1]};
  const front = fronts.filter((f) => f.on[axis.key])
                    .map((f) => ({...f, cost: f.setting.costs[axis.key], error: f.setting.error}))
                    .sort((a, b) => a.cost - b.cost);
  return chartElement({
    name: `${axis.label} against relative RMSE, ${group.name}`,
    attributes: {class: "pareto", "data-axis": axis.key},
    size: SCATTER,
    x,
    y,
    hover: "point",
    levels: thresholdLevels(y),
    series: [
      frontSeries(front, x, y), ...kindsOf(paid).map((name) => {
        const {colour, shape} = styleOf(name);
        return {
          name,
          colour,
          marker: shape,
          size: 0.6,
          points: paid.filter((setting) => methodOf.get(setting.run.label) === name)
                      .map(
                          (setting) =>
                              paretoPoint(group, setting, axis, front.find((f) => f.setting === setting)))
        };
      })
    ]
  });
}

function frontTable(group, fronts) {
  const time = (run) =>
      [number(frameMs(run)),
       h("span", {class: "muted"},
         ` (${number(lookUp(run, "cost.frame_ms.min").value)}..${
             number(lookUp(run, "cost.frame_ms.max").value)})`)];
  const cell = (f, key, content) =>
      h("td", {"data-front": f.on[key] ? key : null}, content,
        f.on[key] && h("b", {title: "on this front"}, " \u25cf"));
  return h(
      "div", {class: "scroll"},
      sortable(
          h("table", {class: "fronts"},
            h("caption", {},
              "The fronts; \u25cf: nothing is better in both. Error in % of the truth\u2019s RMS, time in ms " +
                  "(least..most), fetches and bytes per skin pixel."),
            h("thead", {},
              h("tr", {},
                ["No.", "Setting", "Error", "Time", "Fetches", "Bytes"].map(
                    (t) => h("th", {scope: "col"}, t)))),
            h("tbody", {},
              fronts.map(
                  (f) =>
                      h("tr", {}, h("td", {}, String(f.number)),
                        h("th", {scope: "row"}, swatch(f.setting.run.label), " ", f.setting.name),
                        h("td", {}, number(f.setting.error)),
                        cell(f, "time", isFree(f.setting.run) ? "no pass" : time(f.setting.run)),
                        cell(f, "fetches", number(f.setting.costs.fetches)),
                        cell(f, "bytes", count(f.setting.costs.bytes)))))),
          "fronts"));
}

// Where the fronts by time and by fetches disagree: what is on one alone, and the pair of settings, one from
// either, whose order by time contradicts that by fetches the most.
function frontsSentence(fronts) {
  const only = (a, b) => fronts.filter((f) => f.on[a] && !f.on[b]);
  const time = only("time", "fetches"), work = only("fetches", "time");
  if (time.length + work.length === 0) return "The fronts by time and by fetches hold the same settings.";
  const parts = [`By time the front holds ${fronts.filter((f) => f.on.time).length} settings, by fetches ${
      fronts.filter((f) => f.on.fetches).length}; ${
      fronts.filter((f) => f.on.time && f.on.fetches).length} are on both.`];
  let worst = null;
  for (const a of fronts.filter((f) => f.on.time)) {
    for (const b of fronts.filter((f) => f.on.fetches)) {
      const [ta, tb] = [a.setting.costs.time, b.setting.costs.time],
                 [fa, fb] = [a.setting.costs.fetches, b.setting.costs.fetches];
      const size = ta > 0 && fb > 0 ? Math.min(Math.log(tb / ta), Math.log(fa / fb)) : 0;
      if (size > 0.05 && (!worst || size > worst.size)) worst = {a: a.setting, b: b.setting, size};
    }
  }
  if (worst) {
    const {a, b} = worst;
    parts.push(`They rank differently most of all where ${a.name} takes less time than ${b.name} (${
        number(a.costs.time)} against ${number(b.costs.time)} ms) with more fetches (${
        number(a.costs.fetches)} against ${number(b.costs.fetches)}).`);
  }
  return parts.join(" ");
}

function paretoCard(group) {
  const settings = settingsOf(group);
  if (settings.length === 0) return null;
  const fronts = frontsOf(settings);
  const yDomain = logDomain(settings.filter((x) => x.costs.time > 0).map((x) => x.error), 1.35);
  return h(
      "div", {class: "pair pareto-card"}, h("h3", {}, group.name),
      h("p", {class: "lead", style: "grid-column: 1 / -1"}, `${settings.length} settings. `,
        group.sums > 1 && "Errors are against the truth of the profile itself. ",
        group.sizes > 1 &&
            "A smaller frame\u2019s error is over its own pixels; its cost is over those of the largest. ",
        h("span", {class: "fronts-sentence"}, frontsSentence(fronts))),
      PARETO_AXES.map(
          (axis) => h("figure", {class: "panel"}, paretoChart(group, settings, fronts, axis, yDomain))),
      h("figure", {class: "panel legend kinds"},
        kindsOf(settings).map((name) => h("span", {class: "method", title: name}, swatch(name), name))),
      h("figure", {class: "panel", style: "grid-column: 1 / -1; white-space: nowrap"},
        frontTable(group, fronts)));
}
