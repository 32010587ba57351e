// The viewer: a large comparison with a slider, and all methods beside it, zoomed and panned as one.

const viewerState = {
  c: cases[0],
  kind: "magnitude",
  compareKind: "picture",
  left: "truth",
  right: null,
  split: 50,
  zoom: 1,
  x: 0,
  y: 0,
  exposure: 0,
  channel: "luminance",
  region: null
};
const viewerParts = {};

const clamp = (value, low, high) => Math.min(high, Math.max(low, value));

// Position is a share of a pane's size, so that panes of any size show the same place.
function placePanes() {
  const {zoom, x, y} = viewerState;
  viewerParts.root.style.setProperty("--place", `translate(${100 * x}%, ${100 * y}%) scale(${zoom})`);
  viewerParts.root.style.setProperty("--zoom", zoom);
  viewerParts.root.classList.toggle("close", zoom >= 3);
  viewerParts.zoom.textContent = `${number(zoom)}${TIMES}`;
  saveState();
}

function zoomAt(factor, px, py) {
  const zoom = clamp(viewerState.zoom * factor, 1, 24), ratio = zoom / viewerState.zoom;
  viewerState.zoom = zoom;
  moveTo(px - (px - viewerState.x) * ratio, py - (py - viewerState.y) * ratio);
}

function moveTo(x, y) {
  viewerState.x = clamp(x, 1 - viewerState.zoom, 0);
  viewerState.y = clamp(y, 1 - viewerState.zoom, 0);
  placePanes();
}

function resetPlace() {
  viewerState.zoom = 1;
  moveTo(0, 0);
}

function setSplit(percentage) {
  viewerState.split = clamp(percentage, 0, 100);
  viewerParts.root.style.setProperty("--split", viewerState.split + "%");
  viewerParts.handle.setAttribute("aria-valuenow", Math.round(viewerState.split));
  saveState();
}

// Stops: each doubles the light of rendered pictures, and halves the range of false colour.
function setExposure(stops) {
  viewerState.exposure = clamp(stops, -6, 10);
  viewerParts.exposure.textContent = signedText(viewerState.exposure);
  for (const slope of viewerParts.root.querySelectorAll("#exposure *"))
    slope.setAttribute("slope", 2 ** viewerState.exposure);
  viewerParts.root.classList.toggle("exposed", viewerState.exposure !== 0);
  showViewer();
}

// The wheel belongs to the page until the viewer has been clicked, so that scrolling past it does not stick.
function onWheel(event) {
  if (!event.ctrlKey && !viewerParts.root.contains(document.activeElement)) return;
  event.preventDefault();
  const box = event.currentTarget.getBoundingClientRect();
  zoomAt(
      Math.exp(-0.0016 * event.deltaY), (event.clientX - box.left) / box.width,
      (event.clientY - box.top) / box.height);
}

// Where a pointer is in the picture, in shares of it.
function pictureShare(event, pane) {
  const box = pane.getBoundingClientRect();
  return {
    u: ((event.clientX - box.left) / box.width - viewerState.x) / viewerState.zoom,
    v: ((event.clientY - box.top) / box.height - viewerState.y) / viewerState.zoom
  };
}

function setRegion(a, b) {
  const span = (p, q) => [clamp(Math.min(p, q), 0, 1), clamp(Math.max(p, q), 0, 1)];
  const [x0, x1] = span(a.u, b.u), [y0, y1] = span(a.v, b.v), view = viewOf(viewerState.c.view);
  // Less than a pixel is a click: the whole picture again.
  viewerState.region =
      (x1 - x0) * view.width_px < 1 || (y1 - y0) * view.height_px < 1 ? null : {x0, y0, x1, y1};
  placeRegion();
}

function placeRegion() {
  const {x0, y0, x1, y1} = viewerState.region || {x0: 0, y0: 0, x1: 0, y1: 0};
  for (const mark of viewerParts.root.querySelectorAll(".region"))
    mark.style.cssText =
        `left:${100 * x0}%;top:${100 * y0}%;width:${100 * (x1 - x0)}%;height:${100 * (y1 - y0)}%`;
  viewerParts.root.classList.toggle("has-region", viewerState.region !== null);
}

function startRegion(event, pane) {
  const from = pictureShare(event, pane);
  pane.focus({preventScroll: true});
  pane.setPointerCapture(event.pointerId);
  const move = (e) => setRegion(from, pictureShare(e, pane));
  const stop = (e) => {
    pane.removeEventListener("pointermove", move);
    move(e);
    showValues();
  };
  pane.addEventListener("pointermove", move);
  pane.addEventListener("pointerup", stop, {once: true});
}

