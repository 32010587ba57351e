#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "core/image_io.h"
#include "methods/method.h"

namespace truescatter::test {

inline const std::vector<std::string> kGoldenExperiments = {"plane-shadow", "sphere", "sphere-six-gaussians",
                                                            "head"};

// What an experiment of one view and one profile gives: pictures by name ("mask", "irradiance", "truth", a
// method), and the numbers of results.json that belong to them.
struct Outcome {
  std::map<std::string, Image> pictures;
  nlohmann::json numbers;  // {uncertainty, methods: {name: {rel_rmse, bias, halo_peak}}}
};

// Reads a folder that `run` wrote.
inline Outcome read_results(const std::filesystem::path& folder) {
  const auto results = nlohmann::json::parse(std::ifstream(folder / "results.json"));
  Outcome outcome;
  for (const auto& truth : results.at("truths")) {
    if (!truth.at("headline").get<bool>()) continue;
    const LayeredImage file = read_layered_image(folder / truth.at("files").at("exr").get<std::string>());
    outcome.pictures["truth"] = rgb_of(file);
    outcome.pictures["irradiance"] = rgb_of(file, "irradiance");
    outcome.pictures["mask"] = read_exr_layer(file.path, "mask");
    outcome.numbers["uncertainty"] = truth.at("uncertainty");
  }
  for (const auto& run : results.at("runs")) {
    const std::string name = run.at("method");
    outcome.pictures[name] = read_rgb(folder / run.at("files").at("exr").get<std::string>());
    const auto& metrics = run.at("metrics");
    outcome.numbers["methods"][name] = {{"rel_rmse", metrics.at("rel_rmse")},
                                        {"bias", metrics.at("bias")},
                                        {"halo_peak", metrics.at("halo").at("peak")}};
  }
  return outcome;
}

// Golden results: one 32-bit EXR per picture (16 bits round to 5e-4, above every tolerance) and numbers.json.
inline void write_golden(const Outcome& outcome, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  for (const auto& [name, picture] : outcome.pictures) write_exr(folder / (name + ".exr"), {{"", &picture}});
  std::ofstream(folder / "numbers.json") << outcome.numbers.dump(1) << '\n';
}

inline Outcome read_golden(const std::filesystem::path& folder) {
  Outcome outcome;
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    if (file.path().extension() == ".exr")
      outcome.pictures[file.path().stem().string()] = read_image(file.path());
  }
  outcome.numbers = nlohmann::json::parse(std::ifstream(folder / "numbers.json"));
  return outcome;
}

// How far a picture may be from its golden one, in units of the light (each lamp has colour 1).
// Irradiance: two renderings differ by the rounding of a pixel's place, 64 px * 2^-24 = 4e-6 px each; on a
// triangle of a pixel or more irradiance changes by 1 at most, so by 8e-6 of both, and 1e-5 with the rounding
// of the values. The mask is 0 or 1. Truth: both certificates. A method: its own rounding in both renderings,
// and irradiance's, of which it is a weighted mean. Its other limits say how far it is from something else.
inline double tolerance_of(const std::string& name, const Outcome& golden, const Outcome& fresh) {
  constexpr double kIrradiance = 1e-5;
  if (name == "mask") return 0.0;
  if (name == "irradiance") return kIrradiance;
  if (name == "truth")
    return golden.numbers.at("uncertainty").get<double>() + fresh.numbers.at("uncertainty").get<double>();
  return 2.0 * find_method(name).limits.rounding + kIrradiance;
}

struct Difference {
  double largest = 0.0;
  int x = 0;
  int y = 0;
};

// Of two pictures of one size; infinite where only one of two values is a number.
inline Difference difference_of(const Image& a, const Image& b) {
  Difference found;
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x < a.width(); ++x) {
      for (int c = 0; c < a.channels(); ++c) {
        const double d = std::abs(static_cast<double>(a.at(x, y, c)) - static_cast<double>(b.at(x, y, c)));
        if (!(d <= found.largest)) found = {std::isnan(d) ? HUGE_VAL : d, x, y};
      }
    }
  }
  return found;
}

