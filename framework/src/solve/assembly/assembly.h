/// What evaluates a model: its terms, and what is made of them.
#pragma once

#include "solve/assembly/material_damping.h"
#include "solve/assembly/model_terms.h"
#include "solve/assembly/tangent_builder.h"

namespace deform {

class Assembly {
 public:
  /// Both must live as long.
  Assembly(const ModelParts& parts, WorkMeter& meter)
      : terms(parts, meter), tangents(terms), damping(terms, tangents) {}

  ModelTerms terms;
  TangentBuilder tangents;
  MaterialDamping damping;
};

}  // namespace deform
