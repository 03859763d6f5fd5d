#include "deform/solve/implicit_stage.h"

#include <cmath>

#include "deform/error.h"

#include "profile/profile.h"
#include "solve/newton/contraction.h"
#include "solve/newton/stage_objective.h"

namespace deform {

struct ImplicitStage::Impl {
  explicit Impl(StageSettings s) : settings(s) {}

  [[nodiscard]] NewtonSettings newton_settings() const;
  void measure_strains(const System& system, const Stage& stage);
  [[nodiscard]] bool contract(System& system, State& state);
  [[nodiscard]] double choose_guess(System& system, const Stage& stage, State& state);
  [[nodiscard]] std::string minimise(System& system, const Stage& stage, State& state);

  StageSettings settings;
  StepStrains strains;
  StageObjective objective;
  Contraction contraction;
  std::optional<Newton> newton;  // of the system …
  std::optional<Path> path;      // likewise, of contractions
  const System* of = nullptr;    // … that the last stage was of
  State begin;                   // of a step, as a guess
};

NewtonSettings ImplicitStage::Impl::newton_settings() const {
  return {.tolerance = settings.tolerance,
          .iterations = settings.iterations,
          .error = settings.newton_error * objective.characteristic_length()};
}

/// As the stage wants them.
void ImplicitStage::Impl::measure_strains(const System& system, const Stage& stage) {
  strains.reset();
  const Evaluator& evaluator = system.evaluator();
  if (stage.by_strains)
    strains.measure_rates_from(evaluator, 1 / stage.tau, stage.start, stage.s, stage.earlier);
  if (stage.averages_strains) strains.average_from(evaluator, stage.start);
}

/// Without a look at Φ, where that may do.
bool ImplicitStage::Impl::contract(System& system, State& state) {
  const bool by_corrections = settings.newton_error > 0 || objective.error_allowed(state) > 0;
  if (!by_corrections || system.contact().bodies() > 0) return false;
  objective.begin_path(state);
  if (!contraction.solve(objective, newton_settings(), *path, state, system.step_report()))
    return false;
  system.step_report().potential_change = std::nan("");  // Φ was not looked at
  return true;
}

/// The guess, or where the step began, whichever has the smaller merit, which it returns.
double ImplicitStage::Impl::choose_guess(System& system, const Stage& stage, State& state) {
  const Span span("guess");
  begin = state;
  const ConstraintSet& constraints = system.constraints();
  for (int c = 0; c < 3; ++c)
    for (Index a = 0; a < begin.r.rows(); ++a)
      if (constraints.reduction().free(a, c)) begin.r(a, c) = stage.start(a, c);
  constraints.follow_ties(begin.r);
  objective.confine(begin);
  objective.confine(state);
  objective.begin_path(begin);
  const double at_begin = objective.merit(begin), guessed = objective.merit(state);
  if (!(guessed <= at_begin)) state = begin;
  objective.begin_contact(state);
  system.step_report().potential_change = objective.has_potential() ? -at_begin : 0;
  objective.begin_path(state);
  return objective.merit(state);
}

std::string ImplicitStage::Impl::minimise(System& system, const Stage& stage, State& state) {
  const double merit = choose_guess(system, stage, state);
  StepReport& report = system.step_report();
  std::string reason = newton->solve(objective, newton_settings(), merit, state, report);
  if (!reason.empty()) return reason;
  if (objective.has_potential()) report.potential_change += objective.merit(state);
  // Without a potential of all forces Φ is another function along each path.
  if (objective.has_potential() && !objective.is_gradient()) report.potential_change = std::nan("");
  return "";
}

ImplicitStage::ImplicitStage(StageSettings settings) : impl_(std::make_unique<Impl>(settings)) {}
ImplicitStage::~ImplicitStage() = default;

std::string ImplicitStage::solve(System& system, const Stage& stage, State& state) {
  const Span span("stage");
  Impl& s = *impl_;
  if (s.of != &system) s.newton.emplace(system), s.path.emplace(system);
  s.of = &system;
  s.measure_strains(system, stage);
  s.objective.begin(system, stage, s.strains);
  const NewtonSettings limits = s.newton_settings();
  s.objective.set_limits(limits.tolerance, limits.error, s.settings.newton_share);
  s.contraction.begin_stage(stage.tau);
  const bool contracts = s.contract(system, state);
  const std::string reason = contracts ? "" : s.minimise(system, stage, state);
  system.step_report().solver_iterations += s.objective.solver_iterations();
  system.step_report().with_jacobian += s.objective.completed_directions();
  if (!reason.empty()) return reason;
  s.objective.set_velocity(state);
  if (s.objective.has_contacts()) s.objective.contacts().forget_impacts(stage, system.mass());
  return "";
}

std::vector<Index> ImplicitStage::active_contacts() const {
  return impl_->objective.contacts().active_nodes();
}
std::vector<ContactImpulse> ImplicitStage::impulses(const System& system,
                                                    const Stage& stage) const {
  if (!impl_->objective.has_contacts()) return {};
  return impl_->objective.contacts().impulses(stage, system.mass());
}
void ImplicitStage::set_limits(double tolerance, double newton_error) {
  impl_->settings.tolerance = tolerance;
  impl_->settings.newton_error = newton_error;
}
std::vector<ContactImpulse> ImplicitStage::settle(const System& system, const Stage& stage,
                                                  const State& before, double step,
                                                  State& end) const {
  std::vector<ContactImpulse> impulses = this->impulses(system, stage);
  if (impl_->objective.has_contacts()) system.contact().settle(before, step, impulses, end);
  return impulses;
}
bool ImplicitStage::counts_corrections() const {
  return impl_->settings.newton_error > 0 || impl_->settings.newton_share > 0;
}
bool ImplicitStage::resolves_contacts() const { return impl_->objective.has_potential(); }
void ImplicitStage::save(Memory& memory) const {
  impl_->objective.contacts().save(memory);
  if (counts_corrections()) impl_->contraction.save(memory);
}
void ImplicitStage::load(const Memory& memory) {
  impl_->objective.contacts().load(memory);
  if (counts_corrections()) impl_->contraction.load(memory);
}
void ImplicitStage::forget() {
  impl_->objective.contacts().forget();
  impl_->contraction.forget();
}

}  // namespace deform
