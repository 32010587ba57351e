#include "report/advice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "core/error.h"
#include "report/results_file.h"

namespace truescatter {
namespace {

using nlohmann::json;

constexpr double kShareOfError = 0.25;

struct Measured {
  double error = 0.0;
  double ms = 0.0;
  double min_ms = 0.0;
  double max_ms = 0.0;
  double fetches = 0.0;
  double bytes = 0.0;
  int passes = 0;
};

struct Setting {
  std::string name;
  json about;  // label, profile?, frame?, settings
  std::map<std::string, Measured> cases;
  std::string missing;  // why it is not measured in one of them
};

const json& by_name(const json& list, const json& name) {
  const auto found =
      std::find_if(list.begin(), list.end(), [&](const json& e) { return e.at("name") == name; });
  if (found == list.end()) throw_input_error({}, "results.json: {} is not there", name.dump());
  return *found;
}

double number_at(const json& object, const char* pointer) {
  const json::json_pointer p(pointer);
  return object.contains(p) && object.at(p).is_number() ? object.at(p).get<double>() : std::nan("");
}

// How views and profiles of a result make cases, and what of them is a setting.
class Cases {
 public:
  explicit Cases(const json& results) : results_(results) {
    for (const json& view : results.at("views")) {
      sizes_[camera_of(view)].insert(frame_of(view));
      std::string& names = names_[camera_of(view)];
      names += (names.empty() ? "" : "/") + view.at("name").get<std::string>();
      double& most = most_pixels_[camera_of(view)];
      most = std::max(most, view.value("skin_pixels", 0.0));
    }
    for (const json& profile : results.at("profiles")) sums_[model_of(profile)].insert(profile.at("name"));
  }

  std::string case_of(const json& run) const {
    const json& view = view_of(run);
    return camera_of(view) + " " + model_of(profile_of(run));
  }
  // For people.
  std::string case_name(const json& run) const {
    const json& profile = profile_of(run);
    const bool varies = sums_.at(model_of(profile)).size() > 1;
    return fmt::format("view {}, {}", names_.at(camera_of(view_of(run))),
                       varies ? model_of(profile) : profile.at("name").get<std::string>());
  }
  json setting_of(const json& run) const {
    json about = {{"label", run.at("label")}, {"settings", run.value("settings", json::object())}};
    const json& view = view_of(run);
    const json& profile = profile_of(run);
    if (sums_.at(model_of(profile)).size() > 1) about["profile"] = profile.at("name");
    if (sizes_.at(camera_of(view)).size() > 1) about["frame"] = frame_of(view);
    return about;
  }
  // The view's share of the skin's pixels at its camera's largest size.
  double share_of(const json& run) const {
    const json& view = view_of(run);
    const double most = most_pixels_.at(camera_of(view));
    return most > 0.0 ? view.value("skin_pixels", 0.0) / most : 1.0;
  }

 private:
  const json& view_of(const json& run) const { return by_name(results_.at("views"), run.at("view")); }
  const json& profile_of(const json& run) const {
    return by_name(results_.at("profiles"), run.at("profile"));
  }
  static std::string camera_of(const json& view) {
    return view.contains("camera") ? view.at("camera").dump() : view.at("name").get<std::string>();
  }
  static std::string frame_of(const json& view) {
    return fmt::format("{}x{}", view.value("width_px", 0), view.value("height_px", 0));
  }
  static std::string model_of(const json& profile) {
    const json::json_pointer title("/of/title");
    return profile.contains(title) ? profile.at(title).get<std::string>()
                                   : profile.at("name").get<std::string>();
  }

