#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace truescatter {

// What a setting must reach, and may cost.
struct AdviceRequest {
  double error = 0.02;          // largest, as a share
  std::string metric = "rmse";  // rmse | p99 | halo-peak
  std::optional<double> budget;
  bool by_fetches = false;  // cost is fetches, and so is the budget; else ms
};

// The cheapest setting of a result that meets an error, or the most accurate one within a budget.
//
// A setting is a method's label; where several profiles stand for one diffusion profile, the label and that
// choice, and where several views of one camera differ in size, this too. A case is a camera and what is
// approximated; a setting's error is its largest over the cases, and so is its cost. Errors, of luminance:
//
//   rmse       RMSE / RMS of the truth
//   p99        99 % quantile of |error| / RMS of the truth
//   halo-peak  largest magnitude of the relative error in a bin beside a silhouette (halo.peak)
//
// against the headline truth; the first two against the truth of the diffusion profile itself where a profile
// approximates one. Cost is the median frame time in ms; fetches are those of the frame over the skin pixels
// of its camera's largest view.
//
//   schema, metric, error, cost ("ms" | "fetches"), budget
//   settings[]    all that were measured in every case, by cost: {name, label, profile?, frame?, settings,
//                 error, worst_case, ms: {median, min, max}, fetches, bytes, passes, front}
//   left_out[]    {name, reason}
//   meets         whether `chosen` is within the error asked for, and the budget
//   chosen        an entry of settings; without a budget the cheapest that meets the error, or else the most
//                 accurate; with one the most accurate within it. Null with chosen_reason if there is none.
//   next_cheaper  of all that cost less than the chosen, the most accurate; null if none does
//   next_better   where `meets` is false and a budget is given: the cheapest that meets the error; or null
// Throws Error (input) where the result has no run with an error.
nlohmann::json advice(const nlohmann::json& results, const AdviceRequest& request);

// Of what `scene_needs` measured: parts[] of {part, needed, difference, limit, worst (view, profile),
// sentence}, `needed` null where it was not measured. A part is needed where leaving it out changes the truth
// by more than a quarter of the error asked for: errors that add up as squares grow by a thirty-second part
// then. `gaussians` has `unblurred`: how many of the narrowest can go in every view, and how many are below a
// pixel.
nlohmann::json model_advice(const nlohmann::json& needs, double error);

// For people: of `advice`, with `model` (the parts above) in it.
std::string advice_text(const nlohmann::json& advice);

}  // namespace truescatter
