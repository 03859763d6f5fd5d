#include "deform/model/energy_term.h"

#include <algorithm>

#include "deform/error.h"

namespace deform {

EnergyTerm::~EnergyTerm() = default;
JetTerm::~JetTerm() = default;
TupleTerm::~TupleTerm() = default;
std::vector<ScalarUnknown> TupleTerm::scalars() const { return {}; }
CompoundTerm::~CompoundTerm() = default;

std::vector<Coupling> couplings_among(std::initializer_list<Derivative> derivatives) {
  std::vector<Coupling> all;
  for (const Derivative m : derivatives)
    for (const Derivative n : derivatives) all.emplace_back(channel(m), n);
  return all;
}

void add_weighted_norm(double factor, const PairWeights& weights, const SampleBlock& block,
                       ConstValues (GeometryBlock::*tensor)(Pair) const, Values density) {
  for (const Pair ij : kPairs) {
    const ConstValues now = (block.now.*tensor)(ij), rest = (block.rest.*tensor)(ij);
    const double w = factor * multiplicity(ij) * weights(ij);
    for (std::size_t s = 0; s < density.size(); ++s)
      density[s] += w * (now[s] - rest[s]) * (now[s] - rest[s]);
  }
}

void SampleBlock::difference(Derivative op, int f, Values out) const {
  if (differences == nullptr)
    throw Error(ExitCode::plugin_failed,
                "the term differences a field of samples but does not declare strong_form");
  if (f < 0 || static_cast<std::size_t>(f) >= auxiliary.size())
    throw Error(ExitCode::plugin_failed, "the term differences auxiliary field " +
                                             std::to_string(f) + " but declares " +
                                             std::to_string(auxiliary.size()) + " of them");
  differences->apply(op, auxiliary[static_cast<std::size_t>(f)], first(), out);
}

void AffineStress::undeclared(Channel m) {
  throw Error(ExitCode::plugin_failed, "affine_stress writes channel " + std::to_string(slot(m)) +
                                           " of the strong form, which traits() does not promise");
}

void AffineStress::undeclared(Channel m, Derivative n) {
  throw Error(ExitCode::plugin_failed,
              "affine_stress writes the coupling (" + std::to_string(slot(m)) + ", " +
                  std::to_string(slot(n)) + "), which couplings() does not declare");
}

std::vector<Coupling> JetTerm::couplings() const { return {}; }

std::vector<Derivative> JetTerm::dependence() const {
  return {Derivative::d1, Derivative::d2, Derivative::d11, Derivative::d12, Derivative::d22};
}

Geometry::Detail JetTerm::reads() const {
  const auto is_first = [](Derivative d) { return slot(d) <= slot(Derivative::d2); };
  const TermTraits promised = traits();
  const bool reads_first_alone = promised.potential && !promised.strong_form &&
                                 normal() == nullptr && auxiliary_fields() == 0 &&
                                 std::ranges::all_of(dependence(), is_first);
  return reads_first_alone ? Geometry::Detail::first : Geometry::Detail::second;
}

void JetTerm::affine_stress(const SampleBlock& /*block*/, const AffineStress& /*sigma*/) const {
  throw Error(ExitCode::plugin_failed,
              "the term promises a lagged operator but has no affine_stress");
}

TangentShape JetTerm::tangent_shape(Tangent /*kind*/) const { return TangentShape::blocks; }

void JetTerm::tangent_factors(const SampleBlock& /*block*/, Tangent /*kind*/,
                              const TangentFactors& /*c*/) const {
  throw Error(ExitCode::plugin_failed,
              "the term promises tangents of a special shape but has no tangent_factors");
}

void JetTerm::auxiliary(const SampleBlock& /*block*/, std::span<const Values> /*fields*/) const {
  throw Error(ExitCode::plugin_failed,
              "the term declares auxiliary fields but does not compute them");
}

}  // namespace deform
