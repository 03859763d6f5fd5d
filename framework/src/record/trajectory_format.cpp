#include "record/trajectory_format.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

namespace deform::trajectory_format {
namespace {

using Scale = TrajectoryField::Scale;

constexpr std::array<std::pair<Scale, const char*>, 3> kScales{
    {{Scale::sequential, "sequential"},
     {Scale::diverging, "diverging"},
     {Scale::categorical, "categorical"}}};

}  // namespace

Json json_of(const TrajectoryField& field) {
  const auto* const scale =
      std::ranges::find(kScales, field.scale, &std::pair<Scale, const char*>::first);
  return {{"name", field.name},
          {"unit", field.unit},
          {"scale", scale->second},
          {"labels", field.labels}};
}

TrajectoryField field_of(const Json& json) {
  const auto name = json.at("scale").get<std::string>();
  const auto* const scale =
      std::ranges::find(kScales, name, &std::pair<Scale, const char*>::second);
  if (scale == kScales.end()) throw std::runtime_error("a field has no scale '" + name + "'");
  return {json.at("name").get<std::string>(), json.at("unit").get<std::string>(), scale->first,
          json.at("labels").get<std::vector<std::string>>()};
}

}  // namespace deform::trajectory_format
