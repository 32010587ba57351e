// What the viewer says about values: those under the pointer, the statistics of a region, the histogram of
// the error, and false colour.

const WHOLE = {
  x0: 0,
  y0: 0,
  x1: 1,
  y1: 1
};
const HISTOGRAM = {
  width: 460,
  height: 190,
  left: 52,
  right: 12,
  top: 8,
  bottom: 38,
  bins: 41
};
const digits = (value) => isNumber(value) ? value.toPrecision(5).replace("-", MINUS) : EN_DASH;

// --- false colour ---

// Black, violet, red, yellow, white: lightness rises all the way.
const FALSE_COLOUR_STOPS =
    [[0, 0, 4], [66, 10, 104], [147, 38, 103], [221, 81, 58], [252, 165, 10], [252, 255, 210]];
function falseColour(share) {
  const at = clamp(share, 0, 1) * (FALSE_COLOUR_STOPS.length - 1),
        i = Math.min(Math.floor(at), FALSE_COLOUR_STOPS.length - 2);
  return FALSE_COLOUR_STOPS[i].map((low, c) => low + (at - i) * (FALSE_COLOUR_STOPS[i + 1][c] - low));
}

// The value that false colour shows as white: the scene's largest irradiance, halved by each stop.
const falseColourTop = () => ((results.scene || {}).largest_irradiance || 1) / 2 ** viewerState.exposure;

function falseColourCanvas(map, channel) {
  const canvas = h("canvas", {width: map.width, height: map.height}), context = canvas.getContext("2d");
  const image = context.createImageData(map.width, map.height), pixels = new Uint32Array(image.data.buffer);
  const packed = ([r, g, b]) => new Uint32Array(Uint8ClampedArray.of(r, g, b, 255).buffer)[0];
  const table = Array.from({length: 256}, (_, i) => packed(falseColour(i / 255)));
  const none = packed([56, 56, 56]), scale = 255 / falseColourTop();
  for (let i = 0; i < pixels.length; ++i) {
    const value = map.at(i, channel);
    pixels[i] = Number.isNaN(value) ? none : table[clamp(Math.round(scale * value), 0, 255)];
  }
  context.putImageData(image, 0, 0);
  return canvas;
}

function falseColourBar() {
  const stops = FALSE_COLOUR_STOPS.map((c) => `rgb(${c})`).join(",");
  return h(
      "span", {class: "colour-bar"},
      h("span", {class: "ramp", style: `background:linear-gradient(90deg,${stops})`}),
      h("span", {class: "ends"}, h("span", {}, "0"), h("span", {}, channelName(viewerState.channel)),
        h("span", {}, number(falseColourTop()))));
}

// --- under the pointer ---

// The stored pixel under a place, in shares of the picture, and its place in the file.
function pixelAt(c, map, u, v) {
  const view = viewOf(c.view), stride = values.stride;
  const x = Math.floor(Math.floor(u * view.width_px) / stride),
        y = Math.floor(Math.floor(v * view.height_px) / stride);
  if (x < 0 || y < 0 || x >= map.width || y >= map.height) return null;
  return {i: y * map.width + x, x: x * stride, y: y * stride};
}

function valueText(map, i) {
  if (!map) return "no values";
  if (Number.isNaN(map.at(i, "luminance"))) return "not measured";
  return `${digits(map.at(i, "luminance"))} (${["r", "g", "b"].map((c) => digits(map.at(i, c))).join("  ")})`;
}

function pixelFacts(c, loaded, label, u, v) {
  const {truth} = loaded, test = loaded.runs.get(label), pixel = truth && pixelAt(c, truth, u, v);
  if (!pixel) return [h("span", {class: "muted"}, "Point at a picture for its values.")];
  const error = test ? test.at(pixel.i, "luminance") - truth.at(pixel.i, "luminance") : NaN;
  const share = error / truth.at(pixel.i, "luminance");
  return [
    ["x, y", `${pixel.x}, ${pixel.y}`], ["truth", valueText(truth, pixel.i)],
    [label, valueText(test, pixel.i)],
    ["error", Number.isNaN(error) ? EN_DASH : `${digits(error)}  ${percent(share)}`]
  ].map(([name, text]) => h("span", {"data-value": name}, h("b", {}, name + " "), text));
}

function precisionNote(c, loaded) {
  const shown = [loaded.truth, ...loaded.runs.values()].filter(Boolean);
  if (typeof DecompressionStream === "undefined")
    return "This browser cannot unpack the values; the EXR files have them.";
  if (shown.length === 0)
    return "No values: the run\u2019s EXR files were not there when the page was written.";
  const thinned = values.stride > 1 ? `, of every ${values.stride}${
                                          values.stride === 2     ? "nd" :
                                              values.stride === 3 ? "rd" :
                                                                    "th"} column and row` :
                                      "";
  return `Luminance (red green blue), linear, in units of irradiance, as in the EXR to \u00b1${
      scientific(Math.max(...shown.map((map) => map.error)))} each${thinned}; exact ones: the EXR files.`;
}

