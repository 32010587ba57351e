// A chart drawn by plotly, as SVG. Nothing is fetched: it has no maps, and no button that leads elsewhere.

const PLOTLY_CONFIG = {
  displaylogo: false,
  responsive: true,
  doubleClick: "reset",
  modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"],
  showLink: false,
  plotlyServerURL: "",
  topojsonURL: ""
};
const PLOTLY_SYMBOLS = {
  circle: "circle",
  square: "square",
  triangle: "triangle-up",
  diamond: "diamond"
};
const MARKER_PX = 10;

// plotly reads tags in texts.
const plotlyText = (text) =>
    text.replaceAll("&", "&amp;").replaceAll("<", "&lt;").replaceAll(">", "&gt;").replaceAll("\n", "<br>");

// plotly knows no custom properties: what a colour is at present, in this theme.
const colourProbe = h("span", {hidden: true});
document.body.append(colourProbe);
function presentColour(colour) {
  colourProbe.style.color = colour;
  return getComputedStyle(colourProbe).color;
}

// Logarithmic axes are plotly's own; others are linear in what their scale makes of a value.
const plotlyValue = (axis, value) => axis.scale === "log" ? value : SCALES[axis.scale].of(value);
const plotlyPlace = (axis, value) => SCALES[axis.scale].of(value);

function plotlyTicks(axis, from, to) {
  const ticks = ticksBetween(axis, from, to);
  return {
    tickvals: ticks.map((tick) => plotlyValue(axis, tick)),
    ticktext: ticks.map((tick) => tickText(axis, tick))
  };
}

function plotlyAxis(axis, title) {
  return {
    type: axis.scale === "log" ? "log" : "linear",
    range: [axis.from, axis.to].map(SCALES[axis.scale].of),
    tickmode: "array",
    ...plotlyTicks(axis, axis.from, axis.to),
    title: {text: plotlyText(title), font: {size: 12, color: presentColour("var(--soft)")}, standoff: 6},
    gridcolor: presentColour("var(--faint)"),
    linecolor: presentColour("var(--line)"),
    showline: true,
    mirror: true,
    zeroline: false
  };
}

// A dot where a line is broken on both sides, which is no line; nothing elsewhere.
function dotSizes(series) {
  const shown = (point) => point !== undefined && isNumber(point.y);
  return series.points.map((_, i) => shown(series.points[i - 1]) || shown(series.points[i + 1]) ? 0 : 3);
}

function plotlyWhiskers(points, colour) {
  if (!points.some((point) => point.least > 0)) return {};
  const reach = (end) => points.map((point) => (point.least > 0 ? Math.abs(point[end] - point.x) : 0));
  return {
    error_x: {
      type: "data",
      symmetric: false,
      array: reach("most"),
      arrayminus: reach("least"),
      color: colour,
      thickness: 1,
      width: 3
    }
  };
}

function plotlyTrace(chart, series) {
  const {points} = series, colour = presentColour(series.colour), panel = presentColour("var(--panel)");
  const marker = series.marker ? {
    symbol: PLOTLY_SYMBOLS[series.marker],
    size: MARKER_PX * (series.size || 1),
    color: points.map((point) => (point.hollow ? panel : colour)),
    opacity: points.map((point) => (point.faint ? 0.45 : 1)),
    line: {color: colour, width: series.line ? 0 : 1.5}
  } :
                                 {color: colour, size: dotSizes(series), opacity: 1, line: {width: 0}};
  return {
    type: "scatter",
    mode: series.quiet ? "lines" :
        series.line    ? "lines+markers" :
                         "markers",
    name: plotlyText(series.name || ""),
    showlegend: Boolean(series.name) && !series.quiet,
    x: points.map((point) => plotlyValue(chart.x, point.x)),
    y: points.map((point) => (isNumber(point.y) ? plotlyValue(chart.y, point.y) : null)),
    text: points.map((point) => plotlyText(point.tip || "")),
    ...(series.quiet ? {hoverinfo: "skip"} : {hovertemplate: "%{text}<extra></extra>"}),
    line: {
      color: colour,
      width: series.line || 0,
      dash: (series.dash || "").replace(/\d+/g, "$&px").replaceAll(" ", ",") || "solid"
    },
    marker,
    connectgaps: false,
    ...plotlyWhiskers(points, colour)
  };
}

const LEVEL_LINES = {
  zero: ["var(--muted)", 1, "solid"],
  mark: ["var(--line)", 1, "2px,3px"],
  level: ["var(--good)", 1.5, "1px,4px"],
  baseline: ["var(--m-none)", 1, "5px,4px"]
};