function startDrag(event, pane, slides) {
  const box = pane.getBoundingClientRect(), from = {x: viewerState.x, y: viewerState.y};
  pane.focus({preventScroll: true});
  pane.setPointerCapture(event.pointerId);
  const move = (e) => {
    if (slides)
      setSplit(100 * (e.clientX - box.left) / box.width);
    else
      moveTo(
          from.x + (e.clientX - event.clientX) / box.width,
          from.y + (e.clientY - event.clientY) / box.height);
  };
  const stop = () => pane.removeEventListener("pointermove", move);
  pane.addEventListener("pointermove", move);
  pane.addEventListener("pointerup", stop, {once: true});
  pane.addEventListener("pointercancel", stop, {once: true});
}

const KEY_MOVES = {
  ArrowLeft: [0.1, 0],
  ArrowRight: [-0.1, 0],
  ArrowUp: [0, 0.1],
  ArrowDown: [0, -0.1]
};

function onKey(event) {
  if (event.key === "+" || event.key === "=")
    zoomAt(1.5, 0.5, 0.5);
  else if (event.key === "-")
    zoomAt(1 / 1.5, 0.5, 0.5);
  else if (event.key === "0")
    resetPlace();
  else if (KEY_MOVES[event.key])
    moveTo(viewerState.x + KEY_MOVES[event.key][0], viewerState.y + KEY_MOVES[event.key][1]);
  else
    return;
  event.preventDefault();
}

function onHandleKey(event) {
  const step = {ArrowLeft: -2, ArrowRight: 2, Home: -100, End: 100}[event.key];
  if (step === undefined) return;
  setSplit(viewerState.split + step);
  event.preventDefault();
  event.stopPropagation();
}

function pane(children, slides) {
  const element = h("div", {class: "pane", tabindex: "0", onwheel: null}, children);
  element.addEventListener("wheel", onWheel, {passive: false});
  element.addEventListener("keydown", onKey);
  element.addEventListener("dblclick", resetPlace);
  element.addEventListener("pointermove", (event) => showPixel(pictureShare(event, element)));
  element.addEventListener("pointerdown", (event) => {
    const onHandle = event.target.closest(".handle") !== null;
    if (event.button !== 0 || event.target.closest("a")) return;
    event.preventDefault();
    if (viewerParts.root.classList.contains("marking") && !onHandle)
      startRegion(event, element);
    else
      startDrag(event, element, slides && (onHandle || viewerState.zoom === 1));
  });
  return element;
}

const KIND_SUFFIXES = {
  magnitude: ", |error|",
  signed: ", signed error",
  composite: ", as seen",
  visible: ", visible difference",
  false: ", false colour"
};
const sourceName = (source, kind) => source === "irradiance" || kind === "irradiance" ? "irradiance" :
    source === "truth" && !["false", "composite", "visible"].includes(kind)           ? "truth" :
    source === "truth" && kind !== "false"                                            ? "truth, as seen" :
                                             source + (KIND_SUFFIXES[kind] || "");

function fullSizeLink(shown) {
  return shown.path ? h("a", {href: linkTo(shown.path), title: "The full-size file in maps/"}, "\u2197") :
                      null;
}

// A picture as a pane shows it: the file, or false colour of its values once they are there.
function paneContent(c, source, kind) {
  const {loaded, channel} = viewerState,
                 map = loaded && (source === "truth" ? loaded.truth : loaded.runs.get(source));
  if (kind !== "false" || source === "irradiance")
    return cropped(c, pictureOf(c, source, kind === "false" ? "irradiance" : kind), sourceName(source, kind));
  return h(
      "span", {class: "crop", style: `aspect-ratio:${viewAspect(c)}`},
      map ? falseColourCanvas(map, channel) : h("em", {}, loaded ? "no values" : "\u2026"));
}

const regionMark = () => h("span", {class: "marks"}, h("i", {class: "region"}));
const exposable = (kind) => (kind === "picture" || kind === "irradiance" ? " exposable" : "");

// Shown instead while Shift is held.
const truthKind = (kind) => (["composite", "visible"].includes(kind) ? "composite" : "picture");
const heldTruth = (c, kind) =>
    h("div", {class: "layer held" + exposable(truthKind(kind))}, cropped(c, pictureOf(c, "truth", truthKind(kind)), "truth"),
      h("span", {class: "tag left"}, "truth"));

