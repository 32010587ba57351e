#include "report/fit_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/error.h"

namespace truescatter {
namespace {

using nlohmann::json;

constexpr double kWidth_px = 760.0;
constexpr double kHeight_px = 700.0;
constexpr double kLeft_px = 74.0;
constexpr double kRight_px = 740.0;
constexpr double kMostDecades = 8.0;
constexpr std::array<const char*, 3> kColors = {"#c8352b", "#2b8a3e", "#2563c9"};
constexpr std::array<const char*, 3> kChannels = {"red", "green", "blue"};

struct Curve {
  std::vector<double> r_mm;
  std::array<std::vector<double>, 3> profile;
  std::array<std::vector<double>, 3> fit;
};

Curve read_curve(const json& document) {
  Curve curve;
  const json& from = document.at("curve");
  curve.r_mm = from.at("r_mm").get<std::vector<double>>();
  for (std::size_t i = 0; i < curve.r_mm.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      curve.profile[c].push_back(from.at("profile").at(i).at(c).get<double>());
      curve.fit[c].push_back(from.at("fit").at(i).at(c).get<double>());
    }
  }
  return curve;
}

// Decades from `low` to `high` along a stretch of pixels.
struct LogAxis {
  double low;
  double high;
  double low_px;
  double high_px;

  double px(double value) const {
    return low_px + (std::log10(value) - low) / (high - low) * (high_px - low_px);
  }
  bool holds(double value) const { return value > 0.0 && std::log10(value) >= low; }
};

LogAxis axis_of(const std::vector<double>& values, double most_decades, double low_px, double high_px) {
  double least = 0.0;
  double largest = 0.0;
  for (const double value : values) {
    if (!(value > 0.0)) continue;
    largest = std::max(largest, value);
    least = least == 0.0 ? value : std::min(least, value);
  }
  if (largest == 0.0) return {-1.0, 0.0, low_px, high_px};
  const double high = std::ceil(std::log10(largest) + 1e-9);
  const double low = std::max(std::floor(std::log10(least)), high - most_decades);
  return {std::min(low, high - 1.0), high, low_px, high_px};
}

std::string power_of_ten(double decade) {
  return fmt::format("10<tspan dy=\"-5\" font-size=\"9\">{}</tspan>", static_cast<int>(decade));
}

std::string frame(const LogAxis& x, const LogAxis& y, const std::string& y_title) {
  std::string svg;
  for (double d = std::ceil(x.low); d <= x.high + 1e-9; d += 1.0) {
    const double at = x.px(std::pow(10.0, d));
    svg += fmt::format("<path class=\"grid\" d=\"M{:.1f} {:.1f}V{:.1f}\"/>", at, y.low_px, y.high_px);
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>\n", at,
                       y.low_px + 18.0, power_of_ten(d));
  }
  for (double d = std::ceil(y.low); d <= y.high + 1e-9; d += 1.0) {
    const double at = y.px(std::pow(10.0, d));
    svg += fmt::format("<path class=\"grid\" d=\"M{:.1f} {:.1f}H{:.1f}\"/>", x.low_px, at, x.high_px);
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>\n", x.low_px - 8.0,
                       at + 4.0, power_of_ten(d));
  }
  const double middle = 0.5 * (y.low_px + y.high_px);
  svg +=
      fmt::format("<text transform=\"translate(18 {:.1f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                  middle, y_title);
  svg += fmt::format("<rect class=\"frame\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\"/>\n",
                     x.low_px, y.high_px, x.high_px - x.low_px, y.low_px - y.high_px);
  return svg;
}

// Where a value is not on the axis the line is broken.
std::string path(const LogAxis& x, const LogAxis& y, const std::vector<double>& r_mm,
                 const std::vector<double>& values, const char* color, bool dashed) {
  std::string points;
  bool drawing = false;
  for (std::size_t i = 0; i < r_mm.size(); ++i) {
    if (!y.holds(values[i])) {
      drawing = false;
      continue;
    }
    points += fmt::format("{}{:.1f} {:.1f}", drawing ? "L" : "M", x.px(r_mm[i]), y.px(values[i]));
    drawing = true;
  }
  if (points.empty()) return "";
  return fmt::format("<path class=\"line\" stroke=\"{}\"{} d=\"{}\"/>\n", color,
                     dashed ? " stroke-dasharray=\"6 4\"" : "", points);
}