function plotlyShapes(chart) {
  const levels = (chart.levels || []).map(({axis, at, kind}) => {
    const [colour, width, dash] = LEVEL_LINES[kind], value = plotlyValue(chart[axis], at);
    const ends = axis === "x" ? {x0: value, x1: value, yref: "y domain", y0: 0, y1: 1} :
                                {y0: value, y1: value, xref: "x domain", x0: 0, x1: 1};
    return {type: "line", ...ends, layer: "below", line: {color: presentColour(colour), width, dash}};
  });
  const [y0, y1] = (chart.band || []).map((value) => plotlyValue(chart.y, value));
  const band = {
    type: "rect",
    xref: "x domain",
    x0: 0,
    x1: 1,
    y0,
    y1,
    layer: "below",
    line: {width: 0},
    fillcolor: presentColour("var(--raised)")
  };
  return chart.band ? [band, ...levels] : levels;
}

const PLOTLY_ANCHORS = {
  start: "left",
  middle: "center",
  end: "right"
};

// Labels stand beside their points by so many px, whatever part of the chart is shown.
function plotlyAnnotations(chart, width, height) {
  const frame = frameOf(chart.size, width, height);
  const x = positionOn(chart.x, frame.left, frame.right), y = positionOn(chart.y, frame.bottom, frame.top);
  const {notes, labels} = placedLabels(chart, x, y, frame), soft = presentColour("var(--soft)");
  // A text's y is its base line; half of its height above it is its middle.
  const ofNote = ({level, text, anchor, ...place}) => {
    const across = level.axis === "y", at = across ? y(level.at) : frame.top;
    return {
      text: plotlyText(text),
      xref: across ? "x domain" : "x",
      yref: across ? "y" : "y domain",
      x: across ? (anchor === "start" ? 0 : 1) : plotlyPlace(chart.x, level.at),
      y: across ? plotlyPlace(chart.y, level.at) : 1,
      xshift: across ? (anchor === "start" ? 6 : -6) : 0,
      yshift: at - (place.y - 4),
      xanchor: PLOTLY_ANCHORS[anchor],
      yanchor: "middle",
      showarrow: false,
      font: {size: 11, color: soft}
    };
  };
  const ofPoint = ({point, series, text, at, anchor, led, ...place}) => {
    const dx = place.x - at.x, dy = place.y - 4 - at.y, colour = presentColour(series.colour);
    const shift = led ?
        {showarrow: true, ax: dx, ay: dy, arrowhead: 0, arrowwidth: 1, arrowcolor: colour, standoff: 6} :
        {showarrow: false, xshift: dx, yshift: -dy};
    return {
      text: `<b>${plotlyText(text)}</b>`,
      x: plotlyPlace(chart.x, point.x),
      y: plotlyPlace(chart.y, point.y),
      ...shift,
      xanchor: PLOTLY_ANCHORS[anchor],
      yanchor: "middle",
      font: {size: chart.labelSize || 12, color: colour}
    };
  };
  return [...notes.map(ofNote), ...labels.map(ofPoint)].map(
      (one) => ({...one, captureevents: false, borderpad: 0}));
}

function plotlyLayout(chart, width, height) {
  const {left, right, top, bottom} = chart.size, ink = presentColour("var(--ink)"), clear = "rgba(0,0,0,0)";
  const family = getComputedStyle(document.body).fontFamily;
  const columnTitleText = `${chart.x.prefix || ""}%{x:.4~r}${chart.x.suffix || ""}`;
  return {
    autosize: true,
    uirevision: "kept",
    margin: {l: left, r: right, t: top, b: bottom, pad: 0},
    paper_bgcolor: clear,
    plot_bgcolor: clear,
    font: {family, size: 11.5, color: presentColour("var(--muted)")},
    hovermode: chart.hover === "column" ? "x unified" : "closest",
    hoverlabel: {
      align: "left",
      bgcolor: presentColour("var(--panel)"),
      bordercolor: presentColour("var(--line)"),
      font: {family, size: 12, color: ink}
    },
    modebar: {bgcolor: clear, color: presentColour("var(--muted)"), activecolor: ink},
    showlegend: Boolean(chart.named),
    legend: {x: 1.01, y: 0.95, font: {size: 12, color: ink}, bgcolor: clear},
    xaxis: {
      ...plotlyAxis(chart.x, chart.x.title),
      unifiedhovertitle: {text: plotlyText(columnTitleText)},
      showspikes: chart.hover === "column",
      spikethickness: 1,
      spikedash: "solid",
      spikecolor: presentColour("var(--line)"),
      spikemode: "across"
    },
    yaxis: plotlyAxis(chart.y, chart.y.title),
    shapes: plotlyShapes(chart),
    annotations: plotlyAnnotations(chart, width, height)
  };
}

