// The first screen: what was asked, the certificate, and in words what the numbers say.

const summaryState = {
  threshold: 0.02
};

function pageHead() {
  const experiment = results.experiment || {};
  const facts = [
    (results.scene || {}).mesh, plural(views.length, "view"), plural(profiles.length, "profile"),
    plural(labels.length, "method"),
    provenance.version &&
        `truescatter ${provenance.version}` +
            (provenance.commit ?
                 ` (${provenance.commit.slice(0, 10)}${provenance.commit_dirty ? ", modified" : ""})` :
                 ""),
    (provenance.finished_utc || "").replace("T", " ").replace("Z", " UTC")
  ];
  return [
    h("p", {class: "kicker"}, facts.filter(Boolean).join("  \u00b7  ")),
    h("h1", {}, experiment.name || "Results"),
    experiment.question && h("p", {class: "question"}, experiment.question), exceededBanner()
  ];
}

function exceededBanner() {
  const lines = list(results.exceeded);
  return lines.length > 0 &&
      h("div", {class: "banner"}, h("strong", {}, "A stated threshold was exceeded."),
        h("ul", {}, lines.map((line) => h("li", {}, line))));
}

// --- the certificate ---

function worst(path) {
  const values = truths.map((truth) => lookUp(truth, path).value).filter(isNumber);
  return values.length ? Math.max(...values) : null;
}

function isCertified(truth) {
  const error = lookUp(truth, "certificate.max_error").value,
        tolerance = lookUp(truth, "certificate.tolerance").value;
  return isNumber(error) && isNumber(tolerance) && error <= tolerance;
}

const AUDIT_CLASSES = {
  random: "drawn at random",
  mask_edge: "at the skin\u2019s edge",
  shadow_edge: "at shadow edges",
  crease: "at creases",
  smallest_s: "where the surface bends within the smallest s",
  cut_locus: "where cut loci start"
};

// "128 drawn at random, 26 at shadow edges, ..." over these truths, those of one view counted once.
function auditedWhere(of) {
  const sums = new Map();
  for (const classes of new Map(of.map((truth) => [truth.view, lookUpObject(truth, "certificate.classes")]))
           .values())
    for (const name of Object.keys(AUDIT_CLASSES))
      if (classes[name] > 0) sums.set(name, (sums.get(name) || 0) + classes[name]);
  return [...sums].map(([name, points]) => `${count(points)} ${AUDIT_CLASSES[name]}`).join(", ");
}

function certificatePanel() {
  const largest = worst("certificate.max_error"), tolerance = worst("certificate.tolerance");
  const failed = truths.some((truth) => !isCertified(truth));
  // The truths of one view are audited at the same pixels: each view counts once.
  const auditedInView =
      new Map(truths.map((truth) => [truth.view, lookUp(truth, "certificate.audited").value || 0]));
  const audited = [...auditedInView.values()].reduce((sum, pixels) => sum + pixels, 0);
  const residual = (results.scene || {}).irradiance_residual || {};
  const row = (name, value, note) =>
      [h("dt", {}, name), h("dd", {}, h("b", {}, value), note && h("span", {class: "muted"}, " " + note))];
  return h(
      "aside", {class: "panel certificate " + (failed ? "bad" : "good")},
      h("h2", {}, "The truth\u2019s certificate",
        h("span", {class: "verdict"},
          truths.length === 0 ? "none" :
              failed          ? "failed" :
                                "passed")),
      h("p", {class: "muted"},
        "Every pixel\u2019s truth comes from the fast engine; the exact one, with closed forms, audits it. " +
            "In units of the scene\u2019s largest irradiance, each figure the largest of ",
        plural(truths.length, "truth"), ":"),
      h("dl", {}, row("Largest difference", scientific(largest), `of ${scientific(tolerance)} allowed`),
        row("Pixels audited", count(audited),
            auditedWhere(truths) || "half random, half where the risk is highest"),
        row("Left open", percent(worst("certificate.open_share_95")),
            "of a view\u2019s pixels at most, at 95 % confidence, may differ by more"),
        row("Tail beyond the search", scientific(worst("certificate.tail_bound")), "bound"),
        row("Uncertainty", scientific(worst("uncertainty")),
            "difference + tail, times a profile\u2019s weights where they exceed 1; an error below it is " +
                "\u201cnot distinguishable\u201d")),
      h("p", {class: "aside"}, h("b", {}, "Never added: "),
        "the irradiance field that methods and truth share differs from the " +
            `real lighting by ${scientific(residual.mean)} (mean) and ${
                scientific(residual.p99)} (p99). It is no part of any error here.`));
}

// --- in words ---

