/// One contract a kind of plugin; each adds what it finds to the checks.
#pragma once

#include <functional>

#include "check/subject.h"

namespace deform {

/// check_energy_contract and so on; a kind without one does not link.
#define DEFORM_CONTRACT(name, plural, Interface) \
  void check_##name##_contract(const Subject& subject, Checks& checks);
DEFORM_PLUGIN_KINDS(DEFORM_CONTRACT)
#undef DEFORM_CONTRACT

/// For all that take part in steps: a run is the same on any number of threads, and the same when
/// it is saved half-way and goes on in fresh objects. On those terrains where `suits` says that the
/// integrator can make a run.
void check_run(
    const Subject& subject, Checks& checks,
    const std::function<bool(const Terrain&)>& suits = [](const Terrain&) { return true; });

/// Of what may depend on time: the times at which it is not smooth ascend.
void check_breaks(const Plugin& part, Checks& checks);

}  // namespace deform
