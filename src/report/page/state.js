// What is shown, in the address: copied, it shows the same again.

const saved =
    Object.fromEntries(new URLSearchParams(location.hash.includes("=") ? location.hash.slice(1) : ""));

const oneOf = (value, options, otherwise) => (options.includes(value) ? value : otherwise);
function savedNumber(name, otherwise) {
  const value = Number(saved[name]);
  return saved[name] !== undefined && Number.isFinite(value) ? value : otherwise;
}

function savedRegion() {
  const edges = (saved.region || "").split(",").map(Number);
  return edges.length === 4 && edges.every((e) => e >= 0 && e <= 1) ?
      {x0: edges[0], y0: edges[1], x1: edges[2], y1: edges[3]} :
      null;
}

// The viewer's part; what is not there, or is no longer true of these results, is as it begins.
function savedViewer() {
  const c = cases.find((x) => x.view === saved.view && x.profile === saved.profile && x.runs.length > 0);
  const sources = ["truth", "irradiance", ...labels], kinds = KINDS.map((kind) => kind.value);
  return {
    c: c || viewerState.c,
    kind: oneOf(saved.kind, kinds, viewerState.kind),
    compareKind: oneOf(saved.as, kinds, viewerState.compareKind),
    left: oneOf(saved.left, sources, viewerState.left),
    right: oneOf(saved.method, sources, viewerState.right),
    split: clamp(savedNumber("split", 50), 0, 100),
    zoom: clamp(savedNumber("zoom", 1), 1, 24),
    x: savedNumber("x", 0),
    y: savedNumber("y", 0),
    exposure: savedNumber("exposure", 0),
    channel: oneOf(saved.channel, CHANNELS.map((channel) => channel.value), viewerState.channel),
    region: savedRegion()
  };
}

function stateOfPage() {
  const {c, kind, compareKind, left, right, split, zoom, x, y, exposure, channel, region} = viewerState;
  const sort = sortStates.get("metrics");
  const short = (value) => String(Number(value.toFixed(4)));
  return {
    view: c.view,
    profile: c.profile,
    method: right,
    left: left === "truth" ? null : left,
    as: compareKind === "picture" ? null : compareKind,
    kind: kind === "magnitude" ? null : kind,
    split: split === 50 ? null : short(split),
    zoom: zoom === 1 ? null : short(zoom),
    x: zoom === 1 ? null : short(x),
    y: zoom === 1 ? null : short(y),
    exposure: exposure === 0 ? null : short(exposure),
    channel: channel === "luminance" ? null : channel,
    region: region && [region.x0, region.y0, region.x1, region.y1].map(short).join(","),
    sort: sort && `${sort.descending ? "-" : ""}${sort.column}`,
    theme: document.documentElement.dataset.theme
  };
}

// Browsers allow few changes of the address a second: the last of a burst is written.
let saving = 0;
function saveState() {
  if (document.documentElement.dataset.ready !== "yes" || saving) return;
  saving = setTimeout(() => {
    saving = 0;
    const entries =
        Object.entries(stateOfPage()).filter(([, value]) => value !== null && value !== undefined);
    history.replaceState(null, "", "#" + new URLSearchParams(entries));
  }, 150);
}
