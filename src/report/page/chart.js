// What a chart shows, apart from what draws it.
//
// A chart is {
//   name         what it shows, in words, for who cannot see it
//   attributes   of its element
//   size         {width, height, left, right, top, bottom}: its proportions and margins, in px
//   x, y         axes: {title, scale: "linear" | "log" | "asinh", from, to}; optional: ticks (values), wanted
//                (about how many), prefix and suffix of a value in words
//   series       [{name, points}]; optional: colour (CSS), line (its width, px), dash, marker (a key of
//                SHAPE_PATHS), size (a share of the usual one), quiet (says nothing), obstacle (no label on
//                it)
//   levels       [{axis: "x" | "y", at, kind: "zero" | "mark" | "level" | "baseline", text}]: lines across
//   band         [low, high] of y, shaded
//   hover        "point": each says its tip; "column": all of the nearest x do, a line each
//   named        whether the lines are named beside the chart
//   labelSize    of its points' labels, px
// }
// and a point {x, y}; y null breaks the line. Optional: tip, least and most (a whisker along x), hollow,
// faint, label, pick() (what a click does).

// The size of a marker on a line, where the line is what one sees.
const DOT = 0.45;

const SCALES = {
  linear: {of: (value) => value, back: (value) => value},
  log: {of: Math.log10, back: (value) => 10 ** value},
  // Linear within about 1, logarithmic beyond: 40 % and 1 % are both to be seen.
  asinh: {of: Math.asinh, back: Math.sinh}
};

// Value to place, with `from` of the axis at a and `to` at b.
function positionOn(axis, a, b) {
  const {of} = SCALES[axis.scale], from = of(axis.from), to = of(axis.to);
  return (value) => a + (b - a) * (of(value) - from) / (to - from);
}

const isOn = (axis, value) => value >= Math.min(axis.from, axis.to) && value <= Math.max(axis.from, axis.to);

// The axis with room at both ends, a share of its length each.
function withRoom(axis, share) {
  const {of, back} = SCALES[axis.scale], from = of(axis.from), to = of(axis.to);
  return {...axis, from: back(from - share * (to - from)), to: back(to + share * (to - from))};
}

function linearTicks([low, high], wanted) {
  const rough = (high - low) / wanted, decade = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((m) => m * decade).find((m) => m >= rough);
  const ticks = [];
  for (let i = Math.ceil(low / step); i * step <= high + 1e-9 * step; ++i)
    ticks.push(Number((i * step).toPrecision(6)));
  return ticks;
}

// Decades alone where there are many, else 1, 2, 5 in each; evenly where that gives less than three.
function logTicks([low, high]) {
  const ticksBy = (steps) => {
    const decades = Array.from(
        {length: Math.ceil(Math.log10(high)) - Math.floor(Math.log10(low)) + 1},
        (_, i) => i + Math.floor(Math.log10(low)));
    return decades.flatMap((e) => steps.map((step) => Number((step * 10 ** e).toPrecision(3))))
        .filter((tick) => tick >= low * 0.999 && tick <= high * 1.001);
  };
  const choices = [...(Math.log10(high / low) > 2.5 ? [ticksBy([1])] : []), ticksBy([1, 2, 5])];
  return choices.find((ticks) => ticks.length > 2) || linearTicks([low, high], 4);
}

function asinhTicks([low, high]) {
  const sizes = [1, 3, 10, 30, 100, 300, 1000];
  const ticks = [...sizes.map((tick) => -tick), 0, ...sizes].filter((tick) => tick >= low && tick <= high);
  return ticks.length > 2 ? ticks : linearTicks([low, high], 4);
}

// Of the part of an axis between two values.
function ticksBetween(axis, from, to) {
  const range = [Math.min(from, to), Math.max(from, to)];
  if (axis.ticks) return axis.ticks.filter((tick) => tick >= range[0] && tick <= range[1]);
  return axis.scale === "log" ? logTicks(range) :
      axis.scale === "asinh"  ? asinhTicks(range) :
                                linearTicks(range, axis.wanted || 5);
}

const signedText = (value) => (value < 0 ? MINUS + Math.abs(value) : value > 0 ? "+" + value : "0");
const tickText = (axis, tick) =>
    axis.scale === "asinh" || tick < 0 ? signedText(tick) : grouped(String(tick));

function logDomain(values, pad) {
  const positive = values.filter((v) => isNumber(v) && v > 0);
  if (positive.length === 0) return [0.1, 10];
  return [Math.min(...positive) / pad, Math.max(...positive) * pad];
}

const frameOf = (size, width = size.width, height = size.height) =>
    ({left: size.left, right: width - size.right, top: size.top, bottom: height - size.bottom});

const drawnPoints = (series) => series.points.filter((point) => isNumber(point.y));

// The x of every column, from the left, and what each series says there: [{x, points: [{series, point}]}].
function columnsOf(chart) {
  const all = chart.series.filter((series) => !series.quiet)
                  .flatMap((series) => drawnPoints(series).map((point) => ({series, point})));
  const from = Math.min(chart.x.from, chart.x.to) === chart.x.from ? 1 : -1;
  return unique(all.map(({point}) => point.x))
      .sort((a, b) => from * (a - b))
      .map((x) => ({x, points: all.filter(({point}) => point.x === x)}));
}

const columnTitle = (chart, x) => (chart.x.prefix || "") + number(x) + (chart.x.suffix || "");

// The point of a column that is nearest to a height in px.
const nearestInColumn =
    (points, y, at) => [...points].sort((a, b) => Math.abs(y(a.y) - at) - Math.abs(y(b.y) - at))[0];

// --- what draws ---

const hasPlotly = typeof Plotly !== "undefined";

const chartElement = (chart) => hasPlotly ? plotlyChart(chart) : svgChart(chart);

// Under the charts of a section: why they are plain, where they are.
const chartNote = () => !hasPlotly &&
    h("p", {class: "hint chart-note"},
      "The charts are plain SVG: plotly.js was not there when this program was built.");
