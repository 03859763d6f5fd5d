/// How strains and their rates are taken within an implicit step.
#pragma once

#include <memory>

#include "deform/export.h"
#include "deform/types.h"

namespace deform {

class Evaluator;

/// By default strains are those of the state that is evaluated, and their rates follow from its v.
/// Implicit methods want other ones: this says which, and keeps the geometry that it takes. An
/// argument of whatever evaluates, of one Evaluator only.
class DEFORM_API StepStrains {
 public:
  StepStrains();
  ~StepStrains();
  StepStrains(StepStrains&&) noexcept;
  StepStrains& operator=(StepStrains&&) noexcept;

  /// Strains and rates of the state alone.
  void reset();

  /// Damping of materials whose energy knows strains (TermTraits::strains) takes the rates
  /// (T − T_b)·rate, T_b = (1 − s) T(r) + s T(earlier), T = G, B, in place of those of v: for
  /// methods whose velocity is a difference over a step, in which a rotation by a large angle would
  /// count as a strain. Such damping is the gradient of Evaluator::damping_potential. `rate` > 0
  /// [1/s]; r, earlier (N × 3) [m].
  void measure_rates_from(const Evaluator& of, double rate, const NodeVectors& r, double s = 0,
                          const NodeVectors& earlier = {});

  /// States are the middle of a step from r (N × 3) to 2 r_state − r, and energies that know
  /// strains, or live on tuples of nodes, are those of the mean of the strains at both ends, their
  /// forces those that conserve energy and momenta over the step (Geometry::make_mean; Simo &
  /// Tarnow 1992). These forces are no gradient: what is not one of the mean strains' energy is
  /// part of Evaluator::nonconservative_force; tangents are symmetric and exact but for the
  /// rotation within a step.
  void average_from(const Evaluator& of, const NodeVectors& r);

  struct Impl;
  /// What the framework reads.
  [[nodiscard]] Impl& impl() const { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace deform
