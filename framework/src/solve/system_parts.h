/// What a System is made of.
#pragma once

#include "deform/solve/collider_contact.h"
#include "deform/solve/constraint_set.h"
#include "deform/solve/evaluator.h"
#include "deform/solve/mass_matrix.h"
#include "deform/solve/model_parts.h"
#include "deform/solve/system.h"
#include "deform/solve/term_evaluator.h"

#include "solve/assembly/assembly.h"
#include "solve/matrix/solver_source.h"
#include "solve/work_meter.h"

namespace deform {

class SystemParts {
 public:
  explicit SystemParts(ModelParts p);
  SystemParts(const SystemParts&) = delete;
  SystemParts& operator=(const SystemParts&) = delete;
  [[nodiscard]] static SystemParts& of(const System& system) { return *system.parts_; }

  ModelParts model;
  WorkMeter meter;
  SolverSource solvers;
  ConstraintSet constraints;
  ColliderContact contact;
  Assembly assembly;
  Evaluator evaluator;
  TermEvaluator terms;
  MassMatrix mass_matrix;
};

}  // namespace deform
