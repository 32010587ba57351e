#include "composite/specular.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/parallel.h"

namespace truescatter {

double schlick_fresnel(double cosine, double f0) {
  const double rest = 1.0 - cosine;
  const double fifth = rest * rest * rest * rest * rest;
  return fifth + (1.0 - fifth) * f0;
}

double kelemen_specular(const Vec3d& normal, const Vec3d& light, const Vec3d& view, double m, double f0) {
  if (normal.dot(light) <= 0.0) return 0.0;
  const Vec3d h = light + view;
  const double h_h = std::max(h.squaredNorm(), 1e-6);
  const Vec3d half = h / std::sqrt(h_h);
  return beckmann(normal.dot(half), m) * schlick_fresnel(std::clamp(half.dot(view), 0.0, 1.0), f0) / h_h;
}

SpecularMoments specular_moments(double n_v, double m, double f0, int steps) {
  const Vec3d view(std::sqrt(std::max(0.0, 1.0 - n_v * n_v)), 0.0, n_v);
  SpecularMoments sum;
  for (int i = 0; i < steps; ++i) {
    const double tangent = m * std::sqrt(-std::log1p(-(i + 0.5) / steps));
    const double cosine = 1.0 / std::sqrt(1.0 + tangent * tangent);
    for (int j = 0; j < steps; ++j) {
      const double phi = kPi * (j + 0.5) / steps;  // the other half mirrors it
      const Vec3d half = cosine * Vec3d(tangent * std::cos(phi), tangent * std::sin(phi), 1.0);
      const double v_h = view.dot(half);
      if (v_h <= 0.0) continue;
      const Vec3d light = 2.0 * v_h * half - view;
      if (light.z() <= 0.0) continue;
      const double weight = schlick_fresnel(std::min(v_h, 1.0), f0) * light.z() / (v_h * cosine);
      sum.albedo += weight;
      sum.x += weight * light.x();
      sum.n += weight * light.z();
      sum.xx += weight * light.x() * light.x();
      sum.nn += weight * light.z() * light.z();
      sum.xn += weight * light.x() * light.z();
    }
  }
  const double share = 1.0 / (double(steps) * steps);
  return {sum.albedo * share, sum.x * share, sum.n * share, sum.xx * share, sum.nn * share, sum.xn * share};
}

MomentTables make_moment_tables(double f0) {
  // Between values 1/63 apart the steepest, F ~ (1 - n_v)^5, is missed by 20 / 63^2 / 8 = 6e-4.
  constexpr int kColumns = 64;
  constexpr int kRows = 32;
  MomentTables tables{Image(kColumns, kRows, 4), Image(kColumns, kRows, 4)};
  parallel_for(kRows, [&](std::size_t r) {
    const int row = static_cast<int>(r);
    const double m =
        kLeastRoughness * std::pow(kLargestRoughness / kLeastRoughness, double(row) / (kRows - 1));
    for (int column = 0; column < kColumns; ++column) {
      const SpecularMoments moments = specular_moments(double(column) / (kColumns - 1), m, f0);
      const double values[] = {moments.albedo, moments.x, moments.n, moments.xx, moments.nn, moments.xn};
      for (int i = 0; i < 6; ++i) {
        Image& image = i < 4 ? tables.first : tables.second;
        image.at(column, kRows - 1 - row, i % 4) = static_cast<float>(values[i]);
      }
    }
  });
  return tables;
}

}  // namespace truescatter
