#include "simulation/compound_terms.h"

#include <utility>

#include "plugin/guard.h"

namespace deform {
namespace {

/// Destroyed in reverse: the part before the compound, whose library has its code.
struct Holder {
  std::shared_ptr<EnergyTerm> compound, part;
};

std::shared_ptr<EnergyTerm> kept(const std::shared_ptr<EnergyTerm>& compound,
                                 std::shared_ptr<EnergyTerm> part) {
  EnergyTerm* term = part.get();
  auto holder = std::make_shared<Holder>(Holder{compound, std::move(part)});
  return {std::move(holder), term};
}

}  // namespace

void take_apart_compounds(std::vector<Named<EnergyTerm>>& energies,
                          std::vector<double>& retardation) {
  std::vector<Named<EnergyTerm>> others;
  for (std::size_t e = 0; e < energies.size(); ++e) {
    Named<EnergyTerm>& energy = energies[e];
    const auto* compound = dynamic_cast<const CompoundTerm*>(energy.object.get());
    if (compound == nullptr) continue;
    const Named<EnergyTerm> whole = energy;
    const std::vector<CompoundTerm::Part> parts =
        guarded(whole.origin, "naming its parts", [&] { return compound->parts(); });
    if (parts.empty()) throw PluginFailure("plugin " + whole.origin + " is a sum of no terms");
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (!parts[i].term || dynamic_cast<const CompoundTerm*>(parts[i].term.get()) != nullptr)
        throw PluginFailure("plugin " + whole.origin + ": its part '" + parts[i].name +
                            "' is no term, or a sum itself");
      Named<EnergyTerm> part{whole.name + "_" + parts[i].name, whole.origin,
                             kept(whole.object, parts[i].term)};
      if (i == 0) {
        energy = std::move(part);
      } else {
        others.push_back(std::move(part));
        retardation.push_back(retardation[e]);
      }
    }
  }
  energies.insert(energies.end(), others.begin(), others.end());
}

}  // namespace deform
