// What of an error a person sees: FLIP between the final picture of a method and that of the truth.

const hasSeen = runs.some((run) => (run.metrics || {}).visible);
const seenOf = (run) => (run.metrics || {}).visible || {};

// At 95 % of the pixels no more than this: the two pictures pass for one another.
const SEEN_LIMIT = 0.05;
const isUnseen = (run) => isNumber(seenOf(run).p95) && seenOf(run).p95 <= SEEN_LIMIT;

const flipText = (value) => String(Number(value.toPrecision(2)));

function seenAt() {
  const ppd = (results.composite || {}).pixels_per_degree;
  return isNumber(ppd) ? `at ${Math.round(ppd)} pixels a degree` : "";
}

// Of methods that no picture tells from the truth, though their exitance differs.
function unseenSentence() {
  const always = labels.filter((label) => {
    const all = runs.filter((run) => run.label === label && isNumber(seenOf(run).p95));
    return all.length > 0 && all.every(isUnseen);
  });
  const differ = always.filter((label) => runs.some((run) => run.label === label && isDistinguishable(run)));
  const errors = runs.filter((run) => differ.includes(run.label)).map(relativeError).filter(isNumber);
  const parts = [h("b", {}, `In the final picture, ${seenAt()}: `)];
  if (differ.length === 0) {
    const some = runs.some((run) => isUnseen(run) && isDistinguishable(run));
    return [
      ...parts,
      some ? "no method passes for the truth in every case." :
             `no method whose exitance differs passes for the truth (FLIP above ${SEEN_LIMIT} at more than 5 % of the pixels).`
    ];
  }
  const others = labels.filter((label) => !always.includes(label) && runs.some((r) => r.label === label && r.metrics));
  return [
    ...parts, listed(differ.map(methodName)), " cannot be told from the truth (FLIP at most ", String(SEEN_LIMIT),
    " at 95 % of the pixels) although the exitance differs by ", range(errors, percent),
    others.length ? [" \u2013 ", listed(others.map(methodName)), " can"] : "", "."
  ];
}

// The pair that exitance and eye rank most differently: {c, a, b}, a nearer to the truth and yet more visible, by mean
// and by 95 % quantile.
function largestReversal() {
  let largest = null;
  for (const c of cases) {
    const seen = costed(c).filter((run) => isNumber(seenOf(run).mean) && seenOf(run).mean > 0 && relativeError(run) > 0);
    for (const a of seen)
      for (const b of seen) {
        const size = Math.min(
            Math.log(relativeError(b) / relativeError(a)), Math.log(seenOf(a).mean / seenOf(b).mean),
            Math.log(seenOf(a).p95 / seenOf(b).p95));
        if (size > 0.1 && (!largest || size > largest.size)) largest = {c, a, b, size};
      }
  }
  return largest;
}

function reversalSentence() {
  const found = largestReversal();
  if (!found) return [h("b", {}, "Eye and exitance"), " rank the methods alike, to 10 %."];
  const {c, a, b} = found;
  return [
    h("b", {}, "Eye and exitance rank differently: "), methodName(a.label), " errs less than ", methodName(b.label),
    ` (${percent(relativeError(a))} against ${percent(relativeError(b))}) and is seen more (mean FLIP ${
        flipText(seenOf(a).mean)} against ${flipText(seenOf(b).mean)})`,
    cases.length > 1 ? `, most of all in ${caseName(c)}` : "", "."
  ];
}

// Where the eye's limit lies among the errors: the least that is seen, which may be within the truth's doubt, and the
// largest that is not.
function seenSpanSentence() {
  const inCase = (run) => cases.length > 1 ? ` in ${caseName(cases.find((c) => c.all.includes(run)))}` : "";
  const known = runs.filter((run) => isNumber(seenOf(run).p95) && isNumber(relativeError(run)));
  const byError = (a, b) => relativeError(a) - relativeError(b);
  const seen = known.filter((run) => !isUnseen(run)).sort(byError)[0];
  const unseen = known.filter((run) => isUnseen(run) && isDistinguishable(run)).sort(byError).pop();
  if (!seen || !unseen) return null;
  const crossed = relativeError(seen) < relativeError(unseen);
  const how = isDistinguishable(seen) ? "" : ", which its exitance alone does not tell from the truth";
  return [
    `The least error that is seen is `, methodName(seen.label), `\u2019s ${percent(relativeError(seen))}${inCase(seen)}${how}`,
    crossed ? ", less than the largest that is not, " : "; the largest that is not, ",
    methodName(unseen.label), `\u2019s ${percent(relativeError(unseen))}${inCase(unseen)}.`
  ];
}

// How the pictures were made, for who reads them.
function seenNote() {
  const made = results.composite;
  if (!made) return null;
  const gloss = !made.specular ? "no specular light" :
                                 `specular light (Kelemen & Szirmay-Kalos, ${
                                     made.regions ? `regions of ${made.regions}` :
                                                    `intensity ${number(made.intensity)}, roughness ${number(made.roughness)}`})`;
  const tone = made.tone === "filmic" ? "y = x (2.51 x + 0.03) / (x (2.43 x + 0.59) + 0.14)" : "clipped at 1";
  return `As seen: exitance times albedo, and ${gloss}; x = ${number(made.exposure)} \u00d7 light / largest irradiance, ` +
      `${tone}, sRGB. Visible: FLIP between a method\u2019s and the truth\u2019s, ${seenAt()}, 0 to ${
          (results.maps || {}).visible_range}.`;
}
