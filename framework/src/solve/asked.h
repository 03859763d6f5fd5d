/// What terms and integrators say of themselves, asked so that one that fails is named.
#pragma once

#include <algorithm>
#include <utility>

#include "deform/solve/integrator.h"
#include "deform/solve/system.h"

#include "plugin/guard.h"

namespace deform {

/// Calls ask(object); throws PluginFailure where it fails.
template <class Interface, class Ask>
[[nodiscard]] auto asked(const Named<Interface>& plugin, Ask&& ask) {
  return guarded(plugin.origin, "saying what it is",
                 [&] { return std::forward<Ask>(ask)(std::as_const(*plugin.object)); });
}

[[nodiscard]] inline bool has_potential(const Named<EnergyTerm>& term) {
  return asked(term, [](const EnergyTerm& t) { return t.traits().potential; });
}

/// Whether all terms have one.
[[nodiscard]] inline bool have_potential(const System& system) {
  return system.evaluator().energies_have_potential();
}

[[nodiscard]] inline bool is_static(const Named<Integrator>& integrator) {
  return asked(integrator, [](const Integrator& i) { return i.is_static(); });
}

}  // namespace deform