std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '&') {
      safe += "&amp;";
    } else if (c == '<') {
      safe += "&lt;";
    } else {
      safe += c;
    }
  }
  return safe;
}

std::string origin(const json& document) {
  if (!document.contains("provenance")) return "";
  const json& program = document.at("provenance");
  return fmt::format("<desc>fitted by truescatter {} ({}{})</desc>\n",
                     escaped(program.at("version").get<std::string>()),
                     escaped(program.at("commit").get<std::string>()),
                     program.at("commit_dirty").get<bool>() ? " with changes" : "");
}

std::string legend(const json& document) {
  const std::size_t gaussians = document.at("variances").size();
  std::string svg = fmt::format("<text x=\"{}\" y=\"22\" font-weight=\"bold\">{}: {} Gaussian{}</text>\n",
                                kLeft_px, escaped(document.at("asked").at("title").get<std::string>()),
                                gaussians, gaussians == 1 ? "" : "s");
  for (std::size_t c = 0; c < 3; ++c) {
    std::string errors;
    for (const char* norm : {"r", "area", "r2"}) {
      const json& error = document.at("error").at(norm).at(c);
      errors += error.is_null() ? fmt::format("  {} none", norm)
                                : fmt::format("  {} {:.3g} %", norm, 100.0 * error.get<double>());
    }
    svg += fmt::format("<text x=\"{}\" y=\"{}\" fill=\"{}\">{}: relative error{}</text>\n", kLeft_px,
                       42 + 16 * c, kColors[c], kChannels[c], errors);
  }
  return svg;
}

std::string draw(const json& document) {
  const Curve curve = read_curve(document);
  std::vector<double> all;
  std::vector<double> all_off;
  std::array<std::vector<double>, 3> bright;
  std::array<std::vector<double>, 3> dark;
  for (std::size_t c = 0; c < 3; ++c) {
    all.insert(all.end(), curve.profile[c].begin(), curve.profile[c].end());
    for (std::size_t i = 0; i < curve.r_mm.size(); ++i) {
      const double off = curve.fit[c][i] - curve.profile[c][i];
      bright[c].push_back(off);
      dark[c].push_back(-off);
      all_off.push_back(std::abs(off));
    }
  }
  const LogAxis x{std::log10(curve.r_mm.front()), std::log10(curve.r_mm.back()), kLeft_px, kRight_px};
  const LogAxis top = axis_of(all, kMostDecades, 390.0, 90.0);
  const LogAxis bottom = axis_of(all_off, kMostDecades, 650.0, 430.0);

  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" "
      "font-family=\"sans-serif\" font-size=\"12\" fill=\"#333\">\n"
      "<style>.grid{{stroke:#ddd}}.frame{{fill:none;stroke:#888}}.line{{fill:none;stroke-width:1.6}}</"
      "style>\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
      kWidth_px, kHeight_px);
  svg += origin(document);
  svg += legend(document);
  svg += frame(x, top, "R (solid), Gaussians (dashed), 1/mm\u00b2") +
         frame(x, bottom, "|R - S|, 1/mm\u00b2; dashed: too dark");
  for (std::size_t c = 0; c < 3; ++c) {
    svg += path(x, top, curve.r_mm, curve.profile[c], kColors[c], false);
    svg += path(x, top, curve.r_mm, curve.fit[c], kColors[c], true);
    svg += path(x, bottom, curve.r_mm, bright[c], kColors[c], false);
    svg += path(x, bottom, curve.r_mm, dark[c], kColors[c], true);
  }
  return svg + fmt::format("<text x=\"{:.1f}\" y=\"690\" text-anchor=\"middle\">r, mm</text>\n</svg>\n",
                           0.5 * (kLeft_px + kRight_px));
}

}  // namespace

std::string fit_plot_svg(std::string_view fit_json) {
  try {
    return draw(json::parse(fit_json));
  } catch (const json::exception& error) {
    throw_input_error({}, "this is no fit with a curve: {}", error.what());
  }
}

}  // namespace truescatter
