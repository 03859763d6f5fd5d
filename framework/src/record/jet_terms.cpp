#include "deform/record/jet_terms.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "not_finite.h"

namespace deform {
namespace {

/// Estimates shorter than this (a unit vector is 1, a curvature some 1/m) are the rounding of
/// second differences, about 1e-16/h², and have no direction.
constexpr double kShortest = 1e-9;

}  // namespace

std::vector<JetTermUse> jet_terms(const System& system) {
  std::vector<JetTermUse> uses;
  const auto& energies = system.energies();
  for (std::size_t number = 0; number < energies.size(); ++number) {
    const auto* term = dynamic_cast<const JetTerm*>(energies[number].object.get());
    if (term == nullptr) continue;
    uses.push_back({number, energies[number].name, term, &system.surface().samples(term->role())});
  }
  return uses;
}

std::vector<JetTermUse> terms_with_normal(const System& system) {
  std::vector<JetTermUse> uses = jet_terms(system);
  std::erase_if(uses, [](const JetTermUse& use) { return use.term->normal() == nullptr; });
  return uses;
}

void estimate_normals(const JetTermUse& use, const Geometry& lagged, const Geometry& now, Pair ij,
                      NodeVectors& normals) {
  const Index m = use.samples->size();
  normals.setZero(m, 3);
  for (Index first = 0; first < m; first += kBlock) {
    const Index size = std::min(kBlock, m - first);
    AffineNormal estimate;
    use.term->normal()->estimate(lagged.block(first, size), ij, estimate);
    const GeometryBlock jets = now.block(first, size);
    for (Index i = 0; i < size; ++i) {
      if (!use.samples->computable(second(ij), first + i)) continue;
      normals.row(first + i) = estimate.at(i, jets, ij);
    }
  }
  if (const Index s = first_not_finite(normals); s >= 0)
    throw NotFinite("a normal that the estimator of '" + use.name + "' gives is not finite",
                    use.samples->stencil(s).nodes.front(), use.name);
}

double angle_between(const Vec3& estimate, const Vec3& other) {
  if (estimate.norm() < kShortest || other.norm() < kShortest)
    return std::numeric_limits<double>::quiet_NaN();
  // Well-conditioned at any angle, unlike acos.
  return std::atan2(estimate.cross(other).norm(), estimate.dot(other));
}

void Angles::add(double angle, double weight) {
  if (std::isnan(angle)) return;
  sum_ += weight * angle;
  weight_ += weight;
  max_ = std::max(max_, angle);
}

}  // namespace deform
