// Every picture of every case side by side; a click opens it in the viewer.

const KINDS = [
  {value: "picture", text: "Rendered"}, {value: "magnitude", text: "|Error|"},
  {value: "signed", text: "Signed error"}, {value: "irradiance", text: "Irradiance"},
  {value: "false", text: "False colour"},
  ...(runs.some((run) => (run.files || {}).composite) ?
          [{value: "composite", text: "As seen"}, {value: "visible", text: "Visible difference"}] :
          [])
];
const COLUMN_KINDS = ["picture", "magnitude", "signed", "composite", "visible"];

// Each picture is held once in the page; the object URL is made when it is first shown.
const objectUrls = new Map();
function pictureUrl(path) {
  const index = pictures.files[path].data;
  if (!objectUrls.has(index)) {
    const [head, text] = pictures.data[index].split(",");
    const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    objectUrls.set(index, URL.createObjectURL(new Blob([bytes], {type: head.slice(5).split(";")[0]})));
  }
  return objectUrls.get(index);
}

// What a pane shows: {path, isMap}, or nothing. The truth stands for all kinds but the irradiance.
function pictureOf(c, source, kind) {
  const view = viewOf(c.view);
  if (kind === "irradiance" || source === "irradiance") return {path: (view.files || {}).irradiance};
  if (source === "truth") {
    const files = (c.truth || {}).files || {};
    return {path: ["composite", "visible"].includes(kind) ? files.composite : files.picture};
  }
  const run = c.all.find((r) => r.label === source) || {};
  return {path: (run.files || {})[kind], isMap: !["picture", "composite"].includes(kind)};
}

function viewAspect(c) {
  const view = viewOf(c.view);
  return isNumber(view.width_px) && isNumber(view.height_px) ? view.width_px / view.height_px : 1;
}

// An image cut to the view's own pixels: error maps carry a colour bar below them.
function cropped(c, shown, alt) {
  const known = shown.path && pictures.files[shown.path];
  return h(
      "span", {class: "crop", style: `aspect-ratio:${viewAspect(c)}`},
      known ? h("img", {src: pictureUrl(shown.path), alt, draggable: "false"}) : h("em", {}, "no picture"));
}

// The colour bar, cut out of an error map; a row less above and below, so that scaling blends nothing in.
function barStyle(bar, path) {
  const file = pictures.files[path], height = bar.height_px - 2, top = bar.top_px + 1;
  return `background-image:url(${pictureUrl(path)});background-size:${100 * file.width / bar.width_px}% ${
             100 * file.height / height}%;` +
      `background-position:${100 * bar.left_px / (file.width - bar.width_px)}% ${
             100 * top / (file.height - height)}%`;
}

function colourBar(c, kind) {
  const run = c.runs.find((r) => pictures.files[(r.files || {})[kind]]);
  const maps = results.maps || {}, bar = viewOf(c.view).color_bar;
  const range = kind === "visible" ? maps.visible_range : maps.range;
  if (!run || !isNumber(range) || !bar || !bar.width_px) return null;
  const ends = kind === "signed" ? [MINUS + range, "0", "+" + range] :
                                   ["0", String(range / 2), String(range)];
  return h(
      "span", {class: "colour-bar"}, h("span", {class: "ramp", style: barStyle(bar, run.files[kind])}),
      h("span", {class: "ends"}, ends.map((end) => h("span", {}, end))));
}

function sheetPicture(c, source, kind, alt) {
  const shown = pictureOf(c, source, kind);
  return h(
      "button", {
        class: "thumb",
        type: "button",
        title: alt + " \u2013 open in the viewer",
        onclick: () => openViewer(c, source, kind)
      },
      cropped(c, shown, alt));
}

function methodColumn(c, run) {
  if (run.skipped) {
    return h(
        "div", {class: "column"}, h("div", {class: "column-head"}, methodName(run.label)),
        h("p", {class: "skipped"}, "Skipped: " + run.skipped));
  }
  return h(
      "div", {class: "column"},
      h("div", {class: "column-head"}, methodName(run.label), h("b", {}, errorText(run))),
      COLUMN_KINDS.filter((kind) => KINDS.some((k) => k.value === kind)).map(
          (kind) => sheetPicture(
              c, run.label, kind,
              `${run.label}, ${KINDS.find((k) => k.value === kind).text.toLowerCase()}`)));
}

function truthColumn(c) {
  return h(
      "div", {class: "column"}, h("div", {class: "column-head"}, h("span", {class: "method"}, "Truth")),
      sheetPicture(c, "truth", "picture", "truth"), sheetPicture(c, "irradiance", "irradiance", "irradiance"),
      h("p", {class: "note-box"},
        "Above: irradiance, what every method starts from. Right: |error| and signed error of " +
            "luminance, one range for the whole run."),
      h("div", {class: "bars"}, h("span", {}, "|error|"), colourBar(c, "magnitude"),
        h("span", {}, "test \u2212 truth"), colourBar(c, "signed"),
        hasSeen && [h("span", {}, "visible"), colourBar(c, "visible")]),
      hasSeen && sheetPicture(c, "truth", "composite", "truth, as seen"));
}

function sheet(c) {
  const ordered = [...c.all].sort((a, b) => Boolean(a.skipped) - Boolean(b.skipped) || byError(a, b));
  return h(
      "div", {class: "sheet"}, h("h3", {}, caseName(c)),
      h("div", {class: "columns"}, truthColumn(c), ordered.map((run) => methodColumn(c, run))));
}

function pictureSection() {
  const maps = results.maps || {};
  return section(
      "pictures", "Pictures",
      ["Truth and every method, least error first: rendered, |error|, signed error (test \u2212 truth; " +
       "orange: too bright, blue: too dark), of " +
       `${maps.quantity || "luminance"}. One colour range, ${
           isNumber(maps.range) ? `\u00b1${maps.range}` : "fixed"}, for every map of the run. ` +
       (seenNote() ? seenNote() + " " : "") + "The percentage is the RMSE relative to the truth\u2019s RMS. Click a picture to look closely."],
      viewer(), h("div", {}, cases.map(sheet)));
}
