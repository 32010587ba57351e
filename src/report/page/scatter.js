// Cost against error: one chart by time and one by fetches for each case, on shared logarithmic axes.

const SCATTER = {
  width: 590,
  height: 300,
  left: 58,
  right: 16,
  top: 14,
  bottom: 44
};

const runTip =
    (run) => [run.label + (isDistinguishable(run) ? "" : " (not distinguishable)"),
              `error ${percent(relativeError(run))}`,
              `frame ${number(frameMs(run))} ms (${number(lookUp(run, "cost.frame_ms.min").value)}..${
                  number(lookUp(run, "cost.frame_ms.max").value)})`,
              `${number(fetches(run))} fetches, ${
                  count(lookUp(run, "cost.bytes_per_pixel").value)} bytes per skin pixel`,
              "settings: " + settingsText(run.settings)]
                 .join("\n");

// Of many settings, those of the front alone are labelled.
const MOST_LABELLED = 16;

// Runs that no other run beats in both; a free run takes part at cost 0.
function paretoFront(points) {
  const front = [];
  for (const point of [...points].sort((a, b) => a.cost - b.cost || a.error - b.error)) {
    if (front.length === 0 || point.error < front[front.length - 1].error) front.push(point);
  }
  return front;
}

// The front as a line from the left edge, or the top, to the right one: nothing is better in both below it.
function frontSeries(front, x, y) {
  const corners = [];
  let level = y.to;
  for (const point of front) {
    const at = point.cost > 0 ? point.cost : x.from, error = Math.min(point.error, y.to);
    corners.push({x: at, y: corners.length === 0 && point.cost === 0 ? error : level}, {x: at, y: error});
    level = error;
  }
  if (corners.length > 0) corners.push({x: x.to, y: level});
  return {
    name: "Pareto front",
    colour: "var(--soft)",
    line: 1.3,
    quiet: true,
    obstacle: true,
    points: corners
  };
}

// The error that the reader asked for, where the axis has it.
function thresholdLevels(y) {
  const at = 100 * summaryState.threshold;
  return isOn(y, at) ? [{axis: "y", at, kind: "level", text: `${Number(at.toPrecision(4))} %`}] : [];
}

const baselineLevel = (run) => ({
  axis: "y",
  at: 100 * relativeError(run),
  kind: "baseline",
  text: `${run.label}: ${percent(relativeError(run))}, no pass`
});

const runName = (run) => run.label + (isDistinguishable(run) ? "" : " (not distinguishable)");
const caseOf = (run) => cases.find((c) => c.view === run.view && c.profile === run.profile);
const showRun = (run) => openViewer(caseOf(run), run.label, "magnitude");
const runWhisker = (run) =>
    ({least: lookUp(run, "cost.frame_ms.min").value, most: lookUp(run, "cost.frame_ms.max").value});

function runSeries(run, point) {
  const style = styleOf(run.label);
  return {
    name: run.label,
    colour: style.colour,
    marker: style.shape,
    points: [{...point, hollow: !isDistinguishable(run), pick: () => showRun(run)}]
  };
}

// `axis`: {cost(run), label, domain, whiskers}.
function scatterChart(c, axis, yDomain) {
  const x = {title: axis.label, scale: "log", from: axis.domain[0], to: axis.domain[1]};
  const y = {title: "RMSE / RMS of truth, %", scale: "log", from: yDomain[0], to: yDomain[1]};
  const shown = costed(c).filter((run) => isNumber(axis.cost(run)) && relativeError(run) > 0);
  const points = shown.map((run) => ({
                             run,
                             cost: isFree(run) ? 0 : axis.cost(run),
                             error: Math.max(1.12 * yDomain[0], 100 * relativeError(run))
                           }));
  const paid = points.filter((p) => p.cost > 0), front = paretoFront(points);
  const isLabelled = (p) => paid.length <= MOST_LABELLED || front.includes(p);
  return chartElement({
    name: `${axis.label} against relative RMSE, ${caseName(c)}`,
    attributes: {class: "scatter"},
    size: SCATTER,
    x,
    y,
    hover: "point",
    levels: [...thresholdLevels(y), ...points.filter((p) => p.cost === 0).map((p) => baselineLevel(p.run))],
    series: [
      frontSeries(front, x, y), ...paid.map((p) => runSeries(p.run, {
                                              x: p.cost,
                                              y: p.error,
                                              tip: runTip(p.run),
                                              label: isLabelled(p) && runName(p.run),
                                              ...(axis.whiskers ? runWhisker(p.run) : {})
                                            }))
    ]
  });
}

function costCharts() {
  const paid = runs.filter((run) => run.metrics && !isFree(run));
  const time = {
    cost: frameMs,
    label: "Frame time, ms",
    whiskers: true,
    domain: logDomain(
        paid.flatMap(
            (run) =>
                [frameMs(run), lookUp(run, "cost.frame_ms.min").value,
                 lookUp(run, "cost.frame_ms.max").value]),
        1.35)
  };
  const work = {
    cost: fetches,
    label: "Texture fetches per skin pixel",
    domain: logDomain(paid.map(fetches), 1.5)
  };
  // What cannot be told from the truth stands at the lower edge, wherever below it its error lies.
  const yDomain =
      logDomain(runs.filter(isDistinguishable).map((run) => 100 * (relativeError(run) || 0)), 1.35);
  return h(
      "div", {id: "cost-charts"}, paretoGroups().filter((group) => group.cases.length > 1).map(paretoCard),
      paretoGroups()
          .filter((group) => group.cases.length === 1 && costed(group.cases[0]).length > 0)
          .map((group) => group.cases[0])
          .map(
              (c) =>
                  h("div", {class: "pair"}, h("h3", {}, caseName(c)),
                    h("figure", {class: "panel"}, scatterChart(c, time, yDomain)),
                    h("figure", {class: "panel"}, scatterChart(c, work, yDomain)))));
}

function costSection() {
  return section(
      "speed", "Speed against accuracy",
      [
        timingNote(),
        " Whiskers run from the least to the most. The line is the Pareto front: nothing below and to " +
            "the left of it. Left by time, right by fetches, " +
            "which do not depend on the rasteriser; same axes everywhere. A click on a point shows its pictures."
      ],
      costCharts(), chartNote());
}