// The ticks of what has been zoomed to.
function renewTicks(element, chart) {
  const change = {};
  for (const name of ["x", "y"]) {
    const axis = chart[name], [from, to] = element.layout[name + "axis"].range.map(SCALES[axis.scale].back);
    const {tickvals, ticktext} = plotlyTicks(axis, from, to);
    change[`${name}axis.tickvals`] = tickvals;
    change[`${name}axis.ticktext`] = ticktext;
  }
  Plotly.relayout(element, change);
}

// What was clicked: the point itself, or the nearest of its column.
function pickedPoint(element, chart, {points, event}) {
  const shown = points.map(({curveNumber, pointNumber}) => chart.series[curveNumber].points[pointNumber]);
  if (chart.hover !== "column") return shown[0];
  const {back} = SCALES[chart.y.scale], [from, to] = element.layout.yaxis.range.map(back);
  const box = element.getBoundingClientRect(), frame = frameOf(chart.size, box.width, box.height);
  return nearestInColumn(
      shown, positionOn({...chart.y, from, to}, frame.bottom, frame.top), event.clientY - box.top);
}

function listen(element, chart) {
  element.on("plotly_relayout", (change) => {
    if (Object.keys(change).some((key) => /^[xy]axis\.range/.test(key))) renewTicks(element, chart);
  });
  element.on("plotly_click", (clicked) => {
    const point = pickedPoint(element, chart, clicked);
    if (point && point.pick) point.pick();
  });
}

// --- when they are drawn ---

// Charts are drawn when they come near the window, each element's once; those no longer in the page are let
// go.
const plotlyCharts = new Map();

function drawChart(element) {
  const entry = plotlyCharts.get(element), {width, height} = element.getBoundingClientRect();
  const traces = entry.chart.series.map((series) => plotlyTrace(entry.chart, series));
  // A small chart has no room for buttons; dragging and double clicks zoom it all the same.
  const config = {...PLOTLY_CONFIG, displayModeBar: width > 400};
  Plotly.react(element, traces, plotlyLayout(entry.chart, width, height), config);
  if (entry.drawn)
    renewTicks(element, entry.chart);
  else
    listen(element, entry.chart);
  entry.drawn = true;
}

const nearWindow = new IntersectionObserver((found) => {
  for (const {target, isIntersecting} of found) {
    if (!isIntersecting || !plotlyCharts.has(target)) continue;
    nearWindow.unobserve(target);
    if (!plotlyCharts.get(target).drawn) drawChart(target);
  }
}, {rootMargin: "400px"});

function forgetCharts() {
  for (const [element, {placed, drawn}] of plotlyCharts) {
    if (element.isConnected || !placed) continue;
    if (drawn) Plotly.purge(element);
    nearWindow.unobserve(element);
    plotlyCharts.delete(element);
  }
}

// Again in the colours of the theme; `all`: those not yet drawn, too.
function redrawCharts(all = false) {
  forgetCharts();
  for (const [element, {drawn}] of plotlyCharts)
    if (element.isConnected && (drawn || all)) drawChart(element);
}

function plotlyChart(chart) {
  const {class: classes, ...attributes} = chart.attributes || {};
  const element = h("div", {
    class: ["chart plot", classes].filter(Boolean).join(" "),
    style: `aspect-ratio:${chart.size.width}/${chart.size.height}`,
    role: "group",
    "aria-label": chart.name,
    ...attributes
  });
  plotlyCharts.set(element, {chart});
  // Once the caller has put it into the page.
  queueMicrotask(() => {
    forgetCharts();
    if (plotlyCharts.has(element)) plotlyCharts.get(element).placed = true;
    nearWindow.observe(element);
  });
  return element;
}

// --- print ---

// Paper is white, and its columns are narrower than the window's: drawings shrink with them.
let themeBeforePrint;
function readyForPrint() {
  themeBeforePrint = document.documentElement.dataset.theme;
  document.documentElement.dataset.theme = "light";
  redrawCharts(true);
  for (const drawing of document.querySelectorAll(".plot .main-svg"))
    drawing.setAttribute("viewBox", `0 0 ${drawing.getAttribute("width")} ${drawing.getAttribute("height")}`);
}

function afterPrint() {
  for (const drawing of document.querySelectorAll(".plot .main-svg")) drawing.removeAttribute("viewBox");
  if (themeBeforePrint === undefined)
    delete document.documentElement.dataset.theme;
  else
    document.documentElement.dataset.theme = themeBeforePrint;
  redrawCharts();
}

if (hasPlotly) {
  addEventListener("beforeprint", readyForPrint);
  addEventListener("afterprint", afterPrint);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => redrawCharts());
}
