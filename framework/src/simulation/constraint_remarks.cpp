#include "simulation/constraint_remarks.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "deform/error.h"

#include "plugin/guard.h"
#include "simulation/part_maker.h"

namespace deform {
namespace {

/// Of the surface's size: positions that are nearer are the same.
constexpr double kSamePlace = 1e-9;
/// Times to look at, before their middles are added.
constexpr std::size_t kMostTimes = 100;

/// A constraint, and what it says by itself.
struct Held {
  Named<Constraint> constraint;
  std::string pointer;
  std::vector<Freedom> prescribed;
  NodeVectors r;  // (N × 3) at the time that is looked at [m]
};

/// Where two positions of a component are farthest apart.
struct Gap {
  Freedom at;
  double size = 0;      // [m]
  double time = 0;      // [s]
  double position = 0;  // the second of both [m]
};

/// Two constraints that prescribe the same components.
struct Overlap {
  std::size_t earlier, later;
  std::vector<Freedom> common;
  Gap moved, apart;  // of the earlier one's positions from the initial ones, from the later one's
};

std::vector<double> times_to_look_at(const std::vector<Held>& all, double end) {
  std::vector<double> times{0, end};
  const std::size_t most = kMostTimes / std::max<std::size_t>(all.size(), 1) + 1;
  for (const Held& held : all) {
    double t = 0;
    for (std::size_t i = 0; i < most; ++i) {
      t = guarded(held.constraint.origin, "saying when it is not smooth in time",
                  [&] { return held.constraint.object->next_break(t); });
      if (!(t < end)) break;
      times.push_back(t);
    }
  }
  std::ranges::sort(times);
  for (std::size_t i = times.size() - 1; i > 0; --i)
    times.push_back(0.5 * (times[i - 1] + times[i]));
  std::ranges::sort(times);
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
}

char name_of_component(int c) { return "xyz"[c]; }

std::vector<Freedom> prescribed_by(const Reduction& reduction) {
  std::vector<Freedom> freedoms;
  for (Index node = 0; node < reduction.nodes(); ++node)
    for (int c = 0; c < 3; ++c)
      if (reduction.prescribed(node, c)) freedoms.push_back({node, c});
  return freedoms;
}

/// Of two lists in ascending order.
std::vector<Freedom> common(const std::vector<Freedom>& a, const std::vector<Freedom>& b) {
  std::vector<Freedom> both;
  const auto is_before = [](const Freedom& x, const Freedom& y) {
    return std::pair{x.node, x.component} < std::pair{y.node, y.component};
  };
  std::ranges::set_intersection(a, b, std::back_inserter(both), is_before);
  return both;
}

/// Makes the gap that of the farthest of some components, if it was smaller before.
void widen(Gap& gap, const std::vector<Freedom>& freedoms, const NodeVectors& from,
           const NodeVectors& to, double time) {
  for (const Freedom& f : freedoms) {
    const double there = to(f.node, f.component);
    const double size = std::abs(from(f.node, f.component) - there);
    if (size > gap.size) gap = {f, size, time, there};
  }
}

class Remarks {
 public:
  explicit Remarks(Simulation& simulation)
      : scene_(simulation.scene()),
        initial_(simulation.system().surface().initial()),
        same_(kSamePlace * simulation.size()) {
    make_constraints(simulation);
    for (std::size_t later = 0; later < all_.size(); ++later)
      for (std::size_t earlier = 0; earlier < later; ++earlier)
        if (auto both = common(all_[earlier].prescribed, all_[later].prescribed); !both.empty())
          overlaps_.push_back({earlier, later, std::move(both), {}, {}});
  }

  [[nodiscard]] std::vector<Problem> all() {
    look_at(0);
    for (const Held& held : all_) add_start(held);
    if (overlaps_.empty()) return std::move(remarks_);
    const double end = scene_.step * static_cast<double>(scene_.steps());
    for (const double time : times_to_look_at(all_, end)) {
      look_at(time);
      for (Overlap& o : overlaps_) {
        widen(o.moved, o.common, initial_, all_[o.earlier].r, time);
        widen(o.apart, o.common, all_[o.earlier].r, all_[o.later].r, time);
      }
    }
    for (const Overlap& overlap : overlaps_) add_loss(overlap);
    return std::move(remarks_);
  }

 private:
  void make_constraints(Simulation& simulation) {
    PartMaker maker(scene_, simulation.registry());
    const System& system = simulation.system();
    const Setup setup = maker.setup(system.surface(), system.surface().rest(), system.areas());
    for (const PluginUse& use : scene_.plugins[PluginKind::constraint]) {
      auto made = maker.make<Constraint>(use, setup);
      if (!made) continue;
      Reduction reduction(initial_.rows());
      guarded(made->origin, "saying what it holds", [&] { made->object->reduce(reduction); });
      all_.push_back({std::move(*made), use.pointer, prescribed_by(reduction), initial_});
    }
  }

  void look_at(double time) {
    for (Held& held : all_)
      guarded(held.constraint.origin, "prescribing positions",
              [&] { held.constraint.object->prescribe(time, held.r); });
  }

  void add_start(const Held& held) {
    Gap gap;
    widen(gap, held.prescribed, initial_, held.r, 0);
    if (!(gap.size > same_)) return;
    add(held,
        fmt::format("node {} is at {} = {:.4g} m when the run begins, {:.4g} m from where the "
                    "surface begins, which tears it; a displacement that begins with 0 does "
                    "not",
                    gap.at.node, name_of_component(gap.at.component), gap.position, gap.size));
  }

  void add_loss(const Overlap& o) {
    if (!(o.moved.size > same_ && o.apart.size > same_)) return;
    const Held &earlier = all_[o.earlier], &later = all_[o.later];
    add(later,
        fmt::format("{} takes {} components over from {} (at {}), which moves them elsewhere: "
                    "{} of node {} {:.4g} m away at {:.4g} s; the later one holds",
                    later.constraint.name, o.common.size(), earlier.constraint.name,
                    earlier.pointer, name_of_component(o.apart.at.component), o.apart.at.node,
                    o.apart.size, o.apart.time));
  }

  void add(const Held& held, const std::string& text) {
    remarks_.push_back({held.pointer, fmt::format("at {}: {}", held.pointer, text)});
  }

  const Scene& scene_;
  NodeVectors initial_;  // (N × 3) [m]
  double same_;          // [m]
  std::vector<Held> all_;
  std::vector<Overlap> overlaps_;
  std::vector<Problem> remarks_;
};

}  // namespace

std::vector<Problem> constraint_remarks(Simulation& simulation) {
  if (simulation.scene().plugins[PluginKind::constraint].empty()) return {};
  try {
    return Remarks(simulation).all();
  } catch (const Error&) {
    return {};  // what fails here is told where the run needs it
  }
}

}  // namespace deform
