// The results and the pictures, and the few questions that every part asks of them.

const results = JSON.parse(document.getElementById("results").textContent);
const pictures = JSON.parse(document.getElementById("pictures").textContent);

const list = (value) => (Array.isArray(value) ? value : []);
const views = list(results.views);
const profiles = list(results.profiles);
const truths = list(results.truths);
const runs = list(results.runs);
const labels = unique(runs.map((run) => run.label));

const profileOf = (name) => profiles.find((profile) => profile.name === name) || {name};
const viewOf = (name) => views.find((view) => view.name === name) || {name};
const profileTitle = (name) => profileOf(name).title || name;
const headlineTruth = (run) => truths.find((truth) => truth.id === run.truth);

// A case is one view under one profile: what one table and one chart hold.
const cases = unique(runs.map((run) => JSON.stringify([run.view, run.profile]))).map((key) => {
  const [view, profile] = JSON.parse(key);
  const all = runs.filter((run) => run.view === view && run.profile === profile);
  const caseRuns = all.filter((run) => run.metrics);
  return {key, view, profile, all, runs: caseRuns, truth: all.map(headlineTruth).find((truth) => truth)};
});
// Of a view of a sweep: the difficulty there. Empty: it is of none.
function sweepValue(name) {
  const at = (views.find((view) => view.name === name) || {}).sweep;
  return at ? `${results.sweep.title} ${number(at.axis)}` : "";
}

const caseName = (c) => (views.length > 1 || profiles.length < 2 ? c.view : "") +
    (views.length > 1 && profiles.length > 1 ? " \u00b7 " : "") +
    (profiles.length > 1 ? profileTitle(c.profile) : "");

// Colours that people with a colour-vision deficiency tell apart (after Okabe and Ito); beyond eight, the
// marker's shape and the line's dashes change too. The baseline is grey.
const SHAPES = ["circle", "square", "triangle", "diamond"];
const DASHES = ["", "6 3", "2 2", "8 3 2 3"];
// Of a grid of settings, methods have them.
const methodOf = new Map(runs.map((run) => [run.label, labels.length > 32 ? run.method : run.label]));
const coloured = unique([...methodOf.values()]).filter((name) => name !== "none");
function styleOf(label) {
  const i = coloured.indexOf(methodOf.get(label) || label);
  if (i < 0) return {colour: "var(--m-none)", shape: "circle", dash: ""};
  const turn = Math.floor(i / 8) % SHAPES.length;
  return {colour: `var(--m${i % 8})`, shape: SHAPES[turn], dash: DASHES[turn]};
}

const SHAPE_PATHS = {
  circle: "M-5,0a5,5 0 1,0 10,0a5,5 0 1,0 -10,0",
  square: "M-4.5,-4.5h9v9h-9z",
  triangle: "M0,-5.5L5.5,4.5H-5.5z",
  diamond: "M0,-6L6,0L0,6L-6,0z"
};

function swatch(label) {
  const style = styleOf(label);
  return s(
      "svg", {class: "swatch", viewBox: "-6 -6 12 12", "aria-hidden": "true"},
      s("path", {d: SHAPE_PATHS[style.shape], fill: style.colour}));
}

function methodName(label) {
  const run = runs.find((r) => r.label === label) || {};
  return h(
      "span", {class: "method", title: [run.title, run.source].filter(Boolean).join(" \u2013 ")},
      swatch(label), label);
}

const CHANNELS = [
  {value: "luminance", text: "Luminance"}, {value: "r", text: "Red"}, {value: "g", text: "Green"},
  {value: "b", text: "Blue"}
];
const channelName = (channel) => CHANNELS.find((c) => c.value === channel).text.toLowerCase();

function channelOf(metrics, channel) {
  if (!metrics) return {};
  return (channel === "luminance" ? metrics : (metrics.channels || {})[channel]) || {};
}

// A number of a nested object by its path, with the reason where there is none.
function lookUp(object, path) {
  const keys = path.split(".");
  const last = keys.pop();
  const parent = keys.reduce((o, key) => (o && typeof o === "object" ? o[key] : undefined), object);
  if (!parent || typeof parent !== "object")
    return {value: null, reason: (object || {})[keys[0] + "_reason"] || "not measured"};
  return {
    value: isNumber(parent[last]) ? parent[last] : null,
    reason: parent[last + "_reason"] || "not measured"
  };
}

