#include "simulation/selection_remarks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <set>
#include <string>
#include <variant>

#include <fmt/format.h>

#include "deform/log.h"

#include "surface/patches.h"

namespace deform {
namespace {

/// Of the area described.
constexpr double kTolerance = 0.1;

double area(const ParameterRectangle& r) {
  return std::max(r.upper[0] - r.lower[0], 0.0) * std::max(r.upper[1] - r.lower[1], 0.0);
}

/// What of a rectangle is on the surface; on joined sides, which it may go around, at most a
/// period.
ParameterRectangle cut(const ParameterRectangle& r, const Surface& surface) {
  const ParameterRectangle whole = parameter_rectangle(surface);
  const Vec2 period = surface.period();
  ParameterRectangle result = r;
  for (const Index k : {0, 1}) {
    if (period[k] > 0) {
      result.upper[k] = std::min(r.upper[k], r.lower[k] + period[k]);
    } else {
      result.lower[k] = std::max(r.lower[k], whole.lower[k]);
      result.upper[k] = std::min(r.upper[k], whole.upper[k]);
    }
  }
  return result;
}

/// The rectangle of some nodes' parameters; on joined sides, where they may lie on both sides of
/// the seam, that of `described`.
ParameterRectangle hull(const Surface& surface, const std::vector<Index>& nodes,
                        const ParameterRectangle& described) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  ParameterRectangle result{Vec2::Constant(kNone), Vec2::Constant(-kNone)};
  for (const Index node : nodes) {
    const Vec2 a = surface.parameters().row(node);
    result.lower = result.lower.cwiseMin(a);
    result.upper = result.upper.cwiseMax(a);
  }
  for (const Index k : {0, 1})
    if (surface.period()[k] > 0)
      result.lower[k] = described.lower[k], result.upper[k] = described.upper[k];
  return result;
}

enum class Kind { load, hold };

/// What is to be said of one selector; "" if nothing.
std::string remark_on(const NodeSelector& selector, const Surface& surface, Kind kind) {
  const auto rectangle = rectangle_of(selector);
  if (!rectangle || !is_patch(*rectangle)) return "";
  const ParameterRectangle described = cut(*rectangle, surface);
  const double expected = area(described), cell = surface.areas().mean();
  const NodeSelection alone{.selectors = {selector}, .pointer = ""};
  if (!(expected > cell)) return "";
  if (kind == Kind::load) {
    const NodeValues taken = select_areas(surface, alone);
    if (std::abs(taken.sum() - expected) <= kTolerance * expected) return "";
    return fmt::format(
        "takes {} nodes, which stand for {:.4g} m² of the parameters, where {:.4g} m² are "
        "described; another radius or box, or weights \"area\", with which nodes are taken in part",
        (taken.array() > 0).count(), taken.sum(), expected);
  }
  const std::vector<Index> nodes = select_nodes(surface, alone);
  const ParameterRectangle held = hull(surface, nodes, described);
  if (!is_patch(held) || std::abs(area(held) - expected) <= kTolerance * expected) return "";
  return fmt::format(
      "takes {} nodes, between which are {:.4g} m² of the parameters, where {:.4g} "
      "m² are described",
      nodes.size(), area(held), expected);
}

void add_remarks(const std::vector<PluginUse>& uses, const Surface& surface, Kind kind,
                 std::vector<Problem>& remarks) {
  for (const PluginUse& use : uses) {
    if (use.parameters == nullptr) continue;
    for (const auto& [name, value] : use.parameters->entries()) {
      const auto* where = std::get_if<NodeSelection>(&value);
      if (where == nullptr) continue;
      for (const NodeSelector& selector : where->selectors) {
        const std::string remark = remark_on(selector, surface, kind);
        if (!remark.empty())
          remarks.push_back({where->pointer, fmt::format("at {}: {}", where->pointer, remark)});
      }
    }
  }
}

}  // namespace

std::vector<Problem> selection_remarks(const Scene& scene, const Surface& surface) {
  std::vector<Problem> remarks;
  add_remarks(scene.plugins[PluginKind::force], surface, Kind::load, remarks);
  add_remarks(scene.plugins[PluginKind::constraint], surface, Kind::hold, remarks);
  return remarks;
}

void log_selection_remarks(const Scene& scene, const Surface& surface) {
  static std::mutex mutex;
  static std::set<std::string> said;
  const std::scoped_lock lock(mutex);
  for (const Problem& remark : selection_remarks(scene, surface)) {
    const std::string place = scene.place ? scene.place(remark.pointer) : scene.file.string();
    const std::string text = place + ": " + remark.message;
    if (said.insert(text).second) log::info(text);
  }
}

}  // namespace deform