function comparison() {
  const {c, compareKind: kind, left, right} = viewerState;
  const a = pictureOf(c, left, kind), b = pictureOf(c, right, kind);
  viewerParts.large.style.aspectRatio = viewAspect(c);
  viewerParts.handle.setAttribute("aria-label", "Divide between the two pictures");
  viewerParts.large.replaceChildren(
      h("div", {class: "layer" + exposable(kind)}, paneContent(c, right, kind)),
      h("div", {class: "layer over" + exposable(left === "truth" && kind !== "false" ? truthKind(kind) : kind)},
        paneContent(c, left, kind)),
      h("span", {class: "tag left"}, sourceName(left, kind)),
      h("span", {class: "tag right"}, sourceName(right, kind)), heldTruth(c, kind), regionMark(),
      viewerParts.handle);
  const exrs = [c.truth, c.all.find((run) => run.label === right)].map(valuePath);
  const paths = unique([a.path, b.path, ...exrs].filter(Boolean));
  viewerParts.links.replaceChildren(
      "Files: ",
      h("span", {}, listed(paths.map((path) => h("a", {href: linkTo(path)}, path.split("/").pop())))));
}

function tile(source) {
  const {c, kind} = viewerState, run = c.all.find((r) => r.label === source);
  const shown = pictureOf(c, source, kind);
  const name =
      run ? methodName(source) : h("span", {class: "method"}, source === "truth" ? "Truth" : "Irradiance");
  return h(
      "figure", {class: "tile" + (source === viewerState.right ? " chosen" : "")},
      h("figcaption", {},
        run ? h("button",
                {type: "button", title: "Compare with this one", onclick: () => chooseRight(source)}, name) :
              name,
        run && run.metrics && h("b", {}, errorText(run)), fullSizeLink(shown)),
      pane(
          [
            h("div", {class: exposable(kind)}, paneContent(c, source, kind)),
            source !== "truth" && heldTruth(c, kind), regionMark()
          ],
          false));
}

function showTiles() {
  const {c, kind} = viewerState;
  const methods = [...c.runs].sort(byError).map((run) => run.label);
  viewerParts.tiles.replaceChildren(...(kind === "irradiance"                      ? ["irradiance"] :
                                            ["picture", "false", "composite"].includes(kind) ? ["truth", ...methods] :
                                                                                     methods)
                                        .map(tile));
  viewerParts.bar.replaceChildren(...[["magnitude", "signed", "visible"].includes(kind) ? colourBar(c, kind) :
                                          kind === "false"                      ? falseColourBar() :
                                                                                  null]
                                      .filter(Boolean));
}

function chooseRight(source) {
  viewerState.right = source;
  showViewer();
}

// The methods by number key, the least error first, as the tiles stand.
const numberedMethods = (c) => [...c.runs].sort(byError).map((run) => run.label);

// The whole large picture is then this method's: flipping compares in place.
function flipTo(index) {
  const label = numberedMethods(viewerState.c)[index];
  if (!label) return;
  setSplit(0);
  chooseRight(label);
}

// --- values ---

// Loads the case's values if need be, then shows what depends on them.
async function showValues() {
  const c = viewerState.c;
  if (!viewerState.loaded || viewerState.loaded.c !== c) {
    viewerState.loaded = null;
    const loaded = {c, ...(await caseValues(c))};
    if (viewerState.c !== c || viewerState.loaded) return;
    viewerState.loaded = loaded;
    if ([viewerState.kind, viewerState.compareKind].includes("false")) showPictures();
  }
  viewerParts.precision.textContent = precisionNote(c, viewerState.loaded);
  showPixel(viewerState.pixel);
  // After the pictures have changed: flipping does not wait for sums over all pixels.
  clearTimeout(viewerState.summing);
  viewerState.summing = setTimeout(showRegion, 80);
}

function showRegion() {
  const {c, loaded, right, region, channel} = viewerState;
  if (!loaded) return;
  viewerParts.region.replaceChildren(...regionPanel(c, loaded, right, region, channel));
  document.documentElement.dataset.values = `${c.view}/${c.profile}`;
}

function showPixel(share) {
  if (share) viewerState.pixel = share;
  const {loaded, c, right} = viewerState, {u, v} = viewerState.pixel || {u: -1, v: -1};
  if (loaded) viewerParts.pixel.replaceChildren(...pixelFacts(c, loaded, right, u, v));
}

