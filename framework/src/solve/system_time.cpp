/// What a System knows of time: velocities of what is moved, steps that its parts stand, and when
/// they are not smooth.
#include <algorithm>

#include <fmt/format.h>

#include "plugin/guard.h"
#include "solve/system_impl.h"

namespace deform {
namespace {

/// Prescribed velocities are differences of positions over this part of a step: shorter ones lose
/// digits, longer ones the order of methods up to the fourth.
constexpr double kPartOfReach = 1e-3;

}  // namespace

void System::prescribe_velocity(double time, double reach, NodeVectors& v) const {
  if (impl_->parts.constraints.empty()) return;
  // Constraints give positions alone. The parabola through three of them, of which the farthest is
  // two differences away, is wrong by a third of the difference squared times r⃛.
  double difference = time - (time - kPartOfReach * reach);  // of times that are numbers
  if (difference == 0) difference = reach;
  NodeVectors now = NodeVectors::Zero(nodes(), 3), near = now, far = now;
  prescribe(time, now);
  prescribe(time - difference, near);
  prescribe(time - 2 * difference, far);
  for (int c = 0; c < 3; ++c)
    for (Index a = 0; a < v.rows(); ++a)
      if (reduction().prescribed(a, c))
        v(a, c) = (4 * (now(a, c) - near(a, c)) - (now(a, c) - far(a, c))) / (2 * difference);
  follow_ties_of_velocity(v);
}

/// Calls ask(origin, plugin) for each part of the model that may depend on time.
template <class Ask>
void System::Impl::ask_parts(const Ask& ask) const {
  for (const auto& e : parts.energies) ask(e.origin, *e.object);
  for (const auto& f : parts.forces) ask(f.origin, *f.object);
  for (const auto& c : parts.constraints) ask(c.origin, *c.object);
  for (const auto& b : parts.bodies) ask(b.collider.origin, *b.collider.object);
}

double System::longest_step(double time) const {
  double longest = kInfinity;
  impl_->ask_parts([&](const std::string& origin, const Plugin& part) {
    const double step =
        guarded(origin, "saying what step it stands", [&] { return part.longest_step(time); });
    if (!(step > 0))
      throw PluginFailure("plugin " + origin + " stands steps of " + std::to_string(step) +
                          " s, expected more than 0");
    longest = std::min(longest, step);
  });
  return longest;
}

double System::next_break(double after) const {
  double first = kInfinity;
  impl_->ask_parts([&](const std::string& origin, const Plugin& part) {
    const double time = guarded(origin, "saying when it is not smooth in time",
                                [&] { return part.next_break(after); });
    if (!(time > after))
      throw PluginFailure(
          fmt::format("plugin {} is not smooth at {} s when asked for later times than {} s",
                      origin, time, after));
    first = std::min(first, time);
  });
  return first;
}

}  // namespace deform
