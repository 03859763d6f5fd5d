#include "deform/solve/implicit_stage.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "deform/log.h"

#include "solve/contact_multipliers.h"
#include "solve/not_finite.h"

namespace deform {
namespace {

/// A line search halves its step this often.
constexpr int kMostCuts = 30;
/// Armijo's condition: a step is taken where the potential falls by this part of what its slope
/// promised (Nocedal & Wright, chapter 3).
constexpr double kArmijo = 1e-4;
/// Whole Newton steps before a line search is tried.
constexpr std::int64_t kMostLeaps = 12;
/// How often a step that helped is doubled as long as it helps more.
constexpr int kMostDoublings = 6;
/// What a sum of energies may be wrong by, relative.
constexpr double kRoundingOfEnergy = 1e-13;
/// A Newton step below this part of the size moves nothing: what is left over is the rounding of
/// forces, of which some are far larger than all that is at work.
constexpr double kRoundingOfPositions = 1e-13;
/// Forces that cancel to this part of what they are made of count as balanced where no step helps.
constexpr double kRoundingOfForces = 1e-6;

/// Has strains measured as a stage wants them while it lives, however the stage ends.
class StrainsOfAStage {
 public:
  StrainsOfAStage(System& system, const Stage& s) : system_(system) {
    if (s.by_strains) system_.measure_strains_from(1 / s.tau, s.start, s.s, s.earlier);
  }
  ~StrainsOfAStage() { system_.measure_strains_from(0, {}); }
  StrainsOfAStage(const StrainsOfAStage&) = delete;
  StrainsOfAStage& operator=(const StrainsOfAStage&) = delete;

 private:
  System& system_;
};

}  // namespace

struct ImplicitStage::Impl {
  explicit Impl(StageSettings s) : settings(s) {}

  void begin(System& system, const Stage& stage);
  void choose_guess(System& system, State& state);
  void set_velocity(State& state) const;
  [[nodiscard]] double merit(System& system, State& state);
  [[nodiscard]] double incremental_potential(System& system, const State& state);
  void evaluate(System& system, State& state, Tangent kind);
  [[nodiscard]] double residual(System& system, const State& state);
  [[nodiscard]] std::string iterate(System& system, State& state);
  [[nodiscard]] bool leap(System& system, State& state);
  [[nodiscard]] bool is_converged(System& system, State& state, double norm);
  [[nodiscard]] std::string find_direction(System& system, State& state);
  [[nodiscard]] bool search(System& system, State& state, double norm);
  [[nodiscard]] double report(System& system, double norm);

  StageSettings settings;
  ContactMultipliers contacts;
  bool has_potential = true;  // of all energies
  bool has_beside = false;    // forces without one

