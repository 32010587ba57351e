// Halo profiles: relative error against the distance to the nearest silhouette.

const HALO = {
  width: 300,
  height: 220,
  left: 44,
  right: 8,
  top: 22,
  bottom: 38
};
const HALO_SIDES = [
  {path: "halo", title: "All silhouettes"}, {path: "halo.outer.near", title: "Outer, against the background"},
  {path: "halo.inner.near", title: "Inner, near side"}, {path: "halo.inner.far", title: "Inner, far side"}
];
const HALO_WITHIN = 1;  // percent; the bound of the halo's width

function haloOf(run, side, channel) {
  return side.path.split(".").reduce((object, key) => (object || {})[key], channelOf(run.metrics, channel)) ||
      {};
}

// By bin; null where it has no light, undefined where it has no pixel.
function haloPoints(run, side, channel) {
  const profile = haloOf(run, side, channel).profile || {}, pixels = list(profile.pixels);
  return list(profile.relative_error)
      .map(
          (error, i) =>
              (isNumber(error) && isNumber(profile.bin_mm) ? {x: (i + 0.5) * profile.bin_mm, y: 100 * error} :
                   pixels[i] === 0                         ? undefined :
                                                             null));
}

// Broken where a bin has no light; a bin between two such is a dot.
function linePath(points, x, y) {
  let path = "", pen = "M";
  for (const point of points) {
    if (point) path += `${pen}${x(point.x).toFixed(1)},${y(point.y).toFixed(1)}${pen === "M" ? "h0" : ""}`;
    pen = point ? "L" : "M";
  }
  return path;
}

function linearTicks([low, high], wanted) {
  const rough = (high - low) / wanted, decade = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((m) => m * decade).find((m) => m >= rough);
  const ticks = [];
  for (let i = Math.ceil(low / step); i * step <= high + 1e-9; ++i)
    ticks.push(Number((i * step).toPrecision(6)));
  return ticks;
}

// Linear within about 1 %, logarithmic beyond: a halo of 40 % and one of 1 % are both to be seen.
const haloScale = (value) => Math.asinh(value / HALO_WITHIN);

function haloTicks([low, high]) {
  const sizes = [1, 3, 10, 30, 100, 300, 1000];
  return [...sizes.map((tick) => -tick), 0, ...sizes].filter((tick) => tick >= low && tick <= high);
}

function haloRange(c, channel, sides = HALO_SIDES) {
  const all = sides.flatMap((side) => c.runs.flatMap((run) => haloPoints(run, side, channel)))
                  .filter(Boolean)
                  .map((p) => p.y);
  return [1.15 * Math.min(-1.6, ...all), 1.15 * Math.max(1.6, ...all)];
}

const signedText = (value) => (value < 0 ? MINUS + Math.abs(value) : value > 0 ? "+" + value : "0");

function haloAxes(x, y, yRange, xMax, widest, frame, line) {
  const marks = [1, 3, 6].filter((m) => m * widest <= xMax * 1.001);
  return s(
      "g", {class: "axes"}, s("rect", {
        class: "within",
        x: frame.left,
        width: frame.right - frame.left,
        y: y(HALO_WITHIN),
        height: y(-HALO_WITHIN) - y(HALO_WITHIN)
      }),
      haloTicks(yRange).map(
          (tick) =>
              [s("line", {
                 class: tick === 0 ? "zero" : "grid",
                 x1: frame.left,
                 x2: frame.right,
                 y1: y(tick),
                 y2: y(tick)
               }),
               s("text", {x: frame.left - 6, y: y(tick) + 4, "text-anchor": "end"}, signedText(tick))]),
      marks.map(
          (m) =>
              [s("line",
                 {class: "mark", x1: x(m * widest), x2: x(m * widest), y1: frame.top, y2: frame.bottom}),
               s("text", {
                 class: "note",
                 x: x(m * widest) - (m === 6 ? 3 : 0),
                 y: frame.top - 5,
                 "text-anchor": m === 6 ? "end" : "middle"
               },
                 (m === 1 ? "" : m) + "s")]),
      linearTicks([0, xMax], 5)
          .map(
              (tick) => s("text", {x: x(tick), y: frame.bottom + 15, "text-anchor": "middle"}, String(tick))),
      s("text", {class: "label", x: frame.left - 6, y: frame.top - 5, "text-anchor": "end"}, "%"),
      s("text",
        {class: "label", x: (frame.left + frame.right) / 2, y: HALO.height - 4, "text-anchor": "middle"},
        `\u03b4, mm from the ${line}`));
}

