// Halo profiles: relative error against the distance to the nearest silhouette.

const HALO = {
  width: 300,
  height: 220,
  left: 50,
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

// By bin; y is null where it has no light; no point where it has no pixel.
function haloPoints(run, side, channel) {
  const profile = haloOf(run, side, channel).profile || {}, pixels = list(profile.pixels);
  if (!isNumber(profile.bin_mm)) return [];
  return list(profile.relative_error)
      .map((error, i) => ({x: (i + 0.5) * profile.bin_mm, y: isNumber(error) ? 100 * error : null}))
      .filter((_, i) => pixels[i] !== 0);
}

function haloRange(c, channel, sides = HALO_SIDES) {
  const all = sides.flatMap((side) => c.runs.flatMap((run) => haloPoints(run, side, channel)))
                  .map((point) => point.y)
                  .filter(isNumber);
  return [1.15 * Math.min(-1.6, ...all), 1.15 * Math.max(1.6, ...all)];
}

function haloSeries(c, run, side, channel) {
  const {colour, dash} = styleOf(run.label);
  const points = haloPoints(run, side, channel).map((point) => ({
                                                      ...point,
                                                      tip: `${run.label}  ${number(point.y, true)} %`,
                                                      pick: () => openViewer(c, run.label, "signed")
                                                    }));
  return {name: run.label, colour, dash, line: 1.6, points};
}

// The largest peak has its method's name.
function namePeak(series) {
  const all = series.flatMap((one) => drawnPoints(one).map((point) => ({name: one.name, point})));
  const peak = all.sort((a, b) => Math.abs(b.point.y) - Math.abs(a.point.y))[0];
  if (peak && Math.abs(peak.point.y) >= HALO_WITHIN) peak.point.label = peak.name;
}

function haloLevels(widest, to) {
  const marks = [1, 3, 6].filter((m) => m * widest <= to * 1.001);
  return [
    {axis: "y", at: 0, kind: "zero"},
    ...marks.map((m) => ({axis: "x", at: m * widest, kind: "mark", text: (m === 1 ? "" : m) + "s"}))
  ];
}

function haloChart(c, side, channel, yRange) {
  const series =
      c.runs.map((run) => haloSeries(c, run, side, channel)).filter((one) => drawnPoints(one).length > 0);
  if (series.length === 0) {
    const reasons = c.runs.map((run) => haloOf(run, side, channel).peak_reason).filter(Boolean);
    return h("p", {class: "empty"}, reasons[0] || "no silhouette of this kind in this view");
  }
  namePeak(series);
  const widest = profileOf(c.profile).widest_std_dev_mm;
  const to =
      Math.max(6 * (widest || 0), ...series.flatMap((one) => drawnPoints(one).map((point) => point.x)));
  return chartElement({
    name: `${side.title}, ${caseName(c)}`,
    attributes: {class: "halo"},
    size: HALO,
    x: {
      title: `\u03b4, mm from the ${side.line || "silhouette"}`,
      scale: "linear",
      from: 0,
      to,
      prefix: "\u03b4 ",
      suffix: " mm"
    },
    y: {title: "relative error, %", scale: "asinh", from: yRange[0], to: yRange[1]},
    band: [-HALO_WITHIN, HALO_WITHIN],
    levels: haloLevels(widest, to),
    hover: "column",
    labelSize: 11,
    series
  });
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
      h("div", {class: "controls"}, channel.element), legend(), rows, chartNote());
}

function legend() { return h("div", {class: "legend"}, labels.map((label) => methodName(label))); }