const costed = (c) => c.runs.filter((run) => isNumber(relativeError(run)));
const best = (c) => [...costed(c)].sort(byError)[0];

// [[label, cases], ...] of the run that `pick` chooses in each case, the most frequent first.
function tally(pick) {
  const found = new Map();
  for (const c of cases) {
    const run = pick(c);
    if (run) found.set(run.label, [...(found.get(run.label) || []), {c, run}]);
  }
  return [...found].sort((a, b) => b[1].length - a[1].length);
}

const ofCases = (n) => (cases.length === 1 ? "" : ` in ${n} of ${cases.length} cases`);

function range(values, format) {
  const low = format(Math.min(...values)), high = format(Math.max(...values));
  return low === high ? low : `${low.replace(/\u202f%$/, "")} to ${high}`;
}

function leastErrorSentence() {
  const winners = tally(best);
  if (winners.length === 0) return null;
  return [
    h("b", {}, "Least error: "),
    listed(winners.map(
        ([label, found]) =>
            [methodName(label), ofCases(found.length),
             found.every((f) => isDistinguishable(f.run)) ?
                 ` (RMSE ${range(found.map((f) => relativeError(f.run)), percent)} of the truth\u2019s RMS)` :
                 " (at or below the truth\u2019s uncertainty)"])),
    "."
  ];
}

function cheapest(c, threshold) {
  const within = costed(c).filter((run) => relativeError(run) <= threshold && isNumber(price(run)));
  return within.sort((a, b) => (isFree(b) - isFree(a)) || price(a) - price(b))[0];
}

function cheapestSentence() {
  const input = h("input", {
    type: "number",
    min: 0.1,
    step: 0.1,
    value: String(Number((100 * summaryState.threshold).toPrecision(4))),
    "aria-label": "Largest error, in percent",
    onchange: (event) => setThreshold(event.target.value / 100)
  });
  const winners = tally((c) => cheapest(c, summaryState.threshold));
  const none = cases.filter((c) => !cheapest(c, summaryState.threshold)).map(caseName);
  const parts = winners.map(
      ([label, found]) =>
          [methodName(label), ofCases(found.length),
           isFree(found[0].run) ? " (no pass at all is needed)" :
                                  ` (${range(found.map((f) => price(f.run)), number)} ${priceUnit})`]);
  return [
    h("b", {}, "Cheapest within ", input, " %: "), parts.length ? listed(parts) : "no method", ".",
    parts.length && none.length ? ` Nothing stays within it in ${none.join("; ")}.` : ""
  ];
}

// --- the opening sentence ---

// What is chosen from: methods, and where several sums of Gaussians stand for one profile, or views differ in
// size alone, a choice of these too, as in the chart of settings and in `advise`. Along a sweep each view is a
// case of its own. [{name, label, entries: [{c, run}]}], the largest error first, and how many cases there are.
function openingSettings() {
  const groups = results.sweep ? cases.map((c) => ({cases: [c], sums: 1, sizes: 1})) : paretoGroups();
  const settings = new Map();
  for (const group of groups)
    for (const c of group.cases)
      for (const run of c.all) {
        const view = viewOf(c.view);
        const key = JSON.stringify(
            [run.label, group.sums > 1 && c.profile, group.sizes > 1 && [view.width_px, view.height_px]]);
        if (!settings.has(key)) {
          const name = [methodName(run.label), settingName(group, run).slice(run.label.length)];
          settings.set(key, {name, label: run.label, entries: []});
        }
        if (isNumber(settingError(run))) settings.get(key).entries.push({c, run});
      }
  for (const {entries} of settings.values()) entries.sort((a, b) => settingError(b.run) - settingError(a.run));
  return {groups: groups.length, settings: [...settings.values()].filter((x) => x.entries.length > 0)};
}

const largestError = (setting) => settingError(setting.entries[0].run);
const largestPrice = (setting) => Math.max(...setting.entries.map(({run}) => price(run)));
const costsNothing = (setting) => setting.entries.every(({run}) => isFree(run));

// The step of a ladder up to this method's rung that changes most, if it is on one: of the ladders of this case
// before those of another, of one named after it before others. {ladder, rung}, or null.
function costliestStep(label, c) {
  const on = list(results.ladders)
                 .filter((ladder) => !ladder.skipped && list(ladder.rungs).some((r) => r.rung === label));
  const here = (ladder) => (ladder.view === c.view && ladder.profile === c.profile) * 2 + (ladder.name === label);
  const ladder = on.sort((a, b) => here(b) - here(a))[0];
  if (!ladder) return null;
  const cost = (rung) => lookUp(rung, "step.rmse").value || 0;
  const until = ladder.rungs.slice(1, ladder.rungs.findIndex((r) => r.rung === label) + 1);
  const rung = [...until].sort((a, b) => cost(b) - cost(a))[0];
  return rung ? {ladder, rung, rmse: cost(rung)} : null;
}

