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
      runs: runs.filter(
          (run) => run.view === fit.view && run.profile === profile.name && run.profile_error)
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

// {name, colour, dashed, points: [{x: count, y: percent}]}, what every sum has.
function termLines(group, channel) {
  const points = (part) => group.sums.map((sum) => {
    const y = relative(part(sum), channel);
    return y > 0 ? {x: sum.count, y} : null;
  });
  const run = (sum, label) => sum.runs.find((r) => r.label === label) || {};
  const methods = unique(group.sums.flatMap((sum) => sum.runs.map((r) => r.label)));
  return [
    {name: "the Gaussians alone", colour: "var(--ink)", points: points((sum) => sum.fit)},
    ...methods.flatMap((label) => [{
                         name: label,
                         colour: styleOf(label).colour,
                         points: points((sum) => run(sum, label).profile_error)
                       }, {
                         name: "",
                         colour: styleOf(label).colour,
                         dashed: true,
                         points: points((sum) => (run(sum, label).profile_error || {}).convolution)
                       }])
  ].filter((line) => line.points.some(Boolean));
}

// A chart's frame, the lines and numbers of its two axes ({ticks, at: tick -> position, text}), and what they are.
function chartAxes(size, frame, vertical, horizontal) {
  return s(
      "g", {class: "axes"},
      vertical.ticks.map(
          (tick) => [s("line", {
                       class: "grid",
                       x1: frame.left,
                       x2: frame.right,
                       y1: vertical.at(tick),
                       y2: vertical.at(tick)
                     }),
                     s("text", {x: frame.left - 8, y: vertical.at(tick) + 4, "text-anchor": "end"},
                       String(tick))]),
      horizontal.ticks.map(
          (tick) => s("text", {x: horizontal.at(tick), y: frame.bottom + 17, "text-anchor": "middle"},
                      String(tick))),
      s("rect", {
        class: "frame",
        x: frame.left,
        y: frame.top,
        width: frame.right - frame.left,
        height: frame.bottom - frame.top
      }),
      s("text",
        {class: "label", x: (frame.left + frame.right) / 2, y: size.height - 6, "text-anchor": "middle"},
        horizontal.text),
      s("text", {
        class: "label",
        "text-anchor": "middle",
        transform: `translate(13,${(frame.top + frame.bottom) / 2}) rotate(-90)`
      },
        vertical.text));
}

// Labels at the lines' ends, apart from each other.
function endLabels(lines, y, frame) {
  const named = lines.filter((line) => line.name && line.points[line.points.length - 1])
                    .map((line) => ({...line, at: y(line.points[line.points.length - 1].y)}))
                    .sort((a, b) => a.at - b.at);
  let last = -Infinity;
  return named.map((line) => {
    last = Math.max(line.at, last + 14);
    return s("text", {class: "direct", x: frame.right + 8, y: last + 4, fill: line.colour}, line.name);
  });
}

function termsChart(group, channel) {
  const frame =
      {left: TERMS.left, right: TERMS.width - TERMS.right, top: TERMS.top, bottom: TERMS.height - TERMS.bottom};
  const lines = termLines(group, channel), counts = unique(group.sums.map((sum) => sum.count));
  const domain = logDomain(lines.flatMap((line) => line.points.filter(Boolean).map((p) => p.y)), 1.3);
  const least = Math.min(...counts), most = Math.max(...counts);
  const x = (count) => frame.left + 14 + (frame.right - frame.left - 28) * (count - least) / (most - least);
  const y = logScale(domain, frame.bottom, frame.top);
  return s(
      "svg", {
        class: "chart",
        viewBox: `0 0 ${TERMS.width} ${TERMS.height}`,
        role: "img",
        "aria-label": `Error against the number of Gaussians, ${group.of}, ${group.view}`
      },
      chartAxes(
          TERMS, frame, {ticks: logTicks(domain), at: y, text: "RMSE / RMS of the profile\u2019s truth, %"},
          {ticks: counts, at: x, text: "Gaussians"}),
      lines.map((line) => [
        s("path", {
          d: linePath(line.points, x, y),
          fill: "none",
          stroke: line.colour,
          "stroke-width": line.name === "the Gaussians alone" ? 2.5 : 1.6,
          "stroke-dasharray": line.dashed ? "5 4" : null
        }),
        line.points.filter(Boolean).map(
            (p) => s("circle", {cx: x(p.x), cy: y(p.y), r: 2.5, fill: line.colour},
                     s("title", {}, `${line.name || "its convolution alone"}: ${number(p.y)} %`)))
      ]),
      endLabels(lines, y, frame));
}

// Where more Gaussians stop paying: the fewest whose own error is below a method's convolution error.
function termsSentence(group, channel) {
  const enough = [];
  for (const line of termLines(group, channel).filter((l) => l.dashed)) {
    const method = termLines(group, channel).find((l) => l.name && l.colour === line.colour && !l.dashed);
    const own = termLines(group, channel)[0].points;
    const found = line.points.find((p, i) => p && own[i] && own[i].y < p.y);
    if (method) enough.push([method.name, found ? found.x : null]);
  }
  return enough
      .map(
          ([name, count]) => count === null ? `${name}: more than shown` :
                                              `${name}: ${plural(count, "Gaussian")}`)
      .join("; ");
}

function termsSection() {
  const groups = termGroups();
  if (groups.length === 0) return null;
  const cards = (channel) => groups.map(
      (group) => h(
          "div", {class: "panel card"}, h("h3", {}, `${group.of}, ${group.view}`), termsChart(group, channel),
          h("p", {class: "muted"}, "The fewest Gaussians whose own error is below what the convolution errs by: ",
            termsSentence(group, channel), ".")));
  const body = h("div", {class: "charts"}, cards("luminance"));
  const channel =
      choice("Channel", CHANNELS, "luminance", (value) => body.replaceChildren(...cards(value)));
  return section(
      "terms", "How many Gaussians",
      "Solid: a method against the truth of the profile itself. Dashed: its convolution alone, against the " +
          "truth of its own Gaussians. Thick: those Gaussians\u2019 truth against the profile\u2019s. Where the " +
          "thick line lies below a dashed one, more Gaussians buy nothing.",
      h("div", {class: "controls"}, channel.element), body);
}
