/// Normal estimators: angles on known surfaces, what they may write, blocks, mirror images.
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "deform/check/known_surfaces.h"
#include "deform/check/mechanics.h"

#include "check/bitwise.h"
#include "check/contracts.h"

namespace deform {
namespace {

/// Below it r_ij has no direction that an estimate could follow [1/m].
constexpr double kFlat = 1e-3;

/// The estimates at all samples of a set; the coefficients one after another, a sample at a time.
Evaluate evaluation(const NormalEstimator& normal, const Geometry& geometry) {
  return [&normal, &geometry](Index block_size, double prefill) {
    Evaluated all;
    for (Index first = 0; first < geometry.size(); first += block_size) {
      const GeometryBlock block =
          geometry.block(first, std::min(block_size, geometry.size() - first));
      std::array<AffineNormal, 3> estimates;
      for (const Pair ij : kPairs)
        normal.estimate(block, ij, estimates[static_cast<std::size_t>(slot(ij))]);
      for (Index s = 0; s < block.size(); ++s)
        for (const AffineNormal& n : estimates) {
          const auto i = static_cast<std::size_t>(s);
          for (const double x : {n.p[i], n.s[0][i], n.s[1][i], n.c[0][i], n.c[1][i], n.c[2][i]})
            all.numbers.push_back(x + prefill);
        }
    }
    return all;
  };
}

/// What the numbers of `evaluation` are.
std::string name_of_coefficient(std::size_t i) {
  constexpr std::array<const char*, 6> coefficients{"p", "s_1", "s_2", "c_x", "c_y", "c_z"};
  constexpr std::array<const char*, 3> pairs{"11", "12", "22"};
  return fmt::format("{} of pair {} at sample {}", coefficients.at(i % 6), pairs.at(i / 6 % 3),
                     i / 18);
}

void check_dependence(const NormalEstimator& normal, const Geometry& geometry, Checks& checks) {
  if (normal.dependence() == Dependence::jet) return;
  const GeometryBlock block = geometry.block(0, std::min(kBlock, geometry.size()));
  bool is_kept = true;
  for (const Pair ij : kPairs) {
    AffineNormal n;
    normal.estimate(block, ij, n);
    for (std::size_t s = 0; s < static_cast<std::size_t>(block.size()); ++s) {
      const bool on_tangents = n.s[0][s] != 0 || n.s[1][s] != 0;
      const bool on_second = n.p[s] != 0 && normal.dependence() == Dependence::none;
      is_kept = is_kept && !on_tangents && !on_second;
    }
  }
  checks.holds("writes only what dependence() allows", is_kept,
               "a coefficient is not 0 that the framework leaves out of its matrices");
}

void check_branches(const NormalEstimator& normal, const Geometry& geometry, Checks& checks) {
  const std::vector<std::string> branches = normal.branches();
  if (branches.empty()) return;
  constexpr std::uint8_t unwritten = 0xFF;
  for (const Pair ij : kPairs)
    for (Index first = 0; first < geometry.size(); first += kBlock) {
      const Index size = std::min(kBlock, geometry.size() - first);
      std::vector<std::uint8_t> out(static_cast<std::size_t>(size), unwritten);
      normal.branch(geometry.block(first, size), ij, out);
      for (const std::uint8_t branch : out)
        checks.holds("names a branch for every sample", branch < branches.size(),
                     fmt::format("found branch {}, expected one of {}", branch, branches.size()));
    }
}

/// Largest |n(mirror image) − mirror image of n|: a reflection turns normals round (a
/// pseudovector).
double mirror_error(const NormalEstimator& normal, const SampleSet& samples, const NodeVectors& r) {
  NodeVectors reflected = r;
  reflected.col(2) *= -1;
  Geometry here(samples), there(samples);
  here.compute(samples, r);
  there.compute(samples, reflected);
  double worst = 0;
  for (Index first = 0; first < samples.size(); first += kBlock) {
    const Index size = std::min(kBlock, samples.size() - first);
    for (const Pair ij : kPairs) {
      AffineNormal a, b;
      normal.estimate(here.block(first, size), ij, a);
      normal.estimate(there.block(first, size), ij, b);
      for (Index s = 0; s < size; ++s) {
        if (!samples.computable(second(ij), first + s)) continue;
        Vec3 expected = -a.at(s, here.block(first, size), ij);
        expected.z() *= -1;
        worst = std::max(worst, (b.at(s, there.block(first, size), ij) - expected).norm());
      }
    }
  }
  return worst;
}

/// Largest angle to the true normal over samples and pairs with a direction [rad].
double largest_angle(const NormalEstimator& normal, const SampleSet& samples, const Geometry& g,
                     const KnownSurface& known) {
  double worst = 0;
  for (Index first = 0; first < samples.size(); first += kBlock) {
    const GeometryBlock block = g.block(first, std::min(kBlock, samples.size() - first));
    for (const Pair ij : kPairs) {
      AffineNormal estimate;
      normal.estimate(block, ij, estimate);
      for (Index s = 0; s < block.size(); ++s) {
        const auto sample = static_cast<std::size_t>(first + s);
        if (std::abs(block.B(ij)[static_cast<std::size_t>(s)]) <= kFlat) continue;
        const Vec2 a = samples.parameters()[sample];
        worst = std::max(worst, angle(estimate.at(s, block, ij), known.n(a.x(), a.y())));
      }
    }
  }
  return worst;
}

/// A square grid with central differences for the unit square.
Terrain square(int n) {
  return {"",
          Json{{"plugin", "grid"},
               {"nodes", {n, n}},
               {"size", {1.0, 1.0}},
               {"differences", "central"},
               {"border", "one_sided"}},
          true};
}

void report_angles(const Subject& subject, Checks& checks) {
  for (const KnownSurface& known : known_surfaces()) {
    std::array<double, 2> errors{};
    for (std::size_t level = 0; level < errors.size(); ++level) {
      const auto made = subject.make<NormalEstimator>(square(level == 0 ? 17 : 33));
      const auto& a = made.surface->parameters();
      NodeVectors r(a.rows(), 3);
      for (Index i = 0; i < a.rows(); ++i) r.row(i) = known.r(a(i, 0), a(i, 1));
      const SampleSet& samples = made.surface->samples(SampleRole::bending);
      Geometry geometry(samples);
      geometry.compute(samples, r);
      errors[level] =
          largest_angle(*made.object, samples, geometry, known) * 180 / std::numbers::pi;
    }
    checks.report("angle to the normal, " + known.name,
                  fmt::format("{:.3g}° on 17², {:.3g}° on 33² nodes", errors[0], errors[1]));
  }
}

void check_terrain(const Subject& subject, const Terrain& terrain, Checks& checks) {
  const auto made = subject.make<NormalEstimator>(terrain);
  const SampleSet& samples = made.surface->samples(SampleRole::bending);
  const NodeVectors r = disturbed(made.surface->rest(), 0.1).r;
  Geometry geometry(samples);
  geometry.compute(samples, r);
  check_evaluation(checks, evaluation(*made.object, geometry), false, name_of_coefficient);
  check_dependence(*made.object, geometry, checks);
  check_branches(*made.object, geometry, checks);
  checks.report("difference between mirror images", mirror_error(*made.object, samples, r));
}

}  // namespace

void check_normal_contract(const Subject& subject, Checks& checks) {
  for (const Terrain& terrain : terrains(17, 13)) {
    checks.at(terrain.name);
    checks.runs("estimates normals", [&] { check_terrain(subject, terrain, checks); });
  }
  checks.at("");
  checks.runs("estimates normals", [&] { report_angles(subject, checks); });
  for (const Terrain& terrain : terrains(9, 7)) {
    checks.at("bending, " + terrain.name);
    checks.runs("serves an energy term", [&] {
      Simulation simulation = subject.simulation(terrain);
      checks.below(
          "bending with it: f = c − K r where it is lagged",
          lagged_error(simulation.system(), 0, disturbed(simulation.system().rest(), 0.05)), 1e-10);
    });
  }
  check_run(subject, checks);
}

}  // namespace deform