  const json& results_;
  std::map<std::string, std::set<std::string>> sizes_;
  std::map<std::string, std::string> names_;  // of a camera's views
  std::map<std::string, double> most_pixels_;
  std::map<std::string, std::set<json>> sums_;
};

// NaN where it was not measured.
double error_of(const json& run, const std::string& metric) {
  if (metric == "halo-peak") return std::abs(number_at(run, "/metrics/halo/peak"));
  const bool itself = run.contains("profile_error") && run.at("profile_error").is_object();
  const json& metrics = itself ? run.at("profile_error").at("metrics") : run.at("metrics");
  const double relative = number_at(metrics, "/rel_rmse");
  if (metric == "rmse") return relative;
  const double rmse = number_at(metrics, "/rmse");
  return rmse > 0.0 ? number_at(metrics, "/p99") * relative / rmse : relative;
}

// Why a run cannot be weighed; empty: it can.
std::string obstacle_of(const json& run, const AdviceRequest& request) {
  if (run.contains("skipped")) return run.at("skipped").get<std::string>();
  if (!run.contains("metrics") || !run.at("metrics").is_object()) return "it has no metrics";
  if (std::isnan(error_of(run, request.metric)))
    return fmt::format("view {} has no {}", run.at("view").get<std::string>(), request.metric);
  if (std::isnan(number_at(run, "/cost/frame_ms/median"))) return "its cost is not known";
  if (!request.by_fetches && is_time_shared(run))
    return "its time was taken while other work ran on the machine (a budget in fetches does without times)";
  if (request.by_fetches && std::isnan(number_at(run, "/cost/fetches_per_pixel")))
    return "its fetches are not known";
  return "";
}

Measured measured_of(const json& run, double share, const std::string& metric) {
  Measured m;
  m.error = error_of(run, metric);
  m.passes = static_cast<int>(number_at(run, "/cost/passes"));
  if (m.passes == 0) return m;  // the G-buffer's light as it is: what its frames took is the clock's
  m.ms = number_at(run, "/cost/frame_ms/median");
  m.min_ms = number_at(run, "/cost/frame_ms/min");
  m.max_ms = number_at(run, "/cost/frame_ms/max");
  m.fetches = share * number_at(run, "/cost/fetches_per_pixel");
  m.bytes = share * number_at(run, "/cost/bytes_per_pixel");
  return m;
}

std::string name_of_setting(const json& about) {
  std::string name = about.at("label").get<std::string>();
  for (const char* key : {"profile", "frame"}) {
    if (about.contains(key)) name += fmt::format(", {}", about.at(key).get<std::string>());
  }
  return name;
}

json entry_of(const Setting& setting, const std::map<std::string, std::string>& case_names) {
  json entry = setting.about;
  Measured worst;
  std::string where;
  for (const auto& [key, m] : setting.cases) {
    if (where.empty() || m.error > worst.error) {
      worst.error = m.error;
      where = case_names.at(key);
    }
    if (m.ms >= worst.ms) std::tie(worst.ms, worst.min_ms, worst.max_ms) = std::tie(m.ms, m.min_ms, m.max_ms);
    worst.fetches = std::max(worst.fetches, m.fetches);
    worst.bytes = std::max(worst.bytes, m.bytes);
    worst.passes = std::max(worst.passes, m.passes);
  }
  entry["name"] = setting.name;
  entry["error"] = worst.error;
  entry["worst_case"] = where;
  entry["ms"] = {{"median", worst.ms}, {"min", worst.min_ms}, {"max", worst.max_ms}};
  // JSON knows no NaN: a driver may not tell.
  entry["fetches"] = std::isnan(worst.fetches) ? json() : json(worst.fetches);
  entry["bytes"] = std::isnan(worst.bytes) ? json() : json(worst.bytes);
  entry["passes"] = worst.passes;
  return entry;
}

// Settings by what they cost, each marked where none that costs less errs less.
class Ranking {
 public:
  Ranking(std::vector<json> settings, const AdviceRequest& request)
      : settings_(std::move(settings)), request_(request) {
    std::stable_sort(settings_.begin(), settings_.end(), [&](const json& a, const json& b) {
      return std::pair(cost(a), error(a)) < std::pair(cost(b), error(b));
    });
    double least = std::numeric_limits<double>::infinity();
    for (json& setting : settings_) {
      setting["front"] = error(setting) < least;
      least = std::min(least, error(setting));
    }
  }

