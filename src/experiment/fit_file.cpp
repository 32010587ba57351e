#include "experiment/fit_file.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "core/error.h"
#include "core/file.h"

namespace truescatter {
namespace {

using nlohmann::json;

SourceLocation place_in(const std::string& file, const std::string& text, std::size_t byte) {
  const std::string_view before = std::string_view(text).substr(0, byte > 0 ? byte - 1 : 0);
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const std::size_t line_start = before.rfind('\n') == std::string_view::npos ? 0 : before.rfind('\n') + 1;
  return {file, static_cast<int>(line), static_cast<int>(before.size() - line_start) + 1};
}

// Without the library's preamble, which says where in its own way.
std::string complaint(const json::exception& error) {
  const std::string text = error.what();
  const std::size_t at = text.find("] ");
  return at == std::string::npos ? text : text.substr(at + 2);
}

json parse(const std::string& file, const std::string& text) {
  try {
    return json::parse(text);
  } catch (const json::parse_error& error) {
    throw_input_error(place_in(file, text, error.byte), "this is no JSON: {}", complaint(error));
  } catch (const json::exception& error) {
    throw_input_error({file}, "this is no JSON that can be read: {}", complaint(error));
  }
}

const json& array_at(const json& object, const std::string& file, const char* key) {
  if (!object.is_object()) throw_input_error({file}, "an object with the key \"{}\" is needed", key);
  if (!object.contains(key)) throw_input_error({file}, "the key \"{}\" is missing", key);
  const json& value = object[key];
  if (!value.is_array() || value.empty())
    throw_input_error({file}, "{} is {}: an array of one or more is needed", key, value.dump());
  return value;
}

double number(const json& value, const std::string& file, const std::string& key) {
  if (!value.is_number() || !std::isfinite(value.get<double>()))
    throw_input_error({file}, "{} is {}: a finite number is needed", key, value.dump());
  return value.get<double>();
}

}  // namespace

std::vector<GaussianLevel> read_fit(const std::filesystem::path& path) {
  const std::string file = path.string();
  const json fit = parse(file, read_text_file(path));
  const json& variances = array_at(fit, file, "variances");
  const json& weights = array_at(fit, file, "weights");
  if (weights.size() != variances.size()) {
    throw_input_error({file}, "weights has {} rows and variances {}: one row for each variance is needed",
                      weights.size(), variances.size());
  }
  std::vector<GaussianLevel> levels;
  for (std::size_t i = 0; i < variances.size(); ++i) {
    const std::string key = fmt::format("variances[{}]", i);
    GaussianLevel level{number(variances[i], file, key), Vec3d::Zero()};
    if (level.variance_mm2 <= 0.0)
      throw_input_error({file}, "{} is {}: a variance in mm^2 must be above 0", key, level.variance_mm2);
    if (i > 0 && level.variance_mm2 <= levels.back().variance_mm2) {
      throw_input_error({file}, "{} is {}, after {}: variances must ascend", key, level.variance_mm2,
                        levels.back().variance_mm2);
    }
    const json& row = weights[i];
    if (!row.is_array() || row.size() != 3)
      throw_input_error({file}, "weights[{}] is {}: three weights [r, g, b] are needed", i, row.dump());
    for (std::size_t c = 0; c < 3; ++c) {
      level.weight[static_cast<Eigen::Index>(c)] = number(row[c], file, fmt::format("weights[{}][{}]", i, c));
    }
    levels.push_back(level);
  }
  return levels;
}

}  // namespace truescatter
