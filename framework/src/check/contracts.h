/// One contract a kind of plugin; each adds what it finds to the checks.
#pragma once

#include <functional>

#include "check/subject.h"

namespace deform {

void check_surface_contract(const Subject& subject, Checks& checks);
void check_shape_contract(const Subject& subject, Checks& checks);
void check_normal_contract(const Subject& subject, Checks& checks);
void check_energy_contract(const Subject& subject, Checks& checks);
void check_force_contract(const Subject& subject, Checks& checks);
void check_constraint_contract(const Subject& subject, Checks& checks);
void check_collider_contract(const Subject& subject, Checks& checks);
void check_integrator_contract(const Subject& subject, Checks& checks);
void check_solver_contract(const Subject& subject, Checks& checks);
void check_output_contract(const Subject& subject, Checks& checks);
void check_probe_contract(const Subject& subject, Checks& checks);

/// For all that take part in steps: a run is the same on any number of threads, and the same when
/// it is saved half-way and goes on in fresh objects. On those terrains where `suits` says that the
/// integrator can make a run.
void check_run(
    const Subject& subject, Checks& checks,
    const std::function<bool(const Terrain&)>& suits = [](const Terrain&) { return true; });

/// Of what may depend on time: the times at which it is not smooth ascend.
void check_breaks(const Plugin& part, Checks& checks);

}  // namespace deform
