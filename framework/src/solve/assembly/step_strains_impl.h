/// The geometry that strains of a step are measured by.
#pragma once

#include <vector>

#include "deform/geometry/geometry.h"
#include "deform/solve/step_strains.h"

#include "solve/assembly/model_terms.h"

namespace deform {

struct StepStrains::Impl {
  /// Where strains are averaged over a step, of which the middle is a state: its end, and the
  /// means. Results are kept until they are those of another state.
  void update_mean(const StateGeometry& middle);
  void bind(ModelTerms& to_terms);

  ModelTerms* terms = nullptr;
  long version = 0;  // of what is asked for; another one each time, 0: strains of the state

  double rate = 0;                       // [1/s], of strains since …
  std::vector<Geometry> begun, earlier;  // … these, one a set

  bool averages = false;
  NodeVectors from_r, to_r, middle_r;               // of the step: (N × 3)
  std::vector<Geometry> from, to, mean;             // likewise; Geometry::make_mean
  std::vector<std::vector<double>> tuple_energies;  // at from_r, one a tuple of each term [J]
};

[[nodiscard]] inline StepStrains::Impl* impl_of(const StepStrains* strains) {
  return strains == nullptr || strains->impl().version == 0 ? nullptr : &strains->impl();
}
[[nodiscard]] inline bool averages(const StepStrains::Impl* strains) {
  return strains != nullptr && strains->averages;
}
/// Of strains over a step; 0 where rates are those of v.
[[nodiscard]] inline double rate_of(const StepStrains::Impl* strains) {
  return strains == nullptr ? 0 : strains->rate;
}

}  // namespace deform