// --- a region ---

function regionTable(c, loaded, region, channel) {
  const rows = [...c.runs].sort(byError).map((run) => {
    const test = loaded.runs.get(run.label);
    const found = test && regionStatistics(loaded.truth, test, region, channel);
    return [
      methodName(run.label),
      ...(found ?
              [
                count(found.pixels), digits(found.bias), digits(found.rmse), percent(found.relative),
                digits(found.max)
              ] :
              ["0", EN_DASH, EN_DASH, EN_DASH, EN_DASH])
    ];
  });
  return plainTable(["Method", "pixels", "bias", "RMSE", "rel. RMSE", "max |e|"], rows);
}

function histogramBars(errors, limit) {
  const bars = new Array(HISTOGRAM.bins).fill(0);
  for (const e of errors)
    ++bars[clamp(Math.floor((e / limit + 1) / 2 * HISTOGRAM.bins), 0, HISTOGRAM.bins - 1)];
  return bars;
}

// Pixels by their error, on a logarithmic axis; the ends hold all that lies beyond.
function histogram(errors, label, channel) {
  if (errors.length === 0) return h("p", {class: "empty"}, "no measured pixel in this region");
  const sizes = errors.map(Math.abs).sort((a, b) => a - b);
  const limit = 1.05 * (sizes[Math.floor(0.999 * (sizes.length - 1))] || 1e-9),
        bars = histogramBars(errors, limit);
  const {width, height, left, bottom, bins} = HISTOGRAM, right = width - HISTOGRAM.right,
                                      base = height - bottom;
  const top = Math.log10(2 * Math.max(...bars)), barWidth = (right - left) / bins;
  const x = (e) => left + (right - left) * (e / limit + 1) / 2;
  const y = (n) => n > 0 ? base - (base - HISTOGRAM.top) * Math.log10(2 * n) / top : base;
  const powers = Array.from({length: Math.floor(Math.log10(Math.max(...bars))) + 1}, (_, e) => 10 ** e);
  const colour = styleOf(label).colour, binText = (i) => digits(limit * (2 * i / bins - 1));
  return s(
      "svg", {
        class: "chart histogram",
        viewBox: `0 0 ${width} ${height}`,
        role: "img",
        "aria-label": `Histogram of the error of ${label}`
      },
      s("g", {class: "axes"},
        powers.map(
            (n) =>
                [s("line", {class: "grid", x1: left, x2: right, y1: y(n), y2: y(n)}),
                 s("text", {x: left - 6, y: y(n) + 4, "text-anchor": "end"}, grouped(String(n)))]),
        linearTicks([-limit, limit], 4)
            .map(
                (e) => s(
                    "text", {x: x(e), y: base + 15, "text-anchor": "middle"}, String(e).replace("-", MINUS))),
        s("text", {class: "label", x: (left + right) / 2, y: height - 4, "text-anchor": "middle"},
          `${label}: error of ${channelName(channel)}, test ${MINUS} truth, in units of irradiance`),
        s("text",
          {class: "label", "text-anchor": "middle", transform: `translate(11,${base / 2}) rotate(-90)`},
          "Pixels")),
      bars.map((n, i) => s("rect", {
                 x: left + i * barWidth,
                 y: y(n),
                 width: Math.max(0, barWidth - 1),
                 height: base - y(n),
                 fill: colour,
                 "data-tip": `${count(n)} pixels\n${binText(i)} to ${binText(i + 1)}${
                     i === 0 || i === bins - 1 ? " and beyond" : ""}`
               })),
      s("line", {class: "zero", x1: x(0), x2: x(0), y1: HISTOGRAM.top, y2: base}));
}

function regionName(c, region) {
  if (!region) return "Whole picture";
  const view = viewOf(c.view), px = (share, size) => Math.round(share * size);
  return `Columns ${px(region.x0, view.width_px)}..${px(region.x1, view.width_px) - 1}, rows ${
      px(region.y0, view.height_px)}..${px(region.y1, view.height_px) - 1}`;
}

function regionPanel(c, loaded, label, region, channel) {
  if (!loaded.truth) return [];
  const test = loaded.runs.get(label), within = region || WHOLE;
  return [
    h("h4", {}, regionName(c, region),
      h("span", {class: "muted"}, `, ${channelName(channel)}, from the values above`)),
    regionTable(c, loaded, within, channel),
    test && h("figure", {}, histogram(regionErrors(loaded.truth, test, within, channel), label, channel))
  ].filter(Boolean);
}
