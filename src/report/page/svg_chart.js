// A chart as plain SVG.

// Broken where a point has no value; a point between two such is a dot.
function linePath(points, x, y) {
  let path = "", pen = "M";
  for (const point of points) {
    const shown = isNumber(point.y);
    if (shown) path += `${pen}${x(point.x).toFixed(1)},${y(point.y).toFixed(1)}${pen === "M" ? "h0" : ""}`;
    pen = shown ? "L" : "M";
  }
  return path;
}

function svgAxes(chart, x, y, frame) {
  const middle = {x: (frame.left + frame.right) / 2, y: (frame.top + frame.bottom) / 2};
  const ticks = (axis) => ticksBetween(axis, axis.from, axis.to);
  return s(
      "g", {class: "axes"}, chart.band && s("rect", {
                              class: "within",
                              x: frame.left,
                              width: frame.right - frame.left,
                              y: y(chart.band[1]),
                              height: y(chart.band[0]) - y(chart.band[1])
                            }),
      ticks(chart.y).map(
          (tick) =>
              [s("line", {class: "grid", x1: frame.left, x2: frame.right, y1: y(tick), y2: y(tick)}),
               s("text", {x: frame.left - 7, y: y(tick) + 4, "text-anchor": "end"},
                 tickText(chart.y, tick))]),
      ticks(chart.x).map(
          (tick) =>
              [s("line", {class: "grid", x1: x(tick), x2: x(tick), y1: frame.top, y2: frame.bottom}),
               s("text", {x: x(tick), y: frame.bottom + 16, "text-anchor": "middle"},
                 tickText(chart.x, tick))]),
      s("rect", {
        class: "frame",
        x: frame.left,
        y: frame.top,
        width: frame.right - frame.left,
        height: frame.bottom - frame.top
      }),
      s("text", {class: "label", x: middle.x, y: chart.size.height - 5, "text-anchor": "middle"},
        chart.x.title),
      s("text", {class: "label", "text-anchor": "middle", transform: `translate(12,${middle.y}) rotate(-90)`},
        chart.y.title));
}

function svgLevels(chart, x, y, frame) {
  return (chart.levels || []).map((level) => {
    const ends = level.axis === "x" ? {x1: x(level.at), x2: x(level.at), y1: frame.top, y2: frame.bottom} :
                                      {x1: frame.left, x2: frame.right, y1: y(level.at), y2: y(level.at)};
    return s("line", {class: level.kind, ...ends});
  });
}

function svgLine(series, x, y) {
  return series.line && s("path", {
           class: "line",
           d: linePath(series.points, x, y),
           style: `stroke:${series.colour};stroke-width:${series.line}`,
           "stroke-dasharray": series.dash
         });
}

function svgWhisker(point, colour, x, y) {
  if (!(point.least > 0) || !(point.most > 0)) return null;
  return s("path", {
    class: "whisker",
    stroke: colour,
    d: `M${x(point.least)},${y(point.y) - 4}v8m0,-4H${x(point.most)}m0,-4v8`
  });
}

function svgMarkers(series, x, y) {
  if (!series.marker) return null;
  return drawnPoints(series).map(
      (point) => [svgWhisker(point, series.colour, x, y), s("path", {
                    class: point.pick ? "marker picks" : "marker",
                    d: SHAPE_PATHS[series.marker],
                    transform: `translate(${x(point.x)},${y(point.y)}) scale(${series.size || 1})`,
                    stroke: series.colour,
                    fill: point.hollow ? "var(--panel)" : series.colour,
                    opacity: point.faint ? "0.45" : null,
                    "data-tip": point.tip,
                    onclick: point.pick
                  })]);
}

function svgLabels(chart, x, y, frame) {
  const {notes, labels} = placedLabels(chart, x, y, frame);
  return [
    notes.map(
        (note) => s("text", {class: "note", x: note.x, y: note.y, "text-anchor": note.anchor}, note.text)),
    labels.map(({point, series, text, at, led, ...place}) => {
      const below = place.y > at.y;
      return [
        led && s("line", {
          class: "leader",
          stroke: series.colour,
          x1: at.x,
          y1: at.y + (below ? 6 : -6),
          x2: place.x,
          y2: place.y + (below ? -11 : 3)
        }),
        s("text", {
          class: chart.labelSize < 12 ? "direct small" : "direct",
          x: place.x,
          y: place.y,
          "text-anchor": place.anchor,
          fill: series.colour,
          "data-tip": point.tip
        },
          text)
      ];
    }),
    chart.named &&
        endNames(chart, y, frame)
            .map(({series,
                   ...place}) => s("text", {class: "direct", ...place, fill: series.colour}, series.name))
  ];
}

// A strip over each column, which tells all values there; a click picks the nearest.
function svgStrips(chart, x, y, frame) {
  const columns = columnsOf(chart), places = columns.map((column) => x(column.x));
  return columns.map(({x: value, points}, i) => {
    const left = i > 0 ? (places[i - 1] + places[i]) / 2 : frame.left;
    const right = i + 1 < places.length ? (places[i] + places[i + 1]) / 2 : frame.right;
    const pick = (event) => {
      const box = event.currentTarget.getBoundingClientRect();
      const at = frame.top + (event.clientY - box.top) / box.height * (frame.bottom - frame.top);
      const nearest = nearestInColumn(points.map(({point}) => point), y, at);
      if (nearest.pick) nearest.pick();
    };
    return s("rect", {
      class: "strip",
      x: left,
      width: right - left,
      y: frame.top,
      height: frame.bottom - frame.top,
      "data-tip": [columnTitle(chart, value), ...points.map(({point}) => point.tip)].join("\n"),
      onclick: pick
    });
  });
}

function svgChart(chart) {
  const frame = frameOf(chart.size), {class: classes, ...attributes} = chart.attributes || {};
  const x = positionOn(chart.x, frame.left, frame.right), y = positionOn(chart.y, frame.bottom, frame.top);
  return s(
      "svg", {
        class: ["chart", classes].filter(Boolean).join(" "),
        viewBox: `0 0 ${chart.size.width} ${chart.size.height}`,
        role: "img",
        "aria-label": chart.name,
        ...attributes
      },
      svgAxes(chart, x, y, frame), svgLevels(chart, x, y, frame),
      chart.series.map((series) => svgLine(series, x, y)),
      chart.series.map((series) => svgMarkers(series, x, y)), svgLabels(chart, x, y, frame),
      chart.hover === "column" && svgStrips(chart, x, y, frame));
}
