/// What differences of a computed function can tell.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <type_traits>

namespace deform {

/// How much of a function's values is rounding, in the norm of its values: root mean square, from
/// the fourth differences of its values at seven places so near to each other that nothing else
/// shows in these (Moré & Wild, Estimating computational noise, SIAM J. Sci. Comput. 33, 2011).
/// `f`: a matrix by the place s; `spacing`: of the places, about 1e-8 of the scale of s.
template <class Function>
double noise_of(const Function& f, double spacing) {
  using Value = std::decay_t<decltype(f(0.0))>;
  constexpr std::size_t kPlaces = 7, kOrder = 4;
  constexpr double kVariance = 70;  // of a fourth difference of independent numbers: 8!/(4!)²
  std::array<Value, kPlaces> table;
  for (std::size_t i = 0; i < kPlaces; ++i) table[i] = f(spacing * static_cast<double>(i));
  for (std::size_t order = 0; order < kOrder; ++order)
    for (std::size_t i = 0; i + order + 1 < kPlaces; ++i) table[i] = table[i + 1] - table[i];
  double sum = 0;
  for (std::size_t i = 0; i + kOrder < kPlaces; ++i) sum += table[i].squaredNorm();
  return std::sqrt(sum / static_cast<double>(kPlaces - kOrder) / kVariance);
}

/// The derivative of a function at 0 by the fourth-order formula, and what that leaves open.
template <class Value>
struct Difference {
  Value derivative;
  /// Norm of the error: that of the formula, by comparison with twice the step (Richardson), and
  /// the part of rounding.
  double error = 0;
};

/// `step`: of the formula; `spacing`: see noise_of.
template <class Function>
auto difference_of(const Function& f, double step, double spacing) {
  using Value = std::decay_t<decltype(f(0.0))>;
  const auto by = [&f](double h) {
    Value sum = 8 * f(h) - f(2 * h);
    sum += f(-2 * h);
    sum -= 8 * f(-h);
    return Value(sum / (12 * h));
  };
  Difference<Value> found{by(step)};
  const double formula = (found.derivative - by(2 * step)).norm() / 15;
  const double rounding = std::sqrt(130.0) / (12 * step) * noise_of(f, spacing);
  found.error = formula + rounding;
  return found;
}

}  // namespace deform
