// How many Gaussians a profile takes: where several sums of Gaussians stand for one profile, the error of the
// sums themselves, of a method's convolution with them, and both together, against their number.

const TERMS = {
  width: 590,
  height: 320,
  left: 58,
  right: 150,
  top: 14,
  bottom: 44
};

// Of one view and one profile: [{count, profile, fit, runs}], by count.
function termGroups() {
  const groups = new Map();
  for (const fit of fitErrors) {
    const profile = profileOf(fit.profile), of = (profile.of || {}).title;
    if (!of || list(profile.gaussians).length === 0) continue;
    const key = JSON.stringify([fit.view, of]);
    if (!groups.has(key)) groups.set(key, {view: fit.view, of, sums: []});
    groups.get(key).sums.push({
      count: profile.gaussians.length,
      profile: profile.name,
      fit,
      runs: runs.filter((run) => run.view === fit.view && run.profile === profile.name && run.profile_error)
    });
  }
  return [...groups.values()]
      .map((group) => ({...group, sums: [...group.sums].sort((a, b) => a.count - b.count)}))
      .filter((group) => unique(group.sums.map((sum) => sum.count)).length > 1);
}

const relative = (part, channel) => {
  const value = lookUp(channelOf((part || {}).metrics, channel), "rel_rmse").value;
  return isNumber(value) ? 100 * value : null;
};

// The sums alone, then of each method both together and, dashed, its convolution; what every sum has.
function termSeries(group, channel) {
  const points = (name, part, run) => group.sums.map((sum) => {
    const y = relative(part(sum), channel), of = run && run(sum);
    return {
      x: sum.count,
      y: y > 0 ? y : null,
      tip: `${name}  ${number(y)} %`,
      pick: of && (() => showRun(of))
    };
  });
  const methods = unique(group.sums.flatMap((sum) => sum.runs.map((r) => r.label)));
  const ofMethod = (label) => {
    const {colour, shape} = styleOf(label), run = (sum) => sum.runs.find((r) => r.label === label);
    const error = (sum) => (run(sum) || {}).profile_error,
          convolution = (sum) => (error(sum) || {}).convolution;
    const shared = {colour, line: 1.6, marker: shape, size: DOT};
    return [
      {name: label, ...shared, points: points(label, error, run)}, {
        name: "",
        of: label,
        ...shared,
        dash: "5 4",
        points: points(`${label}, its convolution alone`, convolution, run)
      }
    ];
  };
  const alone = "the Gaussians alone";
  return [
    {
      name: alone,
      colour: "var(--ink)",
      line: 2.5,
      marker: "circle",
      size: DOT,
      points: points(alone, (sum) => sum.fit)
    },
    ...methods.flatMap(ofMethod)
  ].filter((series) => drawnPoints(series).length > 0);
}

function termsChart(group, channel) {
  const series = termSeries(group, channel), counts = unique(group.sums.map((sum) => sum.count));
  const [from, to] = logDomain(series.flatMap((one) => drawnPoints(one).map((point) => point.y)), 1.3);
  return chartElement({
    name: `Error against the number of Gaussians, ${group.of}, ${group.view}`,
    attributes: {class: "terms"},
    size: TERMS,
    x: withRoom(
        {
          title: "Gaussians",
          scale: "linear",
          from: Math.min(...counts),
          to: Math.max(...counts),
          ticks: counts,
          prefix: "Gaussians: "
        },
        0.04),
    y: {title: "RMSE / RMS of the profile\u2019s truth, %", scale: "log", from, to},
    hover: "column",
    named: true,
    series
  });
}

// Where more Gaussians stop paying: the fewest whose own error is below a method's convolution error.
function termsSentence(group, channel) {
  const [alone, ...others] = termSeries(group, channel);
  const own = (x) => (alone.points.find((point) => point.x === x) || {}).y;
  return others.filter((series) => series.of)
      .map((series) => {
        const found = drawnPoints(series).find((point) => isNumber(own(point.x)) && own(point.x) < point.y);
        return `${series.of}: ${found ? plural(found.x, "Gaussian") : "more than shown"}`;
      })
      .join("; ");
}

function termsSection() {
  const groups = termGroups();
  if (groups.length === 0) return null;
  const cards = (channel) => groups.map(
      (group) => h(
          "div", {class: "panel card"}, h("h3", {}, `${group.of}, ${group.view}`), termsChart(group, channel),
          h("p", {class: "muted"},
            "The fewest Gaussians whose own error is below what the convolution errs by: ",
            termsSentence(group, channel), ".")));
  const body = h("div", {class: "charts"}, cards("luminance"));
  const channel = choice("Channel", CHANNELS, "luminance", (value) => body.replaceChildren(...cards(value)));
  return section(
      "terms", "How many Gaussians",
      "Solid: a method against the truth of the profile itself. Dashed: its convolution alone, against the " +
          "truth of its own Gaussians. Thick: those Gaussians\u2019 truth against the profile\u2019s. Where the " +
          "thick line lies below a dashed one, more Gaussians buy nothing.",
      h("div", {class: "controls"}, channel.element), body, chartNote());
}
