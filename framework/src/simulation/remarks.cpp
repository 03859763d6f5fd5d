#include "deform/simulation/remarks.h"

#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace deform {
namespace {

/// Of a step: far more than rounding makes of the quotient, far less than anybody means.
constexpr double kRounding = 1e-6;

/// Without their place in front.
std::vector<Problem> bare_remarks(const Scene& scene) {
  std::vector<Problem> found;
  const auto steps = static_cast<double>(scene.steps());
  if (std::abs(scene.duration / scene.step - steps) > kRounding) {
    found.push_back(
        {"/duration",
         fmt::format("{} s is no whole number of steps of {} s: {} are run, to {:.6g} s",
                     scene.duration, scene.step, steps, steps * scene.step)});
  }
  return found;
}

}  // namespace

std::vector<Problem> remarks(const Scene& scene) {
  std::set<std::string> said;
  return new_remarks(scene, said);
}

std::vector<Problem> new_remarks(const Scene& scene, std::set<std::string>& said) {
  std::vector<Problem> found;
  for (Problem& remark : bare_remarks(scene)) {
    const std::string place = scene.place ? scene.place(remark.pointer) : scene.file.string();
    if (said.insert(place + ": " + remark.message).second)
      found.push_back(scene.located(std::move(remark)));
  }
  return found;
}

}  // namespace deform
