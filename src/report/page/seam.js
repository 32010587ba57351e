// Errors beside UV seams, and by how much UV stretches the surface: where an experiment asks for them.

const SEAM = {path: "seam", title: "UV seams", line: "UV seam"};
const hasSeam = () => runs.some((run) => (run.metrics || {}).seam !== undefined);

const stretchTitle = (bin) => (isNumber(bin.to) ? `${bin.from} to ${bin.to}` : `${bin.from} and more`);

// A row per method, a column per bin: relative RMSE, and the bias when pointed at.
function stretchTable(c, channel) {
  const rows = c.runs.map((run) => ({run, bins: list(haloOf(run, SEAM, channel).stretch)}));
  const bins = (rows.find((row) => row.bins.length > 0) || {bins: []}).bins;
  const shown = bins.map((_, i) => i).filter((i) => bins[i].pixels > 0);
  if (shown.length === 0) return null;
  const cell = (bin) => h(
      "td", {title: `bias ${number(inErrorUnits(bin.bias), true)} ${errorUnit}`, "data-value": isNumber(bin.rel_rmse) ? bin.rel_rmse : ""},
      isNumber(bin.rel_rmse) ? percent(bin.rel_rmse) : EN_DASH);
  return h(
      "div", {class: "scroll panel"},
      sortable(h("table", {class: "metrics stretch"},
        h("thead", {},
          h("tr", {}, h("th", {}, "Stretch"), shown.map((i) => h("th", {}, stretchTitle(bins[i])))),
          h("tr", {}, h("th", {}, "skin pixels"), shown.map((i) => h("th", {}, count(bins[i].pixels))))),
        h("tbody", {},
          rows.filter((row) => row.bins.length > 0)
              .map(({run, bins: own}) => h(
                       "tr", {}, h("th", {scope: "row"}, methodName(run.label)), shown.map((i) => cell(own[i])))))), "stretch", 0));
}

function seamRows(channel) {
  return cases.filter((c) => c.runs.length > 0)
      .map((c) => {
        const missing = c.runs.map((run) => (run.metrics || {}).seam_reason).find(Boolean);
        return h(
            "div", {class: "halo-row"}, h("h3", {}, caseName(c)),
            missing ? h("p", {class: "muted"}, missing) :
                      h("div", {class: "seam"},
                        h("figure", {class: "panel"}, h("figcaption", {}, SEAM.title, haloPixels(c, SEAM)),
                          haloChart(c, SEAM, channel, haloRange(c, channel, [SEAM]))),
                        stretchTable(c, channel)));
      });
}

function seamSection() {
  if (!hasSeam()) return null;
  const rows = h("div", {}, seamRows("luminance"));
  const channel =
      choice("Channel", CHANNELS, "luminance", (value) => rows.replaceChildren(...seamRows(value)));
  return section(
      "seams", "UV seams and stretch",
      "Left: relative error, in %, against the distance \u03b4 to the nearest UV seam in view, by the formulas of " +
          "the halos: sum(test \u2212 truth) / sum(truth) of a bin. Right: relative RMSE, RMSE / RMS of the " +
          "truth, both over the pixels at which the larger singular value of the UV map is so many times the " +
          "smaller; the bias, (1/n) sum(test \u2212 truth), shows under the pointer.",
      h("div", {class: "controls"}, channel.element), rows, chartNote());
}
