// Chains of assumptions: what each adds, read from top to bottom.

const ladders = list(results.ladders);

// Steps grow from 1e-5 to 1e-1: bars are on the scale of the largest step of the ladder.
function ladderBar(value, largest) {
  if (!isNumber(value) || !(largest > 0)) return null;
  const width = 50 * Math.min(1, Math.abs(value) / largest);
  return h(
      "span", {class: "step-bar", "aria-hidden": "true"},
      h("i", {class: value < 0 ? "under" : "over",
              style: `width:${width}%;${value < 0 ? "right" : "left"}:50%`}));
}

function stepPicture(ladder, rung) {
  const path = (rung.files || {}).signed;
  if (!path || !pictures.files[path]) return null;
  return h(
      "a", {class: "step-map", href: linkTo(path), title: `What ${rung.rung} adds: open the file`},
      cropped({view: ladder.view}, {path}, `What ${rung.rung} adds`));
}

function ladderRow(ladder, rung, channel, largest) {
  const step = channelOf(rung.step, channel), soFar = channelOf(rung.so_far, channel);
  const value = (object, path, signed) => {
    if (!rung.step) return EN_DASH;
    const found = lookUp(object, path);
    return h("span", {title: found.reason || null}, number(inErrorUnits(found.value), signed));
  };
  const energy = lookUp(soFar, "halo.energy").value;
  const width = (key) => isNumber((rung.filter_width || {})[key]) ? rung.filter_width[key].toFixed(3) : EN_DASH;
  return h(
      "tr", {}, h("th", {scope: "row"}, rung.rung), h("td", {class: "assumption"}, rung.assumption),
      h("td", {}, stepPicture(ladder, rung)), h("td", {class: "bar-cell", "data-value": (step || {}).bias}, ladderBar((step || {}).bias, largest)),
      h("td", {}, value(step, "bias", true)), h("td", {}, value(step, "rmse")), h("td", {}, value(step, "max")),
      h("td", {}, value(soFar, "bias", true)), h("td", {}, value(soFar, "rmse")),
      h("td", {}, rung.step ? percent(energy) : EN_DASH),
      ["facing", "along_slope", "across_slope"].map((key) => h("td", {}, width(key))));
}

function ladderTable(ladder, channel) {
  const title = h("h3", {}, `${ladder.name}: ${ladder.view}, ${profileTitle(ladder.profile)}`);
  if (ladder.skipped) return h("div", {}, title, h("p", {class: "muted"}, "Not climbed: " + ladder.skipped));
  const steps = ladder.rungs.map((rung) => Math.abs((channelOf(rung.step, channel) || {}).bias || 0));
  const unit = errorUnit ? `, ${errorUnit}` : "";
  const sums = ladder.telescopes || {};
  return h(
      "div", {class: "case-table"}, title,
      h("div", {class: "scroll panel"},
        sortable(h("table", {class: "metrics ladder"},
          h("thead", {},
            h("tr", {}, h("th", {colspan: 3}), h("th", {colspan: 4}, "This assumption adds"),
              h("th", {colspan: 3}, "All so far"),
              h("th", {
                colspan: 3,
                title: "The mean of u\u00b2 under the filter's weights on a plane, as a share of the widest Gaussian's " +
                    "variance: facing the camera, and turned away by 60\u00b0, in the direction in which it recedes " +
                    "and perpendicular to it. Drawn by the method's own shaders under the irradiances 1 and u\u00b2."
              },
                "Variance left on a plane")),
            h("tr", {}, ["Rung", "Assumption", "Map", "bias", `bias${unit}`, `RMSE${unit}`, `max${unit}`,
                         `bias${unit}`, `RMSE${unit}`, "halo energy", "facing", "up a slope",
                         "across it"].map((text) => h("th", {}, text)))),
          h("tbody", {},
            ladder.rungs.map((rung) => ladderRow(ladder, rung, channel, Math.max(...steps))))), "ladders")),
      h("p", {class: "muted"},
        `The steps\u2019 biases sum to ${scientific(sums.sum_of_step_biases, 4)}, the bias of all is ` +
            `${scientific(sums.bias_so_far, 4)}; at no pixel do the steps\u2019 sum and the whole difference ` +
            `part by more than ${scientific(sums.largest_gap)}.`));
}

function ladderSection() {
  if (ladders.length === 0) return null;
  const all = (channel) => ladders.map((ladder) => ladderTable(ladder, channel));
  const tables = h("div", {}, all("luminance"));
  const channel =
      choice("Channel", CHANNELS, "luminance", (value) => tables.replaceChildren(...all(value)));
  return section(
      "ladders", "Assumptions, one at a time",
      [
        "Every rung differs from the one above it by one assumption. Signed differences add up from rung to " +
            "rung, as maps and as bias; RMSE and halo energy do not, and are shown for all so far. " +
            "Of e = this rung \u2212 the one above, or the first, over n skin pixels: bias (1/n) sum e; RMSE " +
            "sqrt((1/n) sum e\u00b2); halo energy: sum |e| within 3s of a silhouette / sum there of the first rung. ",
        `Maps end at \u00b1${(results.maps || {}).ladder_range}, the same for every step.`
      ],
      h("div", {class: "controls"}, channel.element), tables);
}
