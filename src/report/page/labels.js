// Where a chart's labels stand, in px: beside their points, over no marker and no other label.

// About as wide as the page's font sets it.
const textWidth = (text, size = 12) => 0.6 * size * text.length;
const overlap = (a, b) => a.x < b.x + b.w && b.x < a.x + a.w && a.y < b.y + b.h && b.y < a.y + a.h;

// Where a label may stand: close by first, then farther off, where a line leads to it.
function labelPlaces({x, y}) {
  const close = [
    [7, -9, "start"], [-8, 18, "end"], [0, 20, "middle"], [-11, 4, "end"], [8, 18, "start"], [11, 4, "start"],
    [-8, -9, "end"], [0, -11, "middle"]
  ].map(([dx, dy, anchor]) => ({x: x + dx, y: y + dy, anchor}));
  const far = [28, 44, 60, 76, 92].flatMap(
      (d) => [[0, d, "middle"], [0, -d, "middle"], [0.8 * d, d, "start"], [-0.8 * d, d, "end"],
              [0.8 * d, -d, "start"], [-0.8 * d, -d, "end"]]
                 .map(([dx, dy, anchor]) => ({x: x + dx, y: y + dy + 4, anchor, led: true})));
  return [...close, ...far];
}

const ANCHOR_SHARES = {
  start: 0,
  middle: 0.5,
  end: 1
};
function labelBox(place, text, size) {
  const w = textWidth(text, size);
  return {x: place.x - ANCHOR_SHARES[place.anchor] * w, y: place.y - 11, w, h: 14};
}

const isWithin = (box, frame) => box.x >= frame.left && box.x + box.w <= frame.right && box.y >= frame.top &&
    box.y + box.h <= frame.bottom;

// The first place whose label covers nothing and stays inside; at least inside, where there is none.
function placeLabel(places, text, size, taken, frame) {
  const box = (place) => labelBox(place, text, size), inside = (place) => isWithin(box(place), frame);
  const isFreeOf = (place) => !taken.some((other) => overlap(box(place), other));
  const place = places.find((p) => inside(p) && isFreeOf(p)) || places.find(inside) || places[0];
  taken.push(box(place));
  return place;
}

// A line's pieces along the axes, as thin boxes.
function lineBoxes(series, x, y) {
  return series.points.slice(1).map((to, i) => {
    const a = {x: x(series.points[i].x), y: y(series.points[i].y)}, b = {x: x(to.x), y: y(to.y)};
    return {
      x: Math.min(a.x, b.x) - 1,
      y: Math.min(a.y, b.y) - 1,
      w: Math.abs(a.x - b.x) + 2,
      h: Math.abs(a.y - b.y) + 2
    };
  });
}

function notePlaces(level, at, frame) {
  if (level.axis === "x") {
    const last = at > frame.right - 8;
    return [{x: last ? frame.right : at, y: frame.top - 5, anchor: last ? "end" : "middle"}];
  }
  const right = {x: frame.right - 6, anchor: "end"}, left = {x: frame.left + 6, anchor: "start"};
  const [first, second] = level.kind === "baseline" ? [right, left] : [left, right];
  return [first, second].flatMap((side) => [-5, 14].map((dy) => ({...side, y: at + dy})));
}

// [{level, text, x, y, anchor}] of the lines across, and [{point, series, text, x, y, anchor, led}] of the
// points.
function placedLabels(chart, x, y, frame) {
  const size = chart.labelSize || 12, levels = (chart.levels || []).filter((level) => level.text);
  const marked = chart.series.filter((series) => series.marker && series.size !== DOT).flatMap(drawnPoints);
  const taken = marked.filter((point) => !point.faint)
                    .map((point) => ({x: x(point.x) - 8, y: y(point.y) - 8, w: 16, h: 16}));
  for (const series of chart.series.filter((other) => other.obstacle)) taken.push(...lineBoxes(series, x, y));
  for (const level of levels.filter((l) => l.axis === "y"))
    taken.push({x: frame.left, y: y(level.at) - 1, w: frame.right - frame.left, h: 2});
  const notes = levels.map((level) => {
    const at = (level.axis === "x" ? x : y)(level.at), wide = {...frame, top: 0};
    const place =
        placeLabel(notePlaces(level, at, frame), level.text, 11, taken, level.axis === "x" ? wide : frame);
    return {level, text: level.text, ...place};
  });
  const labels =
      chart.series.flatMap((series) => drawnPoints(series).filter((point) => point.label).map((point) => {
        const at = {x: x(point.x), y: y(point.y)};
        return {
          point,
          series,
          text: point.label,
          at,
          ...placeLabel(labelPlaces(at), point.label, size, taken, frame)
        };
      }));
  return {notes, labels};
}

// Names beside the lines' ends, apart from each other: [{series, x, y}].
function endNames(chart, y, frame) {
  const named = chart.series
                    .filter(
                        (series) => series.name && series.points.length > 0 &&
                            isNumber(series.points[series.points.length - 1].y))
                    .map((series) => ({series, at: y(series.points[series.points.length - 1].y)}))
                    .sort((a, b) => a.at - b.at);
  let last = -Infinity;
  return named.map(({series, at}) => {
    last = Math.max(at, last + 14);
    return {series, x: frame.right + 8, y: last + 4};
  });
}