// PNG and EXR of golden, new and difference, which is grey at 0 and black or white at -/+ the tolerance.
// Returns the paths of the three PNG.
inline std::string write_three(const std::filesystem::path& folder, const std::string& name,
                               const Image& golden, const Image& fresh, double tolerance) {
  std::filesystem::create_directories(folder);
  Image difference = golden;
  Image amplified = golden;
  for (std::size_t i = 0; i < golden.data().size(); ++i) {
    const double d = static_cast<double>(fresh.data()[i]) - static_cast<double>(golden.data()[i]);
    difference.data()[i] = static_cast<float>(d);
    const double shown = tolerance > 0.0 ? d / tolerance : d;
    amplified.data()[i] = static_cast<float>(std::clamp(0.5 + 0.5 * shown, 0.0, 1.0));
  }
  const auto encoded = [](Image picture) {
    for (float& value : picture.data()) value = static_cast<float>(srgb_encode(static_cast<double>(value)));
    return picture;
  };
  std::string paths;
  const auto write = [&](const std::string& kind, const Image& values, const Image& shown) {
    const auto path = folder / (name + "." + kind);
    write_exr(path.string() + ".exr", {{"", &values}});
    write_png(path.string() + ".png", shown);
    paths += "\n  " + path.string() + ".png";
  };
  write("golden", golden, encoded(golden));
  write("new", fresh, encoded(fresh));
  write("difference", difference, amplified);
  return paths;
}

inline double rms_luminance(const Image& rgb, const Image& mask) {
  double sum = 0.0;
  double count = 0.0;
  for (int y = 0; y < rgb.height(); ++y) {
    for (int x = 0; x < rgb.width(); ++x) {
      if (mask.at(x, y, 0) == 0.0F) continue;
      sum += std::pow(rgb.rgb(x, y).dot(Vec3d(0.2126, 0.7152, 0.0722)), 2);
      count += 1.0;
    }
  }
  return std::sqrt(sum / count);
}

// Says what differs by more than allowed, one entry each; the three pictures of each go to `folder`.
// The numbers may differ by what the pictures' differences as found explain: an error changes by e = that of
// the method and of the truth and their rounding to single precision, so bias by e, relative RMSE by
// (1 + rel_rmse) e / RMS of the truth, and a bin's relative error by (1 + peak) e / its mean true light,
// which is a thousandth of the RMS or more (HaloProfile).
inline std::vector<std::string> changes(const Outcome& golden, const Outcome& fresh,
                                        const std::filesystem::path& folder) {
  std::vector<std::string> found;
  std::map<std::string, double> differs;
  for (const auto& [name, picture] : fresh.pictures) {
    if (!golden.pictures.contains(name)) found.push_back(name + ": no golden picture");
  }
  for (const auto& [name, picture] : golden.pictures) {
    const auto other = fresh.pictures.find(name);
    if (other == fresh.pictures.end() || other->second.width() != picture.width() ||
        other->second.height() != picture.height() || other->second.channels() != picture.channels()) {
      found.push_back(name + ": no new picture of the same size");
      continue;
    }
    const Difference difference = difference_of(picture, other->second);
    const double allowed = tolerance_of(name, golden, fresh);
    differs[name] = difference.largest;
    if (difference.largest <= allowed) continue;
    std::ostringstream text;
    text << name << ": differs by " << difference.largest << " at pixel (" << difference.x << ", "
         << difference.y << "), allowed are " << allowed
         << write_three(folder, name, picture, other->second, allowed);
    found.push_back(text.str());
  }
  if (!found.empty()) return found;
  const double rms = rms_luminance(golden.pictures.at("truth"), golden.pictures.at("mask"));
  for (const auto& [name, numbers] : golden.numbers.at("methods").items()) {
    const double e = differs.at(name) + differs.at("truth") + std::ldexp(1.0, -23);
    for (const auto& [key, value] : numbers.items()) {
      const auto& now = fresh.numbers.at("methods").at(name).at(key);
      if (value == now) continue;
      const double size = value.is_number() ? std::abs(value.get<double>()) : 0.0;
      const double allowed = key == "bias"       ? e
                             : key == "rel_rmse" ? (1.0 + size) * e / rms
                                                 : (1.0 + size) * e / (1e-3 * rms);
      if (value.is_number() && now.is_number() &&
          std::abs(value.get<double>() - now.get<double>()) <= allowed)
        continue;
      std::ostringstream text;
      text << name << ": " << key << " was " << value << ", is " << now << ", allowed are +-" << allowed;
      found.push_back(text.str());
    }
  }
  return found;
}

}  // namespace truescatter::test
