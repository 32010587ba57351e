// Where a profile says what it approximates: the error of its Gaussians and that of a method's convolution
// with them, apart and together.

const fitErrors = list(results.fit_errors);

function fitCell(measured, channel, metric) {
  const found = lookUp(channelOf((measured || {}).metrics, channel), metric);
  const text = number(inErrorUnits(found.value), metric === "bias");
  if (found.value === null) return h("span", {title: found.reason}, text);
  return (measured || {}).distinguishable === false ?
      h("span", {class: "doubt", title: "RMSE at or below the truths\u2019 uncertainty"}, text) :
      text;
}

function fitRows(c, fit, channel) {
  const cells = (run, metric) => [fit, run.profile_error.convolution, run.profile_error].map(
      (part) => fitCell(part, channel, metric));
  return [...c.runs]
      .filter((run) => run.profile_error)
      .sort(byError)
      .map((run) => [methodName(run.label), ...cells(run, "bias"), ...cells(run, "rmse")]);
}

// What the fit error is of, and how well the profile's own truth is known.
function fitLead(c, fit) {
  const truth = truths.find((t) => t.id === fit.truth) || {};
  const of = truth.of || {}, check = truth.radial_check || {};
  const triple = (values) => unique(list(values).map((v) => number(v))).join(" / ");
  const signed = (fit.files || {}).signed;
  return h(
      "p", {class: "muted"}, h("b", {}, `Against the ${of.title || "profile itself"}. `),
      "Fit error: its Gaussians\u2019 truth less its own; convolution error: the method less its ",
      "Gaussians\u2019 truth. Bias adds up at every pixel and in the mean, RMSE does not. Both truths are ",
      "normalised to send back their own albedo of even light: ", triple(of.albedo), " the profile, ",
      triple(profileOf(c.profile).total_weight), " its Gaussians. The profile\u2019s truth is uncertain by ",
      scientific(truth.uncertainty), " of the largest irradiance; at ", plural(check.points || 0, "pixel"),
      " it differs by ", scientific(check.max_difference), " at most from its exact integral (allowed: ",
      scientific(check.allowed), "). ", signed && h("a", {href: linkTo(signed)}, "Map of the fit error"));
}

function fitTable(c, channel) {
  const fit = fitErrors.find((entry) => entry.view === c.view && entry.profile === c.profile);
  if (!fit) return null;
  const unit = errorUnit ? `, ${errorUnit}` : "";
  const head = ["bias", "RMSE"].flatMap(
      (metric) => ["fit error", "convolution error", "together"].map((part) => `${part}, ${metric}${unit}`));
  return h(
      "div", {class: "panel card"}, h("h3", {}, "Fit error and convolution error"), fitLead(c, fit),
      plainTable(["Method", ...head], fitRows(c, fit, channel)));
}
