/// Collects what is found about a plugin: a line a check, whose figure is the worst of all surfaces
/// and states.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "deform/check/contract.h"

namespace deform {

class Checks {
 public:
  explicit Checks(std::vector<CheckLine>& lines) : lines_(lines) {}

  /// Where the figures that follow come from: "arc, central".
  void at(const std::string& place) { place_ = place; }

  /// The figure must not pass the limit, which may be another one from place to place; NaN fails.
  /// `cure`: what to do where it does.
  void below(const std::string& name, double figure, double limit, const std::string& cure = "");
  void holds(const std::string& name, bool is_so, const std::string& otherwise);
  /// A figure that no promise bounds; the largest is kept.
  void report(const std::string& name, double figure, const std::string& unit = "");
  void report(const std::string& name, const std::string& text);

  [[nodiscard]] bool has_failed(const std::string& name) const;

  /// Calls f(); whatever is thrown fails the check. Returns whether nothing was.
  bool runs(const std::string& name, const std::function<void()>& f);

 private:
  [[nodiscard]] std::size_t line(const std::string& name);  // its number; a new one where needed
  [[nodiscard]] std::string placed(const std::string& note) const;

  std::vector<CheckLine>& lines_;
  std::vector<double> worst_;  // a line
  std::string place_;
};

}  // namespace deform
