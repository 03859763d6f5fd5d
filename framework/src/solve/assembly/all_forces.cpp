#include "solve/assembly/all_forces.h"

#include "solve/stopwatch.h"

namespace deform {

std::shared_ptr<const StateGeometry> sum_all_forces(Assembly& assembly, const State& state,
                                                    Strains* strains, JetAssembler::Part part,
                                                    NodeVectors& f) {
  ModelTerms& terms = assembly.terms;
  terms.meter().require_going_on();
  const Stopwatch watch(&StepTimes::assembly, "geometry, stress and force");
  auto now = terms.evaluate(state.r, strains, part);
  terms.evaluate_tuples(state.r, strains);
  f.setZero(state.r.rows(), 3);
  terms.add_internal_force(f);
  terms.external().add_force(state, now->normals, f);
  assembly.damping.add_force(state, *now, strains, f);
  return now;
}

}  // namespace deform
