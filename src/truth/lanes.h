#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace truescatter {

// Numbers that are worked on at once, one for each of several points.
inline constexpr std::size_t kLanes = 8;

template <typename Scalar>
struct LaneTypes;
template <>
struct LaneTypes<float> {
  using Value [[gnu::vector_size(kLanes * sizeof(float))]] = float;
  using Bits [[gnu::vector_size(kLanes * sizeof(float))]] = std::int32_t;
  static constexpr int kMantissaBits = 23;
  static constexpr std::size_t kSeriesTerms = 6;  // remainder below 1.3e-7
};
template <>
struct LaneTypes<double> {
  using Value [[gnu::vector_size(kLanes * sizeof(double))]] = double;
  using Bits [[gnu::vector_size(kLanes * sizeof(double))]] = std::int64_t;
  static constexpr int kMantissaBits = 52;
  static constexpr std::size_t kSeriesTerms = 12;  // remainder below 1.7e-16
};

template <typename Scalar>
using Lanes = typename LaneTypes<Scalar>::Value;

// x = 2^x for x <= 0 (in place: how such values are passed depends on the machine); what is less than 2^-80
// becomes that. The fraction f of x, within [-1/2, 1/2], goes through the series of exp(f ln 2), whose
// remainder after n terms is at most (ln 2 / 2)^(n+1) / (n+1)! times 1.2; the whole part is added to the
// exponent's bits.
template <typename Scalar>
inline void replace_by_exp2(Lanes<Scalar>& x) {
  using Types = LaneTypes<Scalar>;
  using Bits = typename Types::Bits;
  constexpr Scalar kLn2 = Scalar(0.693147180559945309417232121458);
  // Adding it rounds to whole numbers, which then stand in the lowest bits.
  constexpr Scalar kRounder = Scalar(1.5) * static_cast<Scalar>(std::int64_t{1} << Types::kMantissaBits);
  x = x < Scalar(-80) ? Lanes<Scalar>{} - Scalar(80) : x;
  const Lanes<Scalar> rounded = x + kRounder;
  const Lanes<Scalar> f = (x - (rounded - kRounder)) * kLn2;
  constexpr auto kInverseFactorials = [] {
    std::array<Scalar, Types::kSeriesTerms + 1> values{};
    double value = 1.0;
    for (std::size_t k = 0; k < values.size(); value /= static_cast<double>(++k))
      values[k] = static_cast<Scalar>(value);
    return values;
  }();
  Lanes<Scalar> series = Lanes<Scalar>{} + kInverseFactorials[Types::kSeriesTerms];
  for (std::size_t k = Types::kSeriesTerms; k-- > 0;) series = series * f + kInverseFactorials[k];
  x = reinterpret_cast<Lanes<Scalar>>(reinterpret_cast<Bits>(series) +
                                      (reinterpret_cast<Bits>(rounded) << Types::kMantissaBits));
}

}  // namespace truescatter
