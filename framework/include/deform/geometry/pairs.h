/// Index pairs ij of the fundamental forms, and the derivatives that a jet is made of.
#pragma once

#include <array>
#include <cstdint>

namespace deform {

/// Linear maps from node positions to a sample: its place D_0 r and its jet (D_1 r, …, D_22 r).
enum class Derivative : std::uint8_t { d0, d1, d2, d11, d12, d22 };
inline constexpr int kDerivatives = 6;

/// The pairs ij that differ: G, B and r_ij are symmetric, so 21 is 12.
enum class Pair : std::uint8_t { p11, p12, p22 };
inline constexpr std::array kPairs{Pair::p11, Pair::p12, Pair::p22};

/// How often a pair occurs in a sum over all four ij.
[[nodiscard]] constexpr double multiplicity(Pair ij) { return ij == Pair::p12 ? 2.0 : 1.0; }

[[nodiscard]] constexpr int slot(Pair ij) { return static_cast<int>(ij); }
[[nodiscard]] constexpr int slot(Derivative d) { return static_cast<int>(d); }

/// r_ij of the pair.
[[nodiscard]] constexpr Derivative second(Pair ij) {
  return ij == Pair::p11 ? Derivative::d11 : ij == Pair::p12 ? Derivative::d12 : Derivative::d22;
}
/// r_i, i = 1 or 2.
[[nodiscard]] constexpr Derivative first(int i) { return i == 1 ? Derivative::d1 : Derivative::d2; }
/// The pair of two indices in 1..2.
[[nodiscard]] constexpr Pair pair(int i, int j) {
  return i != j ? Pair::p12 : (i == 1 ? Pair::p11 : Pair::p22);
}

}  // namespace deform