  double cost(const json& setting) const {
    return request_.by_fetches ? setting.at("fetches").get<double>()
                               : setting.at("ms").at("median").get<double>();
  }
  static double error(const json& setting) { return setting.at("error").get<double>(); }
  const std::vector<json>& all() const { return settings_; }

  bool within(const json& setting) const { return !request_.budget || cost(setting) <= *request_.budget; }
  // The first of the cheapest that meets the error; null if none does.
  json cheapest() const {
    for (const json& setting : settings_) {
      if (error(setting) <= request_.error) return setting;
    }
    return nullptr;
  }
  // The cheapest of the most accurate that `keep` keeps; null if there is none.
  template <typename Keep>
  json most_accurate(const Keep& keep) const {
    json best;
    for (const json& setting : settings_) {
      if (keep(setting) && (best.is_null() || error(setting) < error(best))) best = setting;
    }
    return best;
  }

 private:
  std::vector<json> settings_;
  AdviceRequest request_;
};

std::vector<Setting> settings_of(const json& results, const AdviceRequest& request,
                                 std::map<std::string, std::string>& case_names) {
  const Cases cases(results);
  std::vector<Setting> settings;
  for (const json& run : results.at("runs")) {
    const json about = cases.setting_of(run);
    const std::string name = name_of_setting(about);
    auto found =
        std::find_if(settings.begin(), settings.end(), [&](const Setting& s) { return s.name == name; });
    if (found == settings.end()) found = settings.insert(settings.end(), {name, about, {}, ""});
    const std::string key = cases.case_of(run);
    case_names.emplace(key, cases.case_name(run));
    const std::string obstacle = obstacle_of(run, request);
    if (!obstacle.empty()) {
      found->missing = obstacle;
    } else {
      found->cases[key] = measured_of(run, cases.share_of(run), request.metric);
    }
  }
  for (Setting& setting : settings) {
    if (setting.missing.empty() && setting.cases.size() < case_names.size())
      setting.missing = "it was not run in every case";
  }
  return settings;
}

// --- parts of the model ---

struct Worst {
  double difference = -1.0;
  std::string where;
  std::string reason;  // where nothing was measured
};

Worst worst_of(const json& needs, const char* part) {
  Worst worst;
  for (const json& entry : needs) {
    const json& measured = entry.at(part);
    if (!measured.at("difference").is_number()) {
      if (worst.reason.empty())
        worst.reason = measured.value("reason", measured.value("difference_reason", "not measured"));
      continue;
    }
    const double difference = measured.at("difference").get<double>();
    if (difference > worst.difference) {
      worst.difference = difference;
      worst.where = fmt::format("view {}, {}", entry.at("view").get<std::string>(),
                                entry.at("profile").get<std::string>());
    }
  }
  return worst;
}

std::string percent(double share) { return fmt::format("{:.3g} %", 100.0 * share); }

struct PartText {
  const char* part;
  const char* needed;
  const char* not_needed;
  const char* what;  // the difference
};

constexpr PartText kParts[] = {
    {"layers", "more than one layer of visible surface", "one layer is enough",
     "a second depth-peeled layer changes cbf-unnormalised by"},
    {"shadows", "shadows", "no shadows", "leaving shadows out changes the irradiance by"},
    {"geodesics", "to choose between straight distances and those along the surface", "no geodesics",
     "the geodesic truth differs from the Euclidean one by"},
    {"transmittance", "transmittance", "no transmittance", "light through the body is"},
};

json part_advice(const PartText& text, const json& needs, double limit) {
  const Worst worst = worst_of(needs, text.part);
  json part = {{"part", text.part}, {"limit", limit}};
  if (worst.difference < 0.0) {
    part["needed"] = nullptr;
    part["difference"] = nullptr;
    part["sentence"] = fmt::format("{}: not measured: {}", text.part, worst.reason);
    return part;
  }
  const bool needed = worst.difference > limit;
  part["needed"] = needed;
  part["difference"] = worst.difference;
  part["worst"] = worst.where;
  part["sentence"] = fmt::format(
      "{}: {} {} of the RMS at most ({}; limit {})",
      needed ? std::string("needed: ") + text.needed : std::string("not needed: ") + text.not_needed,
      text.what, percent(worst.difference), worst.where, percent(limit));
  return part;
}

// How many of the narrowest Gaussians of one profile in one view can stay unblurred.
json gaussians_advice(const json& needs, double limit) {
  json views = json::array();
  std::string sentence;
  bool all_needed = true;
  for (const json& entry : needs) {
    const json& gaussians = entry.at("gaussians");
    std::size_t unblurred = 0;
    std::size_t below = 0;
    double cost = 0.0;
    double below_cost = 0.0;
    for (const json& gaussian : gaussians) {
      const json& difference = gaussian.at("difference");
      if (gaussian.at("below_pixel").get<bool>()) {
        ++below;
        if (difference.is_number()) below_cost = difference.get<double>();
      }
      if (difference.is_number() && difference.get<double>() <= limit) {
        ++unblurred;
        cost = difference.get<double>();
      }
    }
    if (unblurred > 0) all_needed = false;
    views.push_back({{"view", entry.at("view")},
                     {"profile", entry.at("profile")},
                     {"gaussians", gaussians.size()},
                     {"below_pixel", below},
                     {"below_pixel_difference", below_cost},
                     {"unblurred", unblurred},
                     {"difference", cost}});
    sentence += fmt::format(
        "{}view {}, {}: {} of {} below half a pixel{}; the narrowest {} can stay unblurred ({})",
        sentence.empty() ? "" : "; ", entry.at("view").get<std::string>(),
        entry.at("profile").get<std::string>(), below, gaussians.size(),
        below > 0 ? fmt::format(" ({} without them)", percent(below_cost)) : "", unblurred, percent(cost));
  }
  return {{"part", "gaussians"},
          {"limit", limit},
          {"needed", all_needed},
          {"views", views},
          {"sentence", fmt::format("Gaussians, left unblurred from the narrowest on (limit {}): {}",
                                   percent(limit), sentence)}};
}

// --- for people ---

std::string setting_text(const json& setting) {
  const json& ms = setting.at("ms");
  const std::string fetches =
      setting.at("fetches").is_number()
          ? fmt::format(", {:.4g} fetches and {:.4g} bytes per skin pixel",
                        setting.at("fetches").get<double>(), setting.at("bytes").get<double>())
          : "";
  return fmt::format("{}: error {} ({}), {}{}", setting.at("name").get<std::string>(),
                     percent(setting.at("error").get<double>()), setting.at("worst_case").get<std::string>(),
                     setting.at("passes") == 0
                         ? std::string("no pass")
                         : fmt::format("{:.4g} ms ({:.4g}..{:.4g})", ms.at("median").get<double>(),
                                       ms.at("min").get<double>(), ms.at("max").get<double>()),
                     setting.at("passes") == 0 ? "" : fetches);
}

const char* metric_text(const std::string& metric) {
  if (metric == "rmse") return "RMSE / RMS of the truth";
  if (metric == "p99") return "99 % quantile of |error| / RMS of the truth";
  return "largest relative error of a bin beside a silhouette";
}

std::string verdict_text(const json& advice) {
  const double limit = advice.at("error").get<double>();
  const std::string unit = advice.at("cost").get<std::string>();
  const json& chosen = advice.at("chosen");
  if (chosen.is_null()) return advice.at("chosen_reason").get<std::string>() + "\n";
  std::string text;
  if (advice.at("budget").is_number()) {
    text = fmt::format("most accurate within {:.4g} {}:\n  {}\n", advice.at("budget").get<double>(), unit,
                       setting_text(chosen));
    if (!advice.at("meets").get<bool>()) text += fmt::format("it does not meet {}\n", percent(limit));
  } else if (advice.at("meets").get<bool>()) {
    text = fmt::format("cheapest within {} by {}:\n  {}\n", percent(limit), unit, setting_text(chosen));
  } else {
    text =
        fmt::format("no setting meets {}; the most accurate:\n  {}\n", percent(limit), setting_text(chosen));
  }
  const json& cheaper = advice.at("next_cheaper");
  text += cheaper.is_null()
              ? "nothing is cheaper\n"
              : fmt::format("the most accurate of what is cheaper:\n  {}\n", setting_text(cheaper));
  if (!advice.at("next_better").is_null())
    text += fmt::format("the cheapest that meets {}:\n  {}\n", percent(limit),
                        setting_text(advice.at("next_better")));
  return text;
}

}  // namespace

json advice(const json& results, const AdviceRequest& request) {
  std::map<std::string, std::string> case_names;
  std::vector<json> entries;
  json left_out = json::array();
  for (const Setting& setting : settings_of(results, request, case_names)) {
    if (setting.missing.empty()) {
      entries.push_back(entry_of(setting, case_names));
    } else {
      left_out.push_back({{"name", setting.name}, {"reason", setting.missing}});
    }
  }
  if (entries.empty()) {
    throw_input_error({}, "no setting has {} and a cost in every case{}", request.metric,
                      left_out.empty() ? "" : ": " + left_out.front().at("reason").get<std::string>());
  }
  const Ranking ranking(std::move(entries), request);
  json chosen = request.budget ? ranking.most_accurate([&](const json& s) { return ranking.within(s); })
                               : ranking.cheapest();
  if (chosen.is_null() && !request.budget) chosen = ranking.most_accurate([](const json&) { return true; });
  json advice = {{"schema", "truescatter-advice-1"},
                 {"metric", request.metric},
                 {"error", request.error},
                 {"cost", request.by_fetches ? "fetches" : "ms"},
                 {"budget", request.budget ? json(*request.budget) : json()},
                 {"settings", ranking.all()},
                 {"left_out", left_out},
                 {"meets", !chosen.is_null() && Ranking::error(chosen) <= request.error},
                 {"chosen", chosen},
                 {"next_cheaper", nullptr},
                 {"next_better", nullptr}};
  if (chosen.is_null()) {
    advice["chosen_reason"] =
        fmt::format("nothing costs {} {} or less", *request.budget, request.by_fetches ? "fetches" : "ms");
  } else {
    advice["next_cheaper"] =
        ranking.most_accurate([&](const json& s) { return ranking.cost(s) < ranking.cost(chosen); });
  }
  if (request.budget && !advice.at("meets").get<bool>()) advice["next_better"] = ranking.cheapest();
  return advice;
}

json model_advice(const json& needs, double error) {
  const double limit = kShareOfError * error;
  json parts = json::array();
  for (const PartText& text : kParts) parts.push_back(part_advice(text, needs, limit));
  parts.push_back(gaussians_advice(needs, limit));
  return parts;
}

std::string advice_text(const json& advice) {
  std::string text =
      fmt::format("{} settings; error: {}; luminance, largest over the cases\n", advice.at("settings").size(),
                  metric_text(advice.at("metric").get<std::string>()));
  text += verdict_text(advice);
  for (const json& left : advice.at("left_out"))
    text += fmt::format("left out: {}: {}\n", left.at("name").get<std::string>(),
                        left.at("reason").get<std::string>());
  if (!advice.contains("model")) return text;
  const json& model = advice.at("model");
  text +=
      "\nwhat the scene needs (a part is left out where that changes the truth by less than a quarter of the "
      "error)\n";
  if (model.at("parts").is_null())
    return text + "  not measured: " + model.at("reason").get<std::string>() + "\n";
  for (const json& part : model.at("parts")) text += "  " + part.at("sentence").get<std::string>() + "\n";
  return text;
}

}  // namespace truescatter
