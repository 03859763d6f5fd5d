/// JetTerm::stress of a term that says nothing but its energy: a numerical derivative of the
/// density.
#include "model/numerical_stress.h"

#include <algorithm>
#include <array>
#include <vector>

#include "deform/model/energy_term.h"

#include "geometry/sample_geometry.h"

namespace deform {
namespace {

constexpr std::size_t kComponents = 15;  // 5 derivatives of 3 components
/// Central differences of a smooth density: rounding and truncation errors balance near ε^(1/3).
constexpr double kRelativeStep = 6e-6;

/// By has_numerical_stress, on the thread that asks.
thread_local bool was_asked = false;

/// A copy of a block's geometry with one component of one derivative moved at every sample.
class MovedBlock {
 public:
  explicit MovedBlock(const GeometryBlock& block)
      : block_(block), data_(static_cast<std::size_t>(GeometryBlock::kFields * block.size())) {}

  /// Moves component c of derivative m by `step` times its sample's scale.
  void move(std::size_t m, int c, double step) {
    for (Index s = 0; s < block_.size(); ++s) {
      SampleGeometry g = at(s);
      // Where the frame is not that of r_1 and r_2, the normal does not follow them.
      const bool follows = g.jet[0].cross(g.jet[1]).squaredNorm() > 0;
      g.jet[m][c] += step * scale(m, s);
      if (follows && m < 2) g.n = unit_normal(g.jet[0], g.jet[1]);
      write_sample(data_.data(), block_.size(), s, g);
    }
  }
  [[nodiscard]] double scale(std::size_t m, Index s) const {
    return std::max(1.0, block_.r(static_cast<Derivative>(m + 1))[s].norm());
  }
  /// The view keeps the block's place in its set, so that a term finds its own per-sample data.
  [[nodiscard]] GeometryBlock view() const {
    return {data_.data() - block_.first(), block_.size(), block_.first(), block_.size()};
  }

 private:
  [[nodiscard]] SampleGeometry at(Index s) const {
    SampleGeometry g;
    for (std::size_t m = 0; m < 5; ++m) g.jet[m] = block_.r(static_cast<Derivative>(m + 1))[s];
    g.n = block_.n()[s];
    return g;
  }
  const GeometryBlock& block_;
  std::vector<double> data_;
};

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
  for (std::size_t k = 0; k < kComponents; ++k) {
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
