#include "deform/simulation/remarks.h"

#include <cmath>

#include <fmt/format.h>

namespace deform {
namespace {

/// Of a step: far more than rounding makes of the quotient, far less than anybody means.
constexpr double kRounding = 1e-6;

}  // namespace

std::vector<Problem> remarks(const Scene& scene) {
  std::vector<Problem> found;
  const auto steps = static_cast<double>(scene.steps());
  if (std::abs(scene.duration / scene.step - steps) > kRounding) {
    found.push_back(scene.located(
        {"/duration",
         fmt::format("{} s is no whole number of steps of {} s: {} are run, to {:.6g} s",
                     scene.duration, scene.step, steps, steps * scene.step)}));
  }
  for (const std::string& pointer : scene.dropped)
    found.push_back(scene.located(
        {pointer,
         fmt::format("at {}: dropped, as the plugin put in has no such parameter", pointer)}));
  for (const Problem& problem : scene.elsewhere)
    found.push_back({problem.pointer, problem.message + " (not needed for this run)"});
  return found;
}

}  // namespace deform
