#include "deform/plugin/values.h"

#include <algorithm>
#include <cmath>

#include "deform/error.h"

namespace deform {
namespace {

/// What sums of steps may leave of a time, relative.
constexpr double kRoundingOfTime = 1e-13;

using Point = std::pair<double, double>;

/// Factor on the line through two points, a's time before b's.
double between(const Point& a, const Point& b, double time) {
  const double s = (time - a.first) / (b.first - a.first);
  return (1 - s) * a.second + s * b.second;
}

double interpolate(const std::vector<Point>& points, double time) {
  if (time <= points.front().first) return points.front().second;
  if (time >= points.back().first) return points.back().second;
  const auto next = std::upper_bound(points.begin(), points.end(), time,
                                     [](double t, const Point& p) { return t < p.first; });
  return between(*(next - 1), *next, time);
}

}  // namespace

void require_kind(const PluginUse& use, PluginKind kind) {
  if (use.kind != kind)
    throw InputError({{use.pointer, "plugin '" + use.name + "' is of another kind"}});
}

double TimeProfile::operator()(double time) const {
  if (points.empty()) return 1;
  switch (form) {
    case Form::constant:
      return points.front().second;
    case Form::ramp:
      return std::clamp(between({points[0].first, 0}, {points[1].first, 1}, time), 0.0, 1.0);
    case Form::pulse:
      return time >= points[0].first && time < points[1].first ? 1 : 0;
    case Form::table:
      return interpolate(points, time);
  }
  return 1;
}

double TimeProfile::next_break(double after) const {
  if (form == Form::constant) return kInfinity;
  const auto next = std::upper_bound(points.begin(), points.end(), after,
                                     [](double t, const Point& p) { return t < p.first; });
  return next == points.end() ? kInfinity : next->first;
}

double TimeProfile::until_next_point(double time) const {
  return next_break(time + kRoundingOfTime * std::abs(time)) - time;
}

double first_after(const std::vector<double>& times, double after) {
  const auto next = std::upper_bound(times.begin(), times.end(), after);
  return next == times.end() ? kInfinity : *next;
}

ParameterValues::ParameterValues() = default;
ParameterValues::~ParameterValues() = default;
ParameterValues::ParameterValues(const ParameterValues& other) = default;
ParameterValues::ParameterValues(ParameterValues&& other) noexcept = default;
ParameterValues& ParameterValues::operator=(const ParameterValues& other) = default;
ParameterValues& ParameterValues::operator=(ParameterValues&& other) noexcept = default;

void ParameterValues::set(const std::string& name, ParameterValue value) {
  values_[name] = std::move(value);
}
bool ParameterValues::has(const std::string& name) const { return values_.contains(name); }
const ParameterValue& ParameterValues::at(const std::string& name) const {
  return values_.at(name);
}

}  // namespace deform
