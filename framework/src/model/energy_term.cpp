#include "deform/model/energy_term.h"

#include "deform/error.h"

namespace deform {

EnergyTerm::~EnergyTerm() = default;
JetTerm::~JetTerm() = default;
TupleTerm::~TupleTerm() = default;

std::vector<Coupling> couplings_among(std::initializer_list<Derivative> derivatives) {
  std::vector<Coupling> all;
  for (const Derivative m : derivatives)
    for (const Derivative n : derivatives) all.emplace_back(channel(m), n);
  return all;
}

void AffineStress::undeclared(Channel m, Derivative n) {
  throw Error(ExitCode::plugin_failed,
              "affine_stress writes the coupling (" + std::to_string(slot(m)) + ", " +
                  std::to_string(slot(n)) + "), which couplings() does not declare");
}

std::vector<Coupling> JetTerm::couplings() const { return {}; }

void JetTerm::affine_stress(const SampleBlock& /*block*/, const AffineStress& /*sigma*/) const {
  throw Error(ExitCode::plugin_failed,
              "the term promises a lagged operator but has no affine_stress");
}

void JetTerm::auxiliary(const SampleBlock& /*block*/, std::span<const Values> /*fields*/) const {
  throw Error(ExitCode::plugin_failed,
              "the term declares auxiliary fields but does not compute them");
}

}  // namespace deform
