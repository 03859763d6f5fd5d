#include "check/checks.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "plugin/boundary.h"

namespace deform {
namespace {

std::string figure_text(double figure) { return fmt::format("{:.2g}", figure); }

/// For comparisons: what is not a number is worse than any.
double badness(double figure) { return std::isnan(figure) ? HUGE_VAL : figure; }

}  // namespace

bool ContractReport::passed() const {
  for (const CheckLine& line : lines) {
    if (line.outcome == CheckOutcome::failed) return false;
  }
  return true;
}

std::size_t Checks::line(const std::string& name) {
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    if (lines_[i].name == name) return i;
  }
  lines_.push_back({name, "", "", CheckOutcome::passed, ""});
  worst_.resize(lines_.size(), -HUGE_VAL);
  return lines_.size() - 1;
}

std::string Checks::placed(const std::string& note) const {
  if (place_.empty() || note.empty()) return place_ + note;
  return place_ + ": " + note;
}

void Checks::below(const std::string& name, double figure, double limit, const std::string& cure) {
  const std::size_t i = line(name);
  const double bad = badness(figure / limit);
  if (bad <= worst_[i]) return;
  worst_[i] = bad;
  lines_[i].figure = figure_text(figure);
  lines_[i].limit = figure_text(limit);
  const bool is_met = figure <= limit;
  if (!is_met) lines_[i].outcome = CheckOutcome::failed;
  lines_[i].note = placed(is_met ? "" : cure);
}

void Checks::holds(const std::string& name, bool is_so, const std::string& otherwise) {
  CheckLine& found = lines_[line(name)];
  if (is_so || found.outcome == CheckOutcome::failed) return;  // the first failure tells most
  found.outcome = CheckOutcome::failed;
  found.note = placed(otherwise);
}

void Checks::report(const std::string& name, double figure, const std::string& unit) {
  const std::size_t i = line(name);
  lines_[i].outcome = CheckOutcome::reported;
  if (badness(figure) <= worst_[i]) return;
  worst_[i] = badness(figure);
  lines_[i].figure = figure_text(figure) + (unit.empty() ? "" : ' ' + unit);
  lines_[i].note = place_;
}

void Checks::report(const std::string& name, const std::string& text) {
  CheckLine& found = lines_[line(name)];
  found.outcome = CheckOutcome::reported;
  found.note = text;
}

bool Checks::has_failed(const std::string& name) const {
  return std::ranges::any_of(lines_, [&](const CheckLine& line) {
    return line.name == name && line.outcome == CheckOutcome::failed;
  });
}

bool Checks::runs(const std::string& name, const std::function<void()>& f) {
  try {
    f();
  } catch (...) {
    holds(name, false, cause_of_current_exception());
    return false;
  }
  holds(name, true, "");
  return true;
}

}  // namespace deform
