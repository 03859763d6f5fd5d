#include "simulation/masses.h"

#include <fmt/format.h>

#include "deform/error.h"
#include "deform/log.h"

#include "not_finite.h"
#include "plugin/guard.h"

namespace deform {
namespace {

constexpr const char* kDensity = "/material/density";

/// Two materials' masses that agree to this are the same.
constexpr double kSame = 1e-9;

std::string shown(const NodeValues& mass) {
  const double least = mass.minCoeff(), most = mass.maxCoeff();
  return most - least <= kSame * most ? fmt::format("{:.4g} kg/m²", least)
                                      : fmt::format("{:.4g} to {:.4g} kg/m²", least, most);
}

void check_mass(const Named<EnergyTerm>& energy, const NodeValues& mass, Index nodes) {
  if (mass.size() == nodes && first_not_finite(mass) < 0 && mass.minCoeff() > 0) return;
  throw PluginFailure(fmt::format(
      "plugin {} gives mass_per_area() of {} nodes, expected a finite one above 0 for each of {}",
      energy.origin, mass.size(), nodes));
}

}  // namespace

NodeValues densities(const Scene& scene, Index nodes,
                     const std::vector<Named<EnergyTerm>>& energies, PartMaker& maker, bool tells) {
  const NodeValues said = NodeValues::Constant(nodes, scene.material.density);
  if (scene.density_is_given) return said;
  const Named<EnergyTerm>* first = nullptr;
  NodeValues mass;
  for (const Named<EnergyTerm>& energy : energies) {
    const NodeValues own =
        guarded(energy.origin, "saying its mass", [&] { return energy.object->mass_per_area(); });
    if (own.size() == 0) continue;
    check_mass(energy, own, nodes);
    if (first == nullptr) {
      first = &energy;
      mass = own;
    } else if ((own - mass).cwiseAbs().maxCoeff() > kSame * mass.maxCoeff()) {
      maker.add(
          {{kDensity, fmt::format("at {}: is missing: the material of {} weighs {}, that of "
                                  "{} {}; say what the surface weighs",
                                  kDensity, first->name, shown(mass), energy.name, shown(own))}});
    }
  }
  if (first == nullptr) return said;
  if (tells) log::info(fmt::format("mass: {}, of the material of {}", shown(mass), first->name));
  return mass;
}

void check_areas(const Scene& scene, const NodeValues& areas, PartMaker& maker) {
  const Index infinite = first_not_finite(areas);
  Index smallest = 0;
  if (infinite < 0 && areas.minCoeff(&smallest) > 0) return;
  const std::string why =
      infinite >= 0
          ? fmt::format("has an area around node {} that no number holds: a smaller one", infinite)
          : fmt::format(
                "has no area around node {}, which would have no mass: another shape, or "
                "the material's \"mass\": \"parameters\"",
                smallest);
  const auto& parameters = scene.surface().parameters;
  const bool has_shape = parameters && parameters->has("rest");
  const std::string pointer = has_shape ? "/surface/rest" : "/surface";
  maker.add({{pointer, fmt::format("at {}: the rest surface {}", pointer, why)}});
}

}  // namespace deform