// The run with the largest peak is named on the chart itself.
function peakLabel(lines, x, y, frame) {
  const peaks = lines.flatMap(({run, points}) => points.filter(Boolean).map((p) => ({run, ...p})));
  const peak = peaks.sort((a, b) => Math.abs(b.y) - Math.abs(a.y))[0];
  if (!peak || Math.abs(peak.y) < HALO_WITHIN) return null;
  const px = Math.min(Math.max(x(peak.x) + 8, frame.left + 8), frame.right - textWidth(peak.run.label, 11));
  const py = Math.min(Math.max(y(peak.y) + 4, frame.top + 12), frame.bottom - 5);
  return s(
      "text", {class: "direct small", x: px, y: py, fill: styleOf(peak.run.label).colour}, peak.run.label);
}

// A strip over each bin, which tells all methods' values there.
function haloStrips(lines, x, frame) {
  const bins = Math.max(...lines.map(({points}) => points.length));
  return Array.from({length: bins}, (_, i) => {
    const there = lines.filter(({points}) => points[i]);
    if (there.length === 0) return null;
    const at = there[0].points[i].x, half = at / (2 * i + 1);
    const texts =
        there.map(({run, points}) => `${run.label}  ${signedText(Number(points[i].y.toPrecision(3)))} %`);
    return s("rect", {
      class: "strip",
      x: x(at - half),
      width: x(at + half) - x(at - half),
      y: frame.top,
      height: frame.bottom - frame.top,
      "data-tip": [`\u03b4 ${number(at - half)} to ${number(at + half)} mm`, ...texts].join("\n")
    });
  });
}

function haloChart(c, side, channel, yRange) {
  const frame =
      {left: HALO.left, right: HALO.width - HALO.right, top: HALO.top, bottom: HALO.height - HALO.bottom};
  const lines = c.runs.map((run) => ({run, points: haloPoints(run, side, channel)}))
                    .filter((line) => line.points.some(Boolean));
  if (lines.length === 0) {
    const reasons = c.runs.map((run) => haloOf(run, side, channel).peak_reason).filter(Boolean);
    return h("p", {class: "empty"}, reasons[0] || "no silhouette of this kind in this view");
  }
  const widest = profileOf(c.profile).widest_std_dev_mm;
  const xMax =
      Math.max(6 * (widest || 0), ...lines.flatMap((line) => line.points.filter(Boolean).map((p) => p.x)));
  const x = (v) => frame.left + (frame.right - frame.left) * v / xMax;
  const y = (v) => frame.bottom -
      (frame.bottom - frame.top) * (haloScale(v) - haloScale(yRange[0])) /
          (haloScale(yRange[1]) - haloScale(yRange[0]));
  return s(
      "svg", {
        class: "chart",
        viewBox: `0 0 ${HALO.width} ${HALO.height}`,
        role: "img",
        "aria-label": `${side.title}, ${caseName(c)}`
      },
      haloAxes(x, y, yRange, xMax, widest, frame, side.line || "silhouette"),
      lines.map(
          ({run, points}) =>
              s("path", {
                class: "line",
                d: linePath(points.filter((point) => point !== undefined), x, y),
                stroke: styleOf(run.label).colour,
                "stroke-dasharray": styleOf(run.label).dash
              },
                s("title", {}, run.label))),
      peakLabel(lines, x, y, frame), haloStrips(lines, x, frame));
}

function haloPixels(c, side) {
  const pixels = c.runs.map((run) => haloOf(run, side, "luminance").pixels).find(isNumber);
  return pixels === undefined ? null : h("span", {class: "muted"}, ` ${count(pixels)} px`);
}

function haloRows(channel) {
  return cases.filter((c) => c.runs.length > 0)
      .map(
          (c) =>
              h("div", {class: "halo-row"}, h("h3", {}, caseName(c)),
                h("div", {class: "quad"},
                  HALO_SIDES.map(
                      (side) =>
                          h("figure", {class: "panel"}, h("figcaption", {}, side.title, haloPixels(c, side)),
                            haloChart(c, side, channel, haloRange(c, channel)))))));
}

function haloSection() {
  const rows = h("div", {}, haloRows("luminance"));
  const channel =
      choice("Channel", CHANNELS, "luminance", (value) => rows.replaceChildren(...haloRows(value)));
  return section(
      "halos", "Halos at silhouettes",
      ["Relative error, in %, of each bin of the distance \u03b4 to the nearest contour: sum(test " +
       "\u2212 truth) / sum(truth). " +
       "s is the profile\u2019s widest standard deviation; the band is \u00b11 %, beyond which the " +
       "halo\u2019s width is counted; " +
       "px: skin pixels within 3s. One vertical axis per row, linear within the band and logarithmic " +
       "beyond."],
      h("div", {class: "controls"}, channel.element), legend(), rows);
}

function legend() {
  return h("div", {class: "legend"}, labels.map((label) => methodName(label)));
}