  const Stage* stage = nullptr;
  double size = 0;
  bool with_contacts = false, contacts_begun = false;
  Tangent kind = Tangent::exact;
  bool projects_next = false;  // the exact tangent's direction did not help
  NodeValues mass, damping;    // M/τ², Γ/τ [N/m]
  NodeValues diagonal;         // their sum
  NodeVectors inertial;        // r_base + τ v_base
  NodeVectors beside;          // force without a potential, kept within a search
  NodeVectors searched_from;
  NodeVectors left, direction;
  NodeVectors before;  // positions before the last leap
  double scale = 0;    // of the forces at work
};

void ImplicitStage::Impl::begin(System& system, const Stage& s) {
  stage = &s;
  has_potential = std::ranges::all_of(system.energies(),
                                      [](const auto& e) { return e.object->traits().potential; });
  has_beside = system.has_force_beside_potential();
  with_contacts = has_potential && system.colliders() > 0;
  contacts_begun = false;
  const auto& rest = system.rest();
  size = (rest.colwise().maxCoeff() - rest.colwise().minCoeff()).maxCoeff();
  mass = system.mass() / (s.tau * s.tau);
  damping = system.damping() / s.tau;
  diagonal = mass + damping;
  inertial = s.r_base + s.tau * s.v_base;
  beside.setZero(system.nodes(), 3);
  searched_from = s.start;
  system.step_report().residuals.clear();
}

void ImplicitStage::Impl::set_velocity(State& state) const {
  state.v = (state.r - stage->r_base) / stage->tau;
  state.time = stage->time;
}

/// The guess, or where the step began, whichever has the smaller merit.
void ImplicitStage::Impl::choose_guess(System& system, State& state) {
  State begin = state;
  for (int c = 0; c < 3; ++c)
    for (Index a = 0; a < begin.r.rows(); ++a)
      if (system.reduction().free(a, c)) begin.r(a, c) = stage->start(a, c);
  system.follow_ties(begin.r);
  const double guessed = merit(system, state), begun = merit(system, begin);
  if (!(guessed <= begun)) state = begin;
  system.step_report().potential_change = has_potential ? -begun : 0;
}

/// Φ, with the force that has no potential as it was where the search began.
double ImplicitStage::Impl::incremental_potential(System& system, const State& state) {
  const NodeVectors from_base = state.r - stage->r_base, from_inertial = state.r - inertial;
  double sum = 0;
  for (int c = 0; c < 3; ++c) {
    sum += 0.5 * mass.dot(from_inertial.col(c).cwiseAbs2());
    sum += 0.5 * damping.dot(from_base.col(c).cwiseAbs2());
  }
  sum += system.potential(state) + system.damping_potential(state);
  if (has_beside) sum -= beside.cwiseProduct(state.r - searched_from).sum();
  if (contacts_begun) {
    contacts.find(system, *stage, state.r);
    sum += contacts.potential();
  }
  return sum;
}

/// What a search makes smaller; infinite where it cannot be evaluated.
double ImplicitStage::Impl::merit(System& system, State& state) {
  set_velocity(state);
  try {
    if (has_potential) return incremental_potential(system, state);
    system.evaluate(state);
    return residual(system, state);
  } catch (const NotFinite&) {
    return kInfinity;
  }
}

void ImplicitStage::Impl::evaluate(System& system, State& state, Tangent of) {
  set_velocity(state);
  if (!has_potential) return system.evaluate(state);
  system.evaluate_with_tangent(state, of, of == Tangent::foreseen ? &before : nullptr,
                               1 / stage->tau);
  if (has_beside) {
    beside = system.force_beside_potential(state);
    searched_from = state.r;
  }
}

/// |Tᵀ(f − M (v − v_base)/τ − Γ v)| at the state of the last evaluation.
double ImplicitStage::Impl::residual(System& system, const State& state) {
  left = -(mass.asDiagonal() * (state.r - inertial));
  const NodeVectors damped = -(damping.asDiagonal() * (state.r - stage->r_base));
  scale = std::max({left.norm(), damped.norm(), system.force().norm()});
  left += damped + system.force();
  if (contacts_begun) contacts.add_force(left);
  system.reduce_force(left);
  return left.norm();
}

double ImplicitStage::Impl::report(System& system, double norm) {
  StepReport& report = system.step_report();
  report.residual = scale > 0 ? norm / scale : 0;
  report.residuals.push_back(report.residual);
  return report.residual;
}

/// Newton's direction; "" or why there is none. Φ falls along it.
std::string ImplicitStage::Impl::find_direction(System& system, State& state) {
  if (!has_potential) {
    system.evaluate_with_jacobian(state, 1 / stage->tau);
    std::string reason = system.factor_jacobian(diagonal);
    if (reason.empty()) system.solve_jacobian(left, direction);
    return reason;
  }
  std::string reason = system.factor_tangent(diagonal);
  if (!reason.empty() && kind == Tangent::exact) {
    kind = Tangent::projected;
    evaluate(system, state, kind);
    if (contacts_begun) contacts.add_tangent(system);
    reason = system.factor_tangent(diagonal);
  }
  if (reason.empty()) system.solve_tangent(left, direction);
  return reason;
}

/// Goes along the direction as far as the merit falls; false where it does not.
bool ImplicitStage::Impl::search(System& system, State& state, double norm) {
  const double begun = has_potential ? merit(system, state) : norm;
  const double slope = has_potential ? -left.cwiseProduct(direction).sum() : -norm;
  const double rounding = kRoundingOfEnergy * std::abs(begun);
  const double longest = direction.rowwise().norm().maxCoeff();
  const NodeVectors from = state.r;
  double s = std::min(1.0, size / std::max(longest, 1e-300));
  for (int cut = 0; cut < kMostCuts; ++cut, s /= 2) {
    state.r = from + s * direction;
    double there = merit(system, state);
    if (!(there <= begun + kArmijo * s * slope + rounding)) continue;
    // The projected tangent is stiffer than the surface, most so where it buckles.
    for (int k = 0; kind == Tangent::projected && cut == 0 && k < kMostDoublings; ++k) {
      state.r = from + 2 * s * direction;
      const double farther = merit(system, state);
      if (!(farther < there)) break;
      there = farther, s *= 2;
    }
    state.r = from + s * direction;
    return true;
  }
  // Close to the end Φ changes by less than its rounding, and where a surface's frame is mixed a
  // force is not quite its gradient: the residual goes on.
  state.r = from + direction;
  set_velocity(state);
  system.evaluate(state);
  if (contacts_begun) contacts.find(system, *stage, state.r);
  if (residual(system, state) < 0.5 * norm) return true;
  state.r = from;
  return false;
}

/// Whether the last evaluation's residual is small enough, contact forces being what they must.
bool ImplicitStage::Impl::is_converged(System& system, State& state, double norm) {
  if (!(norm <= settings.tolerance * scale)) return false;
  if (!with_contacts) return true;
  contacts.update();
  contacts.find(system, *stage, state.r);
  return residual(system, state) <= settings.tolerance * scale;
}

/// Whole Newton steps, with the stress that the last one foresaw in their tangent: they turn parts
/// of the surface by large angles without paying for how a straight step stretches them. True where
/// they end in a solution whose Φ is not above the guess'; else `state` is where they came to.
bool ImplicitStage::Impl::leap(System& system, State& state) {
  const double begun = merit(system, state);
  for (std::int64_t i = 0;; ++i) {
    kind = i == 0 ? Tangent::exact : Tangent::foreseen;
    evaluate(system, state, kind);
    const double norm = residual(system, state);
    (void)report(system, norm);
    if (norm <= settings.tolerance * scale)
      return merit(system, state) <= begun + kRoundingOfEnergy * std::abs(begun);
    if (i == std::min(kMostLeaps, settings.iterations) || !std::isfinite(norm)) return false;
    ++system.step_report().iterations;
    if (!system.factor_tangent(diagonal).empty()) return false;
    system.solve_tangent(left, direction);
    const double longest = direction.rowwise().norm().maxCoeff();
    if (!(longest <= size)) return false;
    before = state.r;
    state.r += direction;
    if (longest <= kRoundingOfPositions * size) return true;
  }
}

std::string ImplicitStage::Impl::iterate(System& system, State& state) {
  if (has_potential && !with_contacts) {
    State leapt = state;
    bool is_there = false;
    try {
      is_there = leap(system, leapt);
    } catch (const NotFinite&) {
      leapt = state;  // it leapt too far; a search takes care
    }
    // What was won by the way is kept.
    if (is_there || merit(system, leapt) < merit(system, state)) state = leapt;
    if (is_there) return "";
  }
  double longest = kInfinity;  // of the last direction
  for (std::int64_t i = 0;; ++i) {
    kind = projects_next ? Tangent::projected : Tangent::exact;
    projects_next = false;
    evaluate(system, state, kind);
    if (with_contacts) {
      if (!contacts_begun) {
        contacts.begin(system, diagonal + system.mean_stiffness());
        contacts_begun = true;
      }
      contacts.find(system, *stage, state.r);
      contacts.add_tangent(system);
    }
    const double norm = residual(system, state);
    const double relative = report(system, norm);
    if (is_converged(system, state, norm)) return "";
    if (longest <= kRoundingOfPositions * size) return "";
    if (i == settings.iterations || !std::isfinite(norm))
      return fmt::format("{} iterations leave a residual of {:.3g}", i, relative);
    ++system.step_report().iterations;

    const std::string reason = find_direction(system, state);
    if (!reason.empty()) return "no direction of descent (" + reason + ")";
    longest = direction.rowwise().norm().maxCoeff();
    if (longest <= kRoundingOfPositions * size) return "";
    if (search(system, state, norm)) continue;
    if (relative <= kRoundingOfForces) return "";
    if (kind == Tangent::projected || !has_potential)
      return fmt::format("no step along Newton's direction helps (residual {:.3g})", relative);
    projects_next = true;
  }
}

ImplicitStage::ImplicitStage(StageSettings settings) : impl_(std::make_unique<Impl>(settings)) {}
ImplicitStage::~ImplicitStage() = default;

std::string ImplicitStage::solve(System& system, const Stage& stage, State& state) {
  Impl& s = *impl_;
  const StrainsOfAStage strains(system, stage);
  s.begin(system, stage);
  s.choose_guess(system, state);
  std::string reason = s.iterate(system, state);
  if (reason.empty() && s.has_potential)
    system.step_report().potential_change += s.merit(system, state);
  // Without a potential of all forces Φ is another function at each search.
  if (s.has_beside) system.step_report().potential_change = std::nan("");
  if (!reason.empty()) return reason;
  s.set_velocity(state);
  return "";
}

std::vector<Touch> ImplicitStage::touching() const { return impl_->contacts.touching(); }
bool ImplicitStage::resolves_contacts() const { return impl_->has_potential; }
void ImplicitStage::save(Memory& memory) const { impl_->contacts.save(memory); }
void ImplicitStage::load(const Memory& memory) { impl_->contacts.load(memory); }
void ImplicitStage::forget() { impl_->contacts.forget(); }

}  // namespace deform
