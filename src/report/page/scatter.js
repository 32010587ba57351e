// Cost against error: one chart by time and one by fetches for each case, on shared logarithmic axes.

const SCATTER = {
  width: 590,
  height: 300,
  left: 58,
  right: 16,
  top: 14,
  bottom: 44
};

// Ticks of a logarithmic axis: 1, 2, 5 in each decade, or decades alone where there are many.
function logTicks([low, high]) {
  const steps = Math.log10(high / low) > 2.5 ? [1] : [1, 2, 5];
  const ticks = [];
  for (let e = Math.floor(Math.log10(low)); e <= Math.ceil(Math.log10(high)); ++e) {
    for (const step of steps) {
      const tick = Number((step * 10 ** e).toPrecision(3));
      if (tick >= low * 0.999 && tick <= high * 1.001) ticks.push(tick);
    }
  }
  return ticks;
}

function logDomain(values, pad) {
  const positive = values.filter((v) => isNumber(v) && v > 0);
  if (positive.length === 0) return [0.1, 10];
  return [Math.min(...positive) / pad, Math.max(...positive) * pad];
}

function logScale([low, high], from, to) {
  const scale = (value) => from + (to - from) * Math.log(value / low) / Math.log(high / low);
  scale.inside = (value) => value >= low && value <= high;
  return scale;
}

const runTip =
    (run) => [run.label + (isDistinguishable(run) ? "" : " (not distinguishable)"),
              `error ${percent(relativeError(run))}`,
              `frame ${number(frameMs(run))} ms (${number(lookUp(run, "cost.frame_ms.min").value)}..${
                  number(lookUp(run, "cost.frame_ms.max").value)})`,
              `${number(fetches(run))} fetches, ${
                  count(lookUp(run, "cost.bytes_per_pixel").value)} bytes per skin pixel`,
              "settings: " + settingsText(run.settings)]
                 .join("\n");

function marker(run, x, y) {
  const style = styleOf(run.label);
  return s("path", {
    class: "marker",
    d: SHAPE_PATHS[style.shape],
    transform: `translate(${x},${y})`,
    stroke: style.colour,
    fill: isDistinguishable(run) ? style.colour : "var(--panel)",
    "data-tip": runTip(run)
  });
}

// About as wide as the page's font sets it.
const textWidth = (text, size = 12) => 0.6 * size * text.length;
const overlap = (a, b) => a.x < b.x + b.w && b.x < a.x + a.w && a.y < b.y + b.h && b.y < a.y + a.h;

// Where a label may stand: close by first, then farther off, where a line leads to it.
function labelPlaces({x, y}) {
  const close = [
    [7, -9, "start"], [-8, 18, "end"], [0, 20, "middle"], [-11, 4, "end"], [8, 18, "start"], [11, 4, "start"],
    [-8, -9, "end"], [0, -11, "middle"]
  ].map(([dx, dy, anchor]) => ({x: x + dx, y: y + dy, anchor}));
  const far = [28, 44, 60, 76, 92].flatMap(
      (d) => [[0, d, "middle"], [0, -d, "middle"], [0.8 * d, d, "start"], [-0.8 * d, d, "end"],
              [0.8 * d, -d, "start"], [-0.8 * d, -d, "end"]]
                 .map(([dx, dy, anchor]) => ({x: x + dx, y: y + dy + 4, anchor, led: true})));
  return [...close, ...far];
}

// The first place whose label covers nothing and stays inside; at least inside, where there is none.
function placeLabel(point, text, taken, frame) {
  const w = textWidth(text), places = labelPlaces(point);
  const box = (place) => ({
    x: place.x -
        (place.anchor === "end"        ? w :
             place.anchor === "middle" ? w / 2 :
                                         0),
    y: place.y - 11,
    w,
    h: 14
  });
  const inside = (place) => {
    const b = box(place);
    return b.x >= frame.left && b.x + b.w <= frame.right && b.y >= frame.top && b.y + b.h <= frame.bottom;
  };
  const isFreeOf = (place) => !taken.some((other) => overlap(box(place), other));
  const place = places.find((p) => inside(p) && isFreeOf(p)) || places.find(inside) || places[0];
  taken.push(box(place));
  return place;
}

