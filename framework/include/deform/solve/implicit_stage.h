/// The nonlinear equation that implicit methods for (16) have in common, and its solution by
/// Newton's method.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "deform/export.h"
#include "deform/solve/system.h"

namespace deform {

/// M (v − v_base)/τ = f(r, v, t) − Γ v with v = (r − r_base)/τ, for r. Backward differences have
/// τ = h (first order) or 2h/3 (second order); the midpoint rule has τ = h/2.
///
/// Where all forces have a potential Π, solutions are stationary points of the incremental
/// potential
///   Φ(r) = ‖r − r_base − τ v_base‖²_M/(2τ²) + ‖r − r_base‖²_Γ/(2τ) + Π(r, t).
struct Stage {
  NodeVectors r_base;  ///< (N × 3) [m]
  NodeVectors v_base;  ///< (N × 3) [m/s]
  double tau = 0;      ///< [s]
  double time = 0;     ///< of the stage [s]
  /// Where the step began (N × 3) [m], when it did, and when it ends [s], at start + reach (r −
  /// start): there colliders are felt, and what slid along them since the start is resisted by
  /// friction.
  NodeVectors start;
  double begin = 0;
  double end = 0;
  double reach = 1;
  /// How materials' damping takes strain rates: as (T − T_b)/τ with T_b = (1 − s) T(start) +
  /// s T(earlier), so that a turn by a large angle is no strain; or, `by_strains` false, as those
  /// of v at r.
  bool by_strains = false;
  /// Whether energies are of the mean strains of a step from `start`, of which the stage is the
  /// middle (StepStrains::average_from).
  bool averages_strains = false;
  double s = 0;
  NodeVectors earlier{};
  /// Where the step would end if it went on as before (N × 3) [m], and the error of the time
  /// stepping in r by its difference from that; 0: unknown.
  NodeVectors prediction{};
  double error_per_change = 0;
};

/// How a stage is solved.
struct StageSettings {
  double tolerance = 1e-6;       ///< of the residual, relative to the forces at work
  std::int64_t iterations = 50;  ///< of Newton's method, at most
  /// Error that Newton's method may leave, root mean square over the mass, in characteristic
  /// lengths: where its corrections shrink fast, two or three are enough; 0: `tolerance` alone
  /// decides.
  double newton_error = 0;
  /// Likewise as a part of the error of the time stepping itself, where the integrator knows that
  /// (Stage::error_per_change).
  double newton_share = 0;
};

/// Solves stages one after another; remembers what the next may profit from.
///
/// Energies with a potential: Newton's method (Newton) on Φ, with the exact tangent while that is
/// positive definite, else the projected one, along paths that rotate parts of the surface by
/// finite angles (Path). Forces without a potential (drag, damping of materials, followers) count
/// by their work along the path, with the symmetric part of their tangent; close to a solution with
/// the Jacobian of all forces, by a Krylov method that has that tangent for a preconditioner (Knoll
/// & Keyes 2004). Colliders are constraints that
/// every iterate keeps, with reactions; friction (Coulomb's law, sticking included) is by
/// multipliers that are updated until they hold.
///
/// Where an error may be left, and without colliders, it first tries to do without Φ, by
/// corrections alone that contract; the search with Φ may end so, too, where that falls.
///
/// Some energy without a potential: Newton's method on the force, likewise, searching for a smaller
/// residual; where the Krylov method does not help, with its Jacobian by coloured differences.
/// Colliders amend the step's end.
class DEFORM_API ImplicitStage {
 public:
  explicit ImplicitStage(StageSettings settings);
  ~ImplicitStage();
  ImplicitStage(const ImplicitStage&) = delete;
  ImplicitStage& operator=(const ImplicitStage&) = delete;

  /// `state.r`: prescribed components where they are at the stage, the others a guess. Makes
  /// `state` the solution (r, v, time) and returns "", or says why there is none; `state` is then
  /// of no use. Throws NotFinite and what plugins throw. Adds to the system's step report.
  [[nodiscard]] std::string solve(System& system, const Stage& stage, State& state);

  /// Whether a better guess than r + h v is worth while: corrections end Newton's method.
  [[nodiscard]] bool counts_corrections() const;

  /// Nodes in active contact in the last solution, ascending; one that two colliders push is there
  /// twice.
  [[nodiscard]] std::vector<Index> active_contacts() const;
  /// Makes velocities at the end of a step of so many seconds, which began with `before` and whose
  /// stage was solved, those that contact leaves: as formulas of several points in time have them,
  /// what was stopped within the step would go on, or back. Returns contact's impulses in the step,
  /// for its report.
  [[nodiscard]] std::vector<ContactImpulse> settle(const System& system, const Stage& stage,
                                                   const State& before, double step,
                                                   State& end) const;
  /// False where colliders are left to ColliderContact::resolve.
  [[nodiscard]] bool resolves_contacts() const;

  /// Contact's impulses on velocities within the stage that was solved.
  [[nodiscard]] std::vector<ContactImpulse> impulses(const System& system,
                                                     const Stage& stage) const;
  /// From now on (StageSettings::tolerance, newton_error).
  void set_limits(double tolerance, double newton_error);

  /// Contact forces that the next solution starts from.
  void save(Memory& memory) const;
  void load(const Memory& memory);
  /// As if there had been no solution yet.
  void forget();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace deform
