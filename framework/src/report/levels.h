/// Numbers rounded to 16 bits, as reports hold them: docs/report-format.md, "Arrays".
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

namespace deform {

/// A value is min + (max − min) level / kMostLevel.
inline constexpr std::uint16_t kMostLevel = 65534;
inline constexpr std::uint16_t kNoLevel = 65535;  ///< there is no value

/// From the smallest to the largest of the finite numbers that it was shown.
class LevelRange {
 public:
  void add(double value) {
    if (!std::isfinite(value)) return;
    min_ = std::fmin(min_, value);
    max_ = std::fmax(max_, value);
  }
  /// 0 and 0 where there was no finite number.
  [[nodiscard]] double min() const { return min_ <= max_ ? min_ : 0; }
  [[nodiscard]] double max() const { return min_ <= max_ ? max_ : 0; }
  /// The nearest level; kNoLevel for what is not finite.
  [[nodiscard]] std::uint16_t level(double value) const {
    if (!std::isfinite(value)) return kNoLevel;
    if (!(min_ < max_)) return 0;
    // Halves: the extent itself may be too large for a double.
    const double part = (value / 2 - min_ / 2) / (max_ / 2 - min_ / 2);
    return static_cast<std::uint16_t>(std::lround(std::fmin(std::fmax(part, 0), 1) * kMostLevel));
  }

 private:
  double min_ = std::numeric_limits<double>::infinity();
  double max_ = -std::numeric_limits<double>::infinity();
};

/// The level of a category: its number.
[[nodiscard]] inline std::uint16_t level_of_category(double number) {
  const bool is_one = number >= 0 && number < kMostLevel;  // false for NaN
  return is_one ? static_cast<std::uint16_t>(std::lround(number)) : kNoLevel;
}

}  // namespace deform