function selector(caption, name, withTruth) {
  const options =
      [...(withTruth ? ["truth", "irradiance"] : []), ...viewerState.c.runs.map((run) => run.label)];
  return h(
      "label", {}, caption + " ",
      h("select", {
        onchange: (event) => {
          viewerState[name] = event.target.value;
          showViewer();
        }
      },
        options.map((o) => h("option", {value: o, selected: o === viewerState[name]}, o))));
}

function showViewer() {
  const known = viewerState.c.runs.map((run) => run.label);
  if (!known.includes(viewerState.right))
    viewerState.right =
        ([...viewerState.c.runs].sort(byError).find((run) => !isFree(run)) || {}).label || known[0];
  if (!known.includes(viewerState.left) && viewerState.left !== "irradiance") viewerState.left = "truth";
  viewerParts.pickers.replaceChildren(selector("Left", "left", true), selector("Right", "right", false));
  viewerParts.facts.replaceChildren(...chosenFacts());
  viewerParts.buffers.replaceChildren(...bufferStrip(viewerState.c, viewerState.right));
  showPictures();
  placePanes();
  showValues();
}

function showPictures() {
  comparison();
  showTiles();
  placeRegion();
}

function openViewer(c, source, kind) {
  if (c.runs.some((run) => run.label === source)) viewerState.right = source;
  viewerState.c = c;
  viewerParts.compareKind.show(kind === "irradiance" ? "picture" : kind);
  viewerParts.kind.show(kind);
  for (const which of ["view", "profile"]) viewerParts[which].mark(c[which]);
  viewerParts.root.scrollIntoView({behavior: "smooth", block: "start"});
}

// Another view or profile; where the pair was not run, the nearest case that was.
function chooseCase(which, value) {
  const wanted = {...viewerState.c, [which]: value};
  viewerState.c = cases.find((c) => c.view === wanted.view && c.profile === wanted.profile) ||
      cases.find((c) => c[which] === value);
  for (const other of ["view", "profile"]) viewerParts[other].mark(viewerState.c[other]);
  showViewer();
}

function caseChoice(caption, which, title) {
  const options = unique(cases.map((c) => c[which])).map((value) => ({value, text: title(value)}));
  return choice(caption, options, viewerState.c[which], (value) => chooseCase(which, value));
}

function markRegions(on) {
  viewerParts.root.classList.toggle("marking", on);
  viewerParts.regionButton.setAttribute("aria-pressed", String(on));
}

function viewerControls() {
  viewerParts.view = caseChoice("View", "view", (name) => name);
  viewerParts.profile = caseChoice("Profile", "profile", profileTitle);
  const zoomButton = (text, title, action) => h("button", {type: "button", title, onclick: action}, text);
  return h(
      "div", {class: "controls"}, viewerParts.view.element, viewerParts.profile.element,
      h("div", {class: "choice"}, h("span", {class: "caption"}, "Zoom ", viewerParts.zoom),
        zoomButton("+", "Closer (+)", () => zoomAt(1.5, 0.5, 0.5)),
        zoomButton(MINUS, "Farther (-)", () => zoomAt(1 / 1.5, 0.5, 0.5)),
        zoomButton("Fit", "Whole picture (0)", resetPlace)),
      h("div", {class: "choice"}, h("span", {class: "caption"}, "Exposure ", viewerParts.exposure),
        zoomButton("+", "A stop more (e)", () => setExposure(viewerState.exposure + 1)),
        zoomButton(MINUS, "A stop less (d)", () => setExposure(viewerState.exposure - 1)),
        zoomButton("0", "As rendered", () => setExposure(0))),
      viewerParts.channel.element,
      h("div", {class: "choice"}, viewerParts.regionButton,
        zoomButton("Keys ?", "What the keys do (?)", showHelp)));
}