// An object inside another by its path; empty where there is none.
const lookUpObject = (object, path) =>
    path.split(".").reduce((o, key) => (o && typeof o === "object" ? o[key] : undefined), object) || {};

const relativeError = (run) => lookUp(run, "metrics.rel_rmse").value;
// A time that was taken while other work ran on the machine, parts of an experiment beside this one, says nothing of the
// method: no chart has it.
const isTimeShared = (run) => lookUpObject(run, "cost.frame_ms").shared === true;
const frameMs = (run) => isTimeShared(run) ? null : lookUp(run, "cost.frame_ms.median").value;
const fetches = (run) => lookUp(run, "cost.fetches_per_pixel").value;
const timesShared = runs.some(isTimeShared);
// What the cheapest is chosen by.
const price = timesShared ? fetches : frameMs;
const priceUnit = timesShared ? "fetches per pixel" : "ms";
// A run without a pass costs nothing; on a logarithmic axis it is a line, not a point.
const isFree = (run) => lookUp(run, "cost.passes").value === 0;
const isDistinguishable = (run) => run.distinguishable !== false;

// The headline error as it is shown wherever there is room for one number.
function errorText(run) {
  if (isDistinguishable(run)) return percent(relativeError(run));
  return h(
      "span", {class: "doubt", title: `${percent(relativeError(run))}, below the truth\u2019s uncertainty`},
      "not distinguishable");
}

function byError(a, b) {
  const x = relativeError(a), y = relativeError(b);
  return (x === null) - (y === null) || x - y;
}

// Errors are in the units of the irradiance; one power of a thousand for the whole page makes them readable.
const errorExponent = (() => {
  const largest = Math.max(0, ...runs.map((run) => lookUp(run, "metrics.max").value || 0));
  return largest > 0 ? 3 * Math.floor(Math.log10(largest) / 3) : 0;
})();
const inErrorUnits = (value) => (isNumber(value) ? value / 10 ** errorExponent : value);
const errorUnit = errorExponent === 0 ? "" : TIMES + NARROW_SPACE + powerOfTen(errorExponent);

const provenance = results.provenance || {};
const isSoftware = typeof provenance.gl_software === "boolean" ? provenance.gl_software :
    /llvmpipe|softpipe|swrast|software/i.test(provenance.gl_renderer || "");
const repeats = unique(runs.map((run) => lookUp(run, "cost.frame_ms.repeats").value).filter(isNumber));

function timingNote() {
  const renderer = provenance.gl_renderer || "an unknown renderer";
  const threads =
      isNumber(provenance.rasteriser_threads) ? `, ${plural(provenance.rasteriser_threads, "thread")}` : "";
  const median = repeats.length ? `, median of ${repeats.join("/")} frames` : "";
  return `Times are of a ${isSoftware ? "software rasteriser" : "GPU"}: ${renderer}${threads}${median}.` +
      (isSoftware ? " A GPU weighs taps, float formats and filtering differently." : "") +
      (timesShared ? " Other work ran on the machine while they were taken: they are in no chart." : "");
}

// A relative link that any file name survives.
const linkTo = (path) => path.split("/").map(encodeURIComponent).join("/");

function targetName(target) {
  const metric = (target.metric || "unknown").replace(/^./, (c) => c.toUpperCase());
  const cut = isNumber(target.r_max_mm) ? `r_max ${number(target.r_max_mm)} mm` : "no r_max";
  return `${metric}, ${target.normalised === false ? "raw" : "normalised"}, ${cut}` +
      (target.visible_only ? ", visible surface only" : "") +
      (target.transmittance ? ", and what comes through the body" : "");
}
const headlineTarget =
    truths.length ? targetName(truths.find((t) => runs.some((r) => r.truth === t.id)) || truths[0]) +
        ((results.scene || {}).mask_truth === "all" ? ", over all of the surface" : "") :
                    EN_DASH;