function directLabel(p, taken, frame) {
  const text = p.run.label + (isDistinguishable(p.run) ? "" : " (not distinguishable)"),
        colour = styleOf(p.run.label).colour;
  const place = placeLabel(p, text, taken, frame), below = place.y > p.y;
  return [
    place.led && s("line", {
      class: "leader",
      stroke: colour,
      x1: p.x,
      y1: p.y + (below ? 6 : -6),
      x2: place.x,
      y2: place.y + (below ? -11 : 3)
    }),
    s("text", {
      class: "direct",
      x: place.x,
      y: place.y,
      "text-anchor": place.anchor,
      fill: colour,
      "data-tip": runTip(p.run)
    },
      text)
  ];
}

// Of many settings, those of the front alone.
const MOST_LABELLED = 16;
const labelled = (paid, front) =>
    paid.length > MOST_LABELLED ? paid.filter((p) => front.some((f) => f.run === p.run)) : paid;

// Runs that no other run beats in both; a free run takes part at cost 0.
function paretoFront(points) {
  const front = [];
  for (const point of [...points].sort((a, b) => a.cost - b.cost || a.error - b.error)) {
    if (front.length === 0 || point.error < front[front.length - 1].error) front.push(point);
  }
  return front;
}

function frontPath(front, x, y, frame) {
  let path = "", level = frame.top;
  for (const point of front) {
    const px = point.cost > 0 ? x(point.cost) : frame.left, py = y(point.error);
    path += path === "" ? `M${px},${point.cost > 0 ? level : py}V${py}` : `H${px}V${py}`;
    level = py;
  }
  return path && path + `H${frame.right}`;
}

function axes(x, y, xDomain, yDomain, frame, xLabel, yLabel) {
  const middle = (frame.left + frame.right) / 2;
  return s(
      "g", {class: "axes"},
      logTicks(yDomain).map(
          (tick) =>
              [s("line", {class: "grid", x1: frame.left, x2: frame.right, y1: y(tick), y2: y(tick)}),
               s("text", {x: frame.left - 8, y: y(tick) + 4, "text-anchor": "end"}, String(tick))]),
      logTicks(xDomain).map(
          (tick) =>
              [s("line", {class: "grid", x1: x(tick), x2: x(tick), y1: frame.top, y2: frame.bottom}),
               s("text", {x: x(tick), y: frame.bottom + 17, "text-anchor": "middle"},
                 grouped(String(tick)))]),
      s("rect", {
        class: "frame",
        x: frame.left,
        y: frame.top,
        width: frame.right - frame.left,
        height: frame.bottom - frame.top
      }),
      s("text", {class: "label", x: middle, y: SCATTER.height - 6, "text-anchor": "middle"}, xLabel),
      s("text", {
        class: "label",
        "text-anchor": "middle",
        transform: `translate(13,${(frame.top + frame.bottom) / 2}) rotate(-90)`
      },
        yLabel));
}

function whisker(run, x, y) {
  const spread = lookUp(run, "cost.frame_ms.min").value, most = lookUp(run, "cost.frame_ms.max").value;
  if (!(spread > 0) || !(most > 0)) return null;
  return s("path", {
    class: "whisker",
    stroke: styleOf(run.label).colour,
    d: `M${x(spread)},${y - 4}v8m0,-4H${x(most)}m0,-4v8`
  });
}