// What the chosen method's error and cost are, below the tiles.
function chosenFacts() {
  const run = viewerState.c.runs.find((r) => r.label === viewerState.right);
  if (!run) return [];
  const value = (path) => lookUp(run, path).value;
  return [
    h("h4", {}, methodName(run.label), h("span", {class: "muted"}, " " + (run.title || ""))), facts([
      [
        "RMSE / RMS of truth",
        isDistinguishable(run) ? percent(relativeError(run)) : "not distinguishable from the truth"
      ],
      ["p99 of |error|", scientific(value("metrics.p99"))], ["FLIP, mean", number(value("metrics.flip"))],
      ...hasSeen && isNumber(seenOf(run).mean) ?
          [["FLIP as seen, mean, 95 %", `${flipText(seenOf(run).mean)}, ${flipText(seenOf(run).p95)}`]] :
          [],
      [
        "Halo peak, width",
        `${percent(value("metrics.halo.peak"))}, ${
            isNumber(value("metrics.halo.width_mm")) ? number(value("metrics.halo.width_mm")) + " mm" :
                                                       EN_DASH}`
      ],
      [
        "Frame time",
        isFree(run) ? "no pass" :
            isNumber(frameMs(run)) ?
                      `${number(frameMs(run))} ms, ${isSoftware ? "software rasteriser" : "GPU"}` :
                      isTimeShared(run) ? "taken while other work ran on the machine" :
                                          lookUp(run, "cost.frame_ms.median").reason
      ],
      ["Settings", settingsText(run.settings)]
    ])
  ];
}

// Exact for linear light, up to the 8 bits that the pictures have.
function exposureFilter() {
  const slope = (channel) => s("feFunc" + channel, {type: "linear", slope: 1});
  return s(
      "svg", {width: 0, height: 0, "aria-hidden": "true"},
      s("filter",
        {id: "exposure", "color-interpolation-filters": "linearRGB", x: 0, y: 0, width: 1, height: 1},
        s("feComponentTransfer", {}, ["R", "G", "B"].map(slope))));
}

function viewer() {
  if (!cases.some((c) => c.runs.length > 0)) return null;
  viewerState.c = cases.find((c) => c.runs.length > 0);
  for (const [key, value] of Object.entries(savedViewer())) viewerState[key] = value;
  viewerParts.zoom = h("output", {}, "");
  viewerParts.exposure = h("output", {}, "0");
  viewerParts.precision = h("p", {class: "hint"});
  viewerParts.pixel = h("p", {class: "pixel", "aria-live": "off"});
  viewerParts.region = h("div", {class: "region-facts"});
  viewerParts.regionButton =
      h("button", {
        type: "button",
        "aria-pressed": "false",
        title: "Drag a rectangle: its statistics (r)",
        onclick: () => markRegions(!viewerParts.root.classList.contains("marking"))
      },
        "Mark a region");
  viewerParts.channel = choice("Channel", CHANNELS, viewerState.channel, (channel) => {
    viewerState.channel = channel;
    showViewer();
  });
  viewerParts.pickers = h("div", {class: "pickers"});
  viewerParts.handle =
      h("div", {
        class: "handle",
        role: "slider",
        tabindex: "0",
        "aria-valuemin": 0,
        "aria-valuemax": 100,
        onkeydown: onHandleKey
      },
        h("i", {}));
  viewerParts.large = pane([], true);
  viewerParts.large.classList.add("large");
  viewerParts.links = h("span", {class: "links"});
  viewerParts.bar = h("div", {class: "viewer-bar"});
  viewerParts.tiles = h("div", {class: "tiles"});
  viewerParts.root = h("div", {class: "viewer panel", id: "viewer"});
  viewerParts.facts = h("div", {class: "chosen-facts"});
  viewerParts.buffers = h("div", {id: "buffers", hidden: !hasBuffers});
  viewerParts.compareKind =
      choice("as", KINDS.filter((kind) => kind.value !== "irradiance"), viewerState.compareKind, (kind) => {
        viewerState.compareKind = kind;
        showViewer();
      });
  viewerParts.kind = choice("All methods", KINDS, viewerState.kind, (kind) => {
    viewerState.kind = kind;
    showViewer();
  });
  append(viewerParts.root, [
    viewerControls(),
    h("div", {class: "stage"},
      h("div", {class: "compare"},
        h("div", {class: "controls"}, viewerParts.pickers, viewerParts.compareKind.element),
        viewerParts.large, viewerParts.pixel, viewerParts.precision,
        h("p", {class: "hint"}, viewerParts.links, h("br", {}),
          "Drag the divider; click, then wheel to zoom and drag to pan; 1 to 9 flip through the methods, " +
              "Shift held shows the truth; ? names all keys.")),

      h("div", {class: "beside"}, h("div", {class: "controls"}, viewerParts.kind.element), viewerParts.tiles,
        viewerParts.bar, viewerParts.facts, viewerParts.region)),
    viewerParts.buffers, exposureFilter()
  ]);
  setSplit(viewerState.split);
  setExposure(viewerState.exposure);
  moveTo(viewerState.x, viewerState.y);
  return viewerParts.root;
}
