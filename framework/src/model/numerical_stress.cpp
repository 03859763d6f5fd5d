/// JetTerm::stress of a term that says nothing but its energy: a numerical derivative of the
/// density.
#include "model/numerical_stress.h"

#include <algorithm>
#include <array>
#include <vector>

#include "deform/model/energy_term.h"

#include "model/moved_block.h"

namespace deform {
namespace {

/// By has_numerical_stress, on the thread that asks.
thread_local bool was_asked = false;

}  // namespace

bool has_numerical_stress(const JetTerm& term, const SampleBlock& block) {
  const auto size = static_cast<std::size_t>(block.size());
  std::vector<double> numbers(3 * kChannels * size);
  Stress sigma;
  for (std::size_t m = 0; m < sigma.sigma.size(); ++m) {
    double* const x = numbers.data() + 3 * m * size;
    sigma.sigma[m] = {x, x + size, x + 2 * size};
  }
  was_asked = false;
  term.stress(block, sigma);
  return was_asked;
}

void JetTerm::stress(const SampleBlock& block, const Stress& sigma) const {
  was_asked = true;
  const auto size = static_cast<std::size_t>(block.size());
  MovedBlock moved(block.now);
  SampleBlock there = block;
  std::array<double, kBlock> above{}, below{};
  const auto density_at = [&](std::size_t m, int c, double step, Values density) {
    moved.move(m, c, step);
    there.now = moved.view();
    std::ranges::fill(density, 0.0);
    energy_density(there, density);
  };
  for (std::size_t k = 0; k < kJetComponents; ++k) {
    const std::size_t m = k / 3;
    const int c = static_cast<int>(k % 3);
    density_at(m, c, kRelativeStep, {above.data(), size});
    density_at(m, c, -kRelativeStep, {below.data(), size});
    const Vectors out = sigma(static_cast<Derivative>(m + 1));
    double* component = c == 0 ? out.x : c == 1 ? out.y : out.z;
    for (std::size_t s = 0; s < size; ++s)
      component[s] +=
          (above[s] - below[s]) / (2 * kRelativeStep * moved.scale(m, static_cast<Index>(s)));
  }
}

}  // namespace deform
