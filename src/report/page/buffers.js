// How a method arrives at its answer: the textures that it and its view name on their way, as a strip below the viewer.

const hasBuffers = runs.some((run) => list((run.files || {}).passes).length > 0) ||
    views.some((view) => list((view.files || {}).buffers).length > 0);

function bufferFigure(buffer) {
  const known = pictures.files[buffer.png];
  const white = buffer.channels === "RGB" ? "" : `; white is ${number(buffer.white)}`;
  return h(
      "figure", {class: "buffer"},
      h("a", {href: linkTo(buffer.png), title: `${buffer.shows}${white}. The whole picture; the numbers are in ${buffer.exr}`},
        known ? h("img", {src: pictureUrl(buffer.png), alt: `${buffer.name}: ${buffer.shows}`, loading: "lazy"}) :
                h("em", {}, "not in the page")),
      h("figcaption", {}, h("b", {}, buffer.name), " ", h("span", {class: "muted"}, buffer.shows + white)));
}

// Of the view first, then of the method that the viewer compares.
function bufferStrip(c, label) {
  const run = c.all.find((r) => r.label === label) || {};
  const rows = [
    [`The view ${c.view}`, list((viewOf(c.view).files || {}).buffers)],
    [label, list((run.files || {}).passes)]
  ].filter(([, buffers]) => buffers.length > 0);
  return rows.map(
      ([title, buffers]) =>
          h("div", {class: "buffers"}, h("h4", {}, title, h("span", {class: "muted"}, `  ${plural(buffers.length, "buffer")}`)),
            h("div", {class: "strip", tabindex: "0"}, buffers.map(bufferFigure))));
}
