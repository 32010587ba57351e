// What was run: scene, views, profiles, methods and their settings, truths, machine.

function facts(rows) {
  return h(
      "dl", {class: "facts"},
      rows.filter(([, value]) => value !== null && value !== undefined && value !== "" && value !== false)
          .map(([name, value]) => h("div", {}, h("dt", {}, name), h("dd", {}, value))));
}

// Tables of the same heads sort together.
function plainTable(head, rows) {
  const table =
      h("table", {class: "plain"}, h("thead", {}, h("tr", {}, head.map((cell) => h("th", {}, cell)))),
        h("tbody", {},
          rows.map(
              (row) =>
                  h("tr", {},
                    row.map(
                        (cell, i) =>
                            h(i === 0 ? "th" : "td", {},
                              cell === null || cell === undefined ? EN_DASH : cell))))));
  return h("div", {class: "scroll"}, sortable(table, head.join("|")));
}

const card = (title, ...children) => h("div", {class: "panel card"}, h("h3", {}, title), children);

function sceneCard() {
  const scene = results.scene || {}, residual = scene.irradiance_residual || {};
  return card(
      "Scene", facts([
        ["Mesh", scene.mesh], ["Triangles", count(scene.triangles)],
        [
          "Shading triangles",
          `${count(scene.shading_triangles)}, of them skin ${count(scene.skin_triangles)}`
        ],
        ["Gives light in the truth", scene.mask_truth === "all" && "all, skin or not (mask_truth)"],
        [
          "Surface",
          isNumber(scene.area_mm2) ? `${count(scene.area_mm2 / 100)} cm\u00b2 in ${
                                         plural(scene.skin_components || 0, "skin component")}` :
                                     null
        ],
        [
          "Normal map",
          scene.normal_map ? `${scene.normal_map.file}, strength ${number(scene.normal_map.strength)}, green ${
                                 scene.normal_map.green}; skin in view has edges of ${
                                 number(scene.normal_map.edge_mm)} mm at most` :
                             null
        ],
        [
          "Albedo",
          scene.albedo ? `${scene.albedo}. ${albedoUse(scene.texturing || {exponent_before: 0})}` : null
        ],
        ["Largest irradiance", number(scene.largest_irradiance)],
        [
          "Irradiance field\u2019s residual",
          `mean ${scientific(residual.mean)}, p99 ${scientific(residual.p99)}; refined to a tolerance of ` +
              `${number(residual.tolerance)} down to ${
                  number(residual.floor_mm)} mm. Never added to an error.`
        ]
      ]));
}

// Where the albedo enters, and what the numbers are of.
function albedoUse(texturing) {
  const before = texturing.exponent_before;
  const irradiance = `Its power ${number(before)} multiplies the irradiance before the scattering, at the ` +
      `shading mesh\u2019s vertices, for the truth and the methods alike; skin in view has edges of ${
                         number(texturing.edge_mm)} mm at most.`;
  if (before === 1) return `${irradiance} Nothing of it is left for after the scattering.`;
  const after = before > 0 ? `${irradiance} Its power ${number(1 - before)}` : "It";
  return `${after} multiplies the pictures of the truth and the methods after the scattering; every number, ` +
      "map and FLIP here is without that. results.json has the errors with it, too (textured).";
}

// Millimetres per texel of every texture size that a run was given.
function texelRows(uv) {
  const sizes = unique(runs.map((run) => (run.settings || {}).texture_size).filter(isNumber));
  return sizes.map(
      (size) =>
          [`mm per texel at ${count(size)}`,
           `${number(uv.mm_per_unit_median / size)} (median), ` +
               `${number(uv.mm_per_unit_p05 / size)} to ${number(uv.mm_per_unit_p95 / size)} (p05 to p95)`]);
}

function uvCard() {
  const uv = (results.scene || {}).uv;
  if (!uv)
    return card(
        "UV coordinates",
        h("p", {class: "muted"}, "The mesh has none; methods in texture space cannot run."));
  const defects = ["flipped", "zero_area", "overlapping", "outside_unit_square"].map(
      (name) => [name.replace(/_/g, " "), uv[name]]);
  const found = defects.filter(([, n]) => n > 0);
  return card("UV coordinates", facts([
                [
                  "Defects",
                  found.length ? found.map(([name, n]) => `${count(n)} ${name}`).join(", ") + " triangles" :
                                 "none (flipped, without area, overlapping, outside the unit square)"
                ],
                [
                  "mm per UV unit",
                  `${number(uv.mm_per_unit_median)} (median), ${number(uv.mm_per_unit_p05)} to ${
                      number(uv.mm_per_unit_p95)} (p05 to p95)`
                ],
                ...texelRows(uv), ["Stretch anisotropy", `${number(uv.anisotropy_p95)} (p95)`]
              ]));
}

function profileText(profile) {
  const triple = (values) => list(values).map((v) => number(v)).join(" / ");
  return facts([
    ["Widest s", isNumber(profile.widest_std_dev_mm) ? `${number(profile.widest_std_dev_mm)} mm` : null],
    ["r_max", isNumber(profile.r_max_mm) ? `${number(profile.r_max_mm)} mm, for methods that cut` : "none"],
    ["Unscattered (RGB)", triple(profile.delta_weight)], ["Sum of weights", triple(profile.total_weight)],
    ["Source", profile.source]
  ]);
}

function gaussianTable(profile) {
  const triple = (values) => list(values).map((v) => number(v)).join(" / ");
  return plainTable(
      ["Gaussian", "variance, mm\u00b2", "weight (R / G / B)"],
      list(profile.gaussians)
          .map(
              (g, i) =>
                  [String(i + 1),
                   unique(list(g.variance_mm2)).length === 1 ? number(g.variance_mm2[0]) :
                                                               triple(g.variance_mm2),
                   triple(g.weight)]));
}

