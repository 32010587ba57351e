// The values behind the pictures: linear, in units of the irradiance, to half a step of 16383 levels.

const values = JSON.parse(document.getElementById("values").textContent);
const LUMINANCE_WEIGHTS = [0.2126, 0.7152, 0.0722];

async function inflated(text) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Residuals (low bytes, then high bytes; the sign in the lowest bit) to codes: each is what is left after
// left + above - above left of its plane.
function codesOf(bytes, width, height) {
  const count = 3 * width * height, codes = new Uint16Array(count);
  for (let i = 0; i < count; ++i) {
    const folded = bytes[i] + 256 * bytes[count + i], residual = folded & 1 ? -(folded + 1) / 2 : folded / 2;
    const hasLeft = i % width > 0, hasAbove = i % (width * height) >= width;
    codes[i] = (hasLeft ? codes[i - 1] : 0) + (hasAbove ? codes[i - width] : 0) -
        (hasLeft && hasAbove ? codes[i - width - 1] : 0) + residual;
  }
  return codes;
}

// {width, height, error, at(i, channel)}: the value of stored pixel i, NaN where there is none; `error` is
// the most by which it differs from the file's.
async function unpackedMap({width, height, low, step, data}) {
  const codes = codesOf(await inflated(data), width, height), plane = width * height;
  const one = (i, c) => low + step * (codes[c * plane + i] - 1);
  return {
    width,
    height,
    error: step / 2,
    at: (i, channel) => codes[i] === 0 ? NaN :
        channel === "luminance"        ? LUMINANCE_WEIGHTS.reduce((sum, w, c) => sum + w * one(i, c), 0) :
                                         one(i, "rgb".indexOf(channel))
  };
}

// Unpacked when first asked for; the last 16 are kept.
const unpackedMaps = new Map();
function valueMap(path) {
  if (!values.maps[path]) return Promise.resolve(null);
  const known = unpackedMaps.get(path) || unpackedMap(values.maps[path]);
  unpackedMaps.delete(path);
  unpackedMaps.set(path, known);
  if (unpackedMaps.size > 16) unpackedMaps.delete(unpackedMaps.keys().next().value);
  return known;
}

const valuePath = (of) => ((of || {}).files || {}).exr;

// The truth and every method of a case: {truth, runs: Map of label to map}; null where one is not there.
async function caseValues(c) {
  if (typeof DecompressionStream === "undefined") return {truth: null, runs: new Map()};
  const truth = await valueMap(valuePath(c.truth)), runsOfCase = new Map();
  for (const run of c.runs) runsOfCase.set(run.label, await valueMap(valuePath(run)));
  return {truth, runs: runsOfCase};
}

// Calls visit(i) for each stored pixel of a region, in shares of the picture.
function forRegion(map, region, visit) {
  const edge = (share, size) => clamp(Math.round(share * size), 0, size);
  for (let y = edge(region.y0, map.height); y < edge(region.y1, map.height); ++y)
    for (let x = edge(region.x0, map.width); x < edge(region.x1, map.width); ++x) visit(y * map.width + x);
}

// test - truth of the region's pixels that have both values.
function regionErrors(truth, test, region, channel) {
  const errors = [];
  forRegion(truth, region, (i) => {
    const e = test.at(i, channel) - truth.at(i, channel);
    if (!Number.isNaN(e)) errors.push(e);
  });
  return errors;
}

function regionStatistics(truth, test, region, channel) {
  const errors = regionErrors(truth, test, region, channel), n = errors.length;
  if (n === 0) return null;
  let truthSquares = 0;
  forRegion(truth, region, (i) => {
    const t = truth.at(i, channel);
    if (!Number.isNaN(t + test.at(i, channel))) truthSquares += t * t;
  });
  const squares = errors.reduce((sum, e) => sum + e * e, 0);
  return {
    pixels: n,
    bias: errors.reduce((sum, e) => sum + e, 0) / n,
    rmse: Math.sqrt(squares / n),
    relative: truthSquares > 0 ? Math.sqrt(squares / truthSquares) : null,
    max: errors.reduce((most, e) => Math.max(most, Math.abs(e)), 0)
  };
}