function targetText(own) {
  return [
    own.metric, own.normalised ? "normalised" : "raw", isNumber(own.r_max_mm) && `cut at ${number(own.r_max_mm)} mm`,
    own.visible_only && "visible surface alone", own.transmittance && "with light through the body"
  ].filter(Boolean).join(", ");
}

// What the ladder says; without one, on which side of the method's own target the error lies.
function costliestAssumption(label, {c, run}) {
  if (isFree(run)) return "it assumes that light leaves where it came in, which is all of that error";
  const step = costliestStep(label, c);
  if (step) {
    const {ladder, rung} = step;
    return `the assumption that costs it most is \u201c${rung.assumption}\u201d (RMSE ${
        number(inErrorUnits(step.rmse))}${errorUnit && " " + errorUnit}, ${ladder.view}, ${
        profileTitle(ladder.profile)})`;
  }
  const unknown = "which of its assumptions costs it most was not measured";
  const own = run.own_target, error = relativeError(run), left = own && lookUp(own, "metrics.rel_rmse").value;
  if (!own || !isNumber(left) || own.truth === run.truth) {
    const reason = own && own.metrics_reason;
    return unknown + (reason ? ` (against its own target: ${reason})` : " (it is on no ladder)");
  }
  // Errors add as squares where they are not alike: below half, three quarters of the square are elsewhere.
  const aim = targetText(own);
  if (left <= 0.5 * error)
    return `the assumption that costs it most is its aim (${aim}): against that it is off by ${percent(left)}`;
  const share = left >= 0.8 * error ? "costs it little" : "is a part of it";
  return `its aim (${aim}) ${share}: against that it is off by ${percent(left)}, and no ladder takes apart what ` +
      "it assumes beyond that";
}

function verdict() {
  const {threshold} = summaryState, {groups, settings} = openingSettings();
  const complete = settings.filter((setting) => setting.entries.length === groups);
  const within =
      complete
          .filter(
              (setting) => largestError(setting) <= threshold &&
                  setting.entries.every(({run}) => isFree(run) || isNumber(price(run))))
          .sort((a, b) => (costsNothing(b) - costsNothing(a)) || largestPrice(a) - largestPrice(b))[0];
  const nearest = [...(complete.length > 0 ? complete : settings)].sort((a, b) => largestError(a) - largestError(b));
  const chosen = within || nearest[0];
  if (!chosen) return null;
  const {c, run} = chosen.entries[0], everywhere = groups > 1 ? " in every case" : "";
  const time = costsNothing(chosen) ? "no pass at all" : `at most ${number(largestPrice(chosen))} ${priceUnit}`;
  const part = complete.length > 0 ? "" : ` (measured in ${chosen.entries.length} of ${groups} cases)`;
  return h(
      "p", {class: "verdict-text", id: "verdict"},
      within ? [chosen.name, ` is the cheapest method within ${percent(threshold)}${everywhere} (${time})`] :
               [`No method stays within ${percent(threshold)}${everywhere}; the nearest is `, chosen.name, part],
      `; it is worst in ${caseName(c) || c.view}, at ${percent(settingError(run))}`,
      run.profile_error && " against the profile itself", "; ", costliestAssumption(chosen.label, chosen.entries[0]),
      ".");
}

function worseThanNothingSentence() {
  const found = new Map();
  for (const c of cases) {
    const baseline = costed(c).find(isFree);
    if (!baseline) continue;
    for (const run of costed(c).filter((r) => relativeError(r) > relativeError(baseline))) {
      found.set(run.label, [...(found.get(run.label) || []), run]);
    }
  }
  if (found.size === 0) return null;
  return [
    h("b", {}, "Worse than no scattering at all: "),
    listed([...found].map(
        ([label, worse]) =>
            [methodName(label), ofCases(worse.length),
             ` (up to ${percent(Math.max(...worse.map(relativeError)))})`])),
    "."
  ];
}

// The two runs whose order by time contradicts their order by fetches the most.
function largestInversion() {
  let largest = null;
  for (const c of cases) {
    const paid = costed(c).filter((run) => frameMs(run) > 0 && fetches(run) > 0);
    for (const a of paid)
      for (const b of paid) {
        const time = Math.log(frameMs(b) / frameMs(a)), work = Math.log(fetches(a) / fetches(b));
        const size = Math.min(time, work);
        if (size > 0.05 && (!largest || size > largest.size)) largest = {c, a, b, size};
      }
  }
  return largest;
}