function settingsText(settings) {
  const entries = Object.entries(settings || {});
  return entries.length ?
      entries.map(([key, value]) => `${key} = ${isNumber(value) ? Number(value.toPrecision(6)) : value}`)
          .join(", ") :
      "none";
}

function methodsCard() {
  return card(
      "Methods",
      plainTable(["Label", "What it is", "Settings", "Own target", "Source"], labels.map((label) => {
        const own = runs.filter((run) => run.label === label), run = own[0];
        return [
          methodName(label), run.title || run.method, settingsText(run.settings),
          listed(unique(own.filter((r) => r.own_target).map((r) => targetName(r.own_target)))), run.source
        ];
      })));
}

function viewsCard() {
  return card(
      "Views",
      plainTable(
          ["View", "size, px", "skin, px", "median depth, mm", "mm per px there"],
          views.map(
              (view) =>
                  [view.name, `${view.width_px} ${TIMES} ${view.height_px}`, count(view.skin_pixels),
                   number(view.median_skin_depth_mm), number(view.mm_per_px)])));
}

function truthsCard() {
  return card(
      "Truths and their certificates",
      h("p", {class: "muted"},
        "Differences in units of the largest irradiance. Open share: with 95 % confidence, at most " +
            "this share of the points is worse than the largest difference found."),
      plainTable(
          [
            "View", "Profile", "Target", "for", "points", "audited", "largest difference", "allowed", "tail bound",
            "uncertainty", "open share", "mass < 0.5", "seconds"
          ],
          truths.map((t) => {
            const c = t.certificate || {};
            return [
              t.view, profileTitle(t.profile), targetName(t) +
                  (t.visibility_bound ? `; what is visible is known to ${scientific(t.visibility_bound.rms)} (RMS), ${
                                            scientific(t.visibility_bound.max)} (largest)` :
                                        ""),
              roleOf(t), count(t.points),
              h("span", {title: auditedWhere([t])}, count(c.audited)),
              scientific(c.max_error), scientific(c.tolerance), scientific(c.tail_bound),
              scientific(t.uncertainty), percent(c.open_share_95),
              isNumber(t.low_mass_pixels) ? count(t.low_mass_pixels) : EN_DASH,
              number(t.seconds) + (t.cached ? " (cached)" : "")
            ];
          })));
}

// How the methods fare against the truths that were asked for beside the headline; nothing where none was.
function extraTargetsCard() {
  const rows = cases.flatMap(
      (c) => [...c.runs].sort(byError).flatMap((run) => list(run.extra_targets).map((extra) => {
        const found = lookUp(extra, "metrics.rel_rmse");
        const shown = found.value === null ? extra.metrics_reason || found.reason :
            extra.distinguishable === false ? "not distinguishable" :
                                              percent(found.value);
        return [caseName(c), methodName(run.label), targetName(extra), shown, errorText(run)];
      })));
  return rows.length > 0 &&
      card(
          "Against other truths",
          h("p", {class: "muted"},
            "RMSE of luminance relative to the RMS of each truth. What differs between the columns is what " +
                "the truths mean by distance, not what the method does."),
          plainTable(["Case", "Method", "Truth", "rel. RMSE", "against the headline"], rows));
}

// What a truth is there for.
function roleOf(truth) {
  const own = list(truth.own_target_of);
  return [
    truth.of && "the profile itself: " + truth.of.title, truth.headline && "headline",
    own.length > 0 && "own target of " + own.join(", "), truth.extra && "asked for"
  ].filter(Boolean)
      .join("; ");
}

function machineCard() {
  const machine = provenance.machine || {};
  return card(
      "Provenance", facts([
        [
          "Program",
          `truescatter ${provenance.version || EN_DASH}, commit ${provenance.commit || EN_DASH}${
              provenance.commit_dirty ? ", with local changes" : ""}`
        ],
        [
          "Build",
          [provenance.build_type, provenance.compiler, provenance.instruction_set].filter(Boolean).join(", ")
        ],
        [
          "Renderer",
          [
            provenance.gl_renderer, provenance.gl_version && "OpenGL " + provenance.gl_version,
            {osmesa: "by OSMesa", egl: "by EGL"}[provenance.gl_context], isSoftware ? "software" : "GPU"
          ]
              .filter(Boolean)
              .join("; ")
        ],
        [
          "Rasteriser threads",
          isNumber(provenance.rasteriser_threads) ? String(provenance.rasteriser_threads) : null
        ],
        [
          "Machine",
          [machine.processor, isNumber(machine.cores) && plural(machine.cores, "core"), machine.system]
              .filter(Boolean)
              .join("; ")
        ],
        ["Jobs", isNumber(machine.jobs) ? String(machine.jobs) : null],
        ["Finished", (provenance.finished_utc || "").replace("T", " ").replace("Z", " UTC")]
      ]));
}

function questionCard() {
  const experiment = results.experiment || {};
  return card("Question", facts([
                ["Question", experiment.question], ["Expected", experiment.expectation],
                ["Sources", experiment.source]
              ]));
}

function detailsSection() {
  const file = (name) => h("a", {href: name}, name);
  return section(
      "what", "What was run",
      [
        "Everything on this page comes from ", file("results.json"), " and the pictures in maps/; ",
        file("results.csv"), " has the tables, ", file("experiment.resolved.toml"), " repeats the run."
      ],
      h("div", {class: "cards"}, questionCard(), machineCard(), sceneCard(), uvCard(),
        profiles.map(
            (profile) => card(profile.title || profile.name, profileText(profile), gaussianTable(profile)))),
      viewsCard(), methodsCard(), extraTargetsCard(), truthsCard());
}