// The front's own lines, as thin boxes that no label should cover.
function frontBoxes(front, x, y, frame) {
  return front.flatMap((point, i) => {
    const px = point.cost > 0 ? x(point.cost) : frame.left, py = y(point.error), next = front[i + 1];
    const right = next ? x(next.cost) : frame.right;
    return [
      {x: px, y: py - 1, w: right - px, h: 2},
      ...(next ? [{x: right - 1, y: py, w: 2, h: y(next.error) - py}] : [])
    ];
  });
}

function baselineMark(run, y, frame, taken) {
  const at = y(100 * relativeError(run)), text = `${run.label}: ${percent(relativeError(run))}, no pass`,
        w = textWidth(text, 11);
  const places =
      [[frame.right - 6, -5], [frame.right - 6, 14], [frame.left + 50 + w, -5], [frame.left + 50 + w, 14]];
  const box = ([right, dy]) => ({x: right - w, y: at + dy - 11, w, h: 14});
  const fits = (place) => box(place).y > frame.top && !taken.some((other) => overlap(box(place), other));
  const place = places.find(fits) || places[0];
  taken.push(box(place));
  return s(
      "g", {}, s("line", {class: "baseline", x1: frame.left, x2: frame.right, y1: at, y2: at}),
      s("text", {class: "note", x: place[0], y: at + place[1], "text-anchor": "end"}, text));
}

function thresholdMark(y, frame, taken) {
  const value = 100 * summaryState.threshold;
  if (!y.inside(value)) return null;
  taken.push(
      {x: frame.left, y: y(value) - 16, w: 40, h: 14},
      {x: frame.left, y: y(value) - 1, w: frame.right - frame.left, h: 2});
  return s(
      "g", {}, s("line", {class: "threshold", x1: frame.left, x2: frame.right, y1: y(value), y2: y(value)}),
      s("text", {class: "note", x: frame.left + 6, y: y(value) - 4}, `${Number(value.toPrecision(4))} %`));
}

// `axis`: {cost(run), label, domain, whiskers}.
function scatterChart(c, axis, yDomain) {
  const frame = {
    left: SCATTER.left,
    right: SCATTER.width - SCATTER.right,
    top: SCATTER.top,
    bottom: SCATTER.height - SCATTER.bottom
  };
  const x = logScale(axis.domain, frame.left, frame.right), y = logScale(yDomain, frame.bottom, frame.top);
  const shown = costed(c).filter((run) => isNumber(axis.cost(run)) && relativeError(run) > 0);
  const points = shown.map((run) => ({
                             run,
                             cost: isFree(run) ? 0 : axis.cost(run),
                             error: Math.max(1.12 * yDomain[0], 100 * relativeError(run))
                           }));
  const paid = points.filter((p) => p.cost > 0).map((p) => ({...p, x: x(p.cost), y: y(p.error)}));
  const front = paretoFront(points);
  const taken = paid.map((p) => ({x: p.x - 8, y: p.y - 8, w: 16, h: 16}));
  const chart =
      s("svg", {
        class: "chart",
        viewBox: `0 0 ${SCATTER.width} ${SCATTER.height}`,
        role: "img",
        "aria-label": `${axis.label} against relative RMSE, ${caseName(c)}`
      },
        axes(x, y, axis.domain, yDomain, frame, axis.label, "RMSE / RMS of truth, %"),
        thresholdMark(y, frame, taken),
        points.filter((p) => p.cost === 0).map((p) => baselineMark(p.run, y, frame, taken)),
        s("path", {class: "front", d: frontPath(front, x, y, frame)}));
  taken.push(...frontBoxes(front, x, y, frame));
  for (const p of paid) append(chart, [axis.whiskers && whisker(p.run, x, p.y), marker(p.run, p.x, p.y)]);
  append(chart, labelled(paid, front).map((p) => directLabel(p, taken, frame)));
  return chart;
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
      "div", {id: "cost-charts"},
      paretoGroups().filter((group) => group.cases.length > 1).map(paretoCard),
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
            "which do not depend on the rasteriser; same axes everywhere."
      ],
      costCharts());
}