function inversionSentence() {
  if (timesShared) {
    return [
      h("b", {}, "Times"), " were taken while other work ran on the machine: they are in no chart, and the cheapest is so by ",
      "fetches."
    ];
  }
  const found = largestInversion();
  if (!found) return [h("b", {}, "Time and fetches"), " rank the methods alike in every case."];
  const {c, a, b} = found;
  return [
    h("b", {}, "Time and fetches rank differently: "), methodName(a.label), " takes less time than ",
    methodName(b.label),
    ` (${number(frameMs(a))} against ${number(frameMs(b))} ms) with more fetches per pixel (${
        number(fetches(a))} against ` +
        `${number(fetches(b))})`,
    cases.length > 1 ? `, most of all in ${caseName(c)}` : "", "."
  ];
}

function doubtSentence() {
  const hidden = unique(runs.filter((run) => run.metrics && !isDistinguishable(run)).map((run) => run.label));
  return hidden.length > 0 &&
      [h("b", {}, "Not distinguishable from the truth: "), listed(hidden.map(methodName)), "."];
}

function skippedSentence() {
  const skipped =
      unique(runs.filter((run) => run.skipped).map((run) => JSON.stringify([run.label, run.skipped])));
  return skipped.length > 0 && [
    h("b", {}, "Skipped: "), listed(skipped.map((key) => {
      const [label, reason] = JSON.parse(key);
      return [methodName(label), ` (${reason})`];
    })),
    "."
  ];
}

function summaryText() {
  const sentences = [
    leastErrorSentence(), cheapestSentence(), worseThanNothingSentence(), inversionSentence(),
    doubtSentence(), ...(hasSeen ? [unseenSentence(), seenSpanSentence(), reversalSentence()] : []), skippedSentence()
  ].filter(Boolean);
  return h(
      "div", {id: "words"}, verdict(),
      h("p", {class: "words"}, sentences.map((sentence) => [sentence, " "])));
}

// --- the matrix of methods and cases ---

function matrixRow(label, largest) {
  const cells = cases.map((c) => {
    const run = c.all.find((r) => r.label === label);
    if (!run || run.skipped)
      return h("td", {class: "muted", title: run ? run.skipped : "not run"}, run ? "skipped" : EN_DASH);
    const value = relativeError(run);
    return h(
        "td", {class: run === best(c) ? "best" : "", "data-value": value === null ? "" : value},
        isDistinguishable(run) &&
            h("span", {class: "bar"},
              h("i", {style: `width:${100 * (value || 0) / largest}%;background:${styleOf(label).colour}`})),
        h("span", {class: "value" + (isDistinguishable(run) ? "" : " alone")}, errorText(run)),
        isNumber(seenOf(run).mean) && h("small", {class: "seen"}, ` ${flipText(seenOf(run).mean)}`));
  });
  return h("tr", {}, h("th", {scope: "row"}, methodName(label)), cells);
}

function meanError(label) {
  const values = runs.filter((run) => run.label === label).map(relativeError).filter(isNumber);
  return values.length ? values.reduce((a, b) => a + b) / values.length : Infinity;
}

function matrix() {
  const largest = Math.max(1e-12, ...runs.map((run) => relativeError(run) || 0));
  const rows = [...labels].sort((a, b) => meanError(a) - meanError(b));
  return h(
      "div", {class: "scroll"},
      // As wide as its names and values are, and scrolled where that is too much.
      sortable(h("table", {class: "matrix", style: `min-width: ${190 + 76 * cases.length}px`},
        h("caption", {},
          "RMSE of luminance relative to the truth\u2019s RMS. Headline target: " + headlineTarget + "." +
              (hasSeen ? " Beside it the mean FLIP of the final picture." : "")),
        h("thead", {},
          h("tr", {}, h("th", {}, "Method"),
            cases.map(
                (c) =>
                    h("th", {scope: "col"}, c.view, h("small", {}, sweepValue(c.view) || profileTitle(c.profile)))))),
        h("tbody", {}, rows.map((label) => matrixRow(label, largest)))), "matrix"));
}

function overview() {
  return h(
      "section", {id: "overview"},
      h("div", {class: "first"},
        h("div", {class: "said"}, h("h2", {}, "What this run says"), summaryText(), matrix()),
        certificatePanel()));
}

function setThreshold(value) {
  if (!(value > 0)) return;
  summaryState.threshold = value;
  document.getElementById("words").replaceWith(summaryText());
  document.getElementById("cost-charts").replaceWith(costCharts());
}
