/// The discretised equation of motion (16) as an integrator sees it: forces, lagged operator,
/// linear solves.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "deform/export.h"
#include "deform/geometry/geometry.h"
#include "deform/model/collider.h"
#include "deform/model/constraint.h"
#include "deform/model/energy_term.h"
#include "deform/model/force_field.h"
#include "deform/solve/block_matrix.h"
#include "deform/solve/linear_solver.h"
#include "deform/surface/surface.h"
#include "deform/types.h"

namespace deform {

/// Positions [m], velocities [m/s] (both N × 3), and time [s].
struct State {
  NodeVectors r;
  NodeVectors v;
  double time = 0;
};

/// A plugin object with the name it goes by in messages, columns and files ("bending",
/// "bending_2").
template <class Interface>
struct Named {
  std::string name;
  std::string origin;  ///< plugin and file, for messages
  std::shared_ptr<Interface> object;
};

/// A collider with what holds for contact with it.
struct Body {
  Named<Collider> collider;
  double friction = 0;   ///< Coulomb's coefficient
  double thickness = 0;  ///< distance that nodes keep [m]
  std::string pointer;   ///< where the scene says so
};

/// The parts of a model, ready to be assembled into a System.
struct ModelParts {
  std::shared_ptr<const Surface> surface;
  NodeVectors rest;    ///< (N × 3) [m]
  NodeValues areas;    ///< (N) A, that mass and loads per area go by: Setup::areas() [m²]
  NodeValues mass;     ///< (N) mu A [kg]
  NodeValues damping;  ///< (N) (gamma + rayleigh_mass mu) A [N·s/m]
  std::vector<Named<EnergyTerm>> energies;
  /// Retardation time of each energy term's material [s]: its damping force is this times the
  /// Gauss–Newton tangent of the term times −v (Kelvin–Voigt). Empty: none.
  std::vector<double> retardation;
  std::vector<Named<ForceField>> forces;
  std::vector<Named<Constraint>> constraints;
  std::vector<Body> bodies;
  /// Makes a fresh object of each solver to choose from (one, where the scene names it). Components
  /// that different constraints hold need a matrix, and so a solver, each.
  std::function<std::vector<Named<LinearSolver>>()> make_solvers;
};

/// What an iterative integrator's last step took; for logs and probes.
struct StepReport {
  long iterations = 0;            ///< of Newton's method, all substeps together
  long solver_iterations = 0;     ///< of the linear solver, where it is iterative
  long substeps = 1;              ///< of time or of load
  long rejected = 0;              ///< substeps that were tried and given up
  double smallest = 0;            ///< shortest and longest substep [s]; 0 where there is none
  double largest = 0;             ///<
  double residual = 0;            ///< where the last substep ended, relative to the forces at work
  std::vector<double> residuals;  ///< one an iteration of the last substep
  /// Change of the incremental potential over the last substep [J]: never positive; not a number
  /// where some force has no potential.
  double potential_change = 0;
};

/// A node near a collider that can push it: no constraint holds it along the normal.
struct NodeContact {
  Index node = 0;
  std::size_t body = 0;         ///< its number among the scene's colliders
  double gap = 0;               ///< distance less the collider's thickness; negative inside [m]
  Vec3 normal = Vec3::UnitZ();  ///< along which the distance grows
  double friction = 0;          ///< Coulomb's coefficient
  /// n·∂r/∂q (∂r/∂q)ᵀ n with the unknowns q that the node follows: 1 where nothing holds it.
  double mobility = 1;
  /// Whether the node has come through the body, or in on another side than the nearest: the gap is
  /// then to the tangent plane where it came in.
  bool crossed = false;
};

/// Impulse of a collider on a node within a step, per mass [m/s].
struct ContactImpulse {
  Index node = 0;
  std::size_t body = 0;  ///< its number among the scene's colliders
  Vec3 normal = Vec3::UnitZ();
  double push = 0;          ///< along the normal
  Vec3 rub = Vec3::Zero();  ///< of friction
};

/// What a tangent is evaluated for.
enum class TangentUse : std::uint8_t {
  any,
  /// `solve_tangent_to` above all: rows go to a solver that takes them as they are made, and the
  /// matrix is kept nowhere else. Whatever else wants it has it made again.
  directions,
};

/// Seconds spent, by part of a step.
struct StepTimes {
  double geometry = 0, assembly = 0, factorisation = 0, solve = 0, output = 0;
  long steps = 0;
};

/// Everything that an integrator needs of the model. All results have the same bits at any number
/// of threads.
class DEFORM_API System {
 public:
  explicit System(ModelParts parts);
  ~System();
  System(const System&) = delete;
  System& operator=(const System&) = delete;

  [[nodiscard]] Index nodes() const;
  [[nodiscard]] const Surface& surface() const;
  [[nodiscard]] const NodeVectors& rest() const;
  [[nodiscard]] const NodeValues& areas() const;
  [[nodiscard]] const NodeValues& mass() const;
  [[nodiscard]] const NodeValues& damping() const;
  [[nodiscard]] const Reduction& reduction() const;
  [[nodiscard]] const std::vector<Named<EnergyTerm>>& energies() const;

  /// Says that a step starts here: `previous_geometry` is that of this state until the next call;
  /// `geometry` stays what it is.
  void begin_step(const State& state);
  /// From now on whatever evaluates, factorises or solves throws Error with ExitCode::interrupted
  /// as soon as `stop` is true: an integrator's step ends there, whatever the integrator. What a
  /// step has made until then is to be thrown away. Null: nothing stops them.
  void stop_when(const std::atomic<bool>* stop);
  /// Makes `geometry` that of a state; computes it unless it is known (same positions).
  void update_geometry(const State& state);
  /// Geometry of the last updated state, of the state at which the last step began, and of the rest
  /// state.
  [[nodiscard]] const Geometry& geometry(const SampleSet& samples) const;
  [[nodiscard]] const Geometry& previous_geometry(const SampleSet& samples) const;
  [[nodiscard]] const Geometry& rest_geometry(const SampleSet& samples) const;

  /// Evaluates all forces at a state, coefficients lagged at the same state.
  void evaluate(const State& state);
  /// The same, and the lagged operator K with f(r) = c − K r at this state.
  void evaluate_with_operator(const State& state);
  /// Evaluates all forces at a state, and the tangent; `before`: positions before the last Newton
  /// step, for Tangent::foreseen. `rate`: dv/dr of an implicit step [1/s], for what depends on
  /// velocities: where v = (r − b)·rate, its −∂f/∂v (or what bounds it) times `rate` is added.
  /// `use`: what for; it changes where the matrix is kept, not what it is.
  void evaluate_with_tangent(const State& state, Tangent kind, const NodeVectors* before = nullptr,
                             double rate = 0, TangentUse use = TangentUse::any);
  /// Adds a symmetric 3 × 3 block [N/m] to the tangent of the last evaluate_with_tangent, on a
  /// node's diagonal: of forces that the System does not know.
  void stiffen(Index node, const Eigen::Matrix3d& block);
  /// Root mean square of a field (N × 3) over the mass.
  [[nodiscard]] double root_mean_square(const NodeVectors& field) const;
  /// (N) A third of the trace of each node's diagonal block of that tangent [N/m].
  [[nodiscard]] NodeValues mean_stiffness() const;
  /// Energy of all terms and potential energy of all force fields at a state [J].
  [[nodiscard]] double potential(const State& state);
  /// What has a part in the force but not in `potential`, and what has none in the tangent (or one
  /// that is not its derivative): names, by which Newton's method is known to fall short.
  [[nodiscard]] std::vector<std::string> without_potential() const;
  [[nodiscard]] std::vector<std::string> without_tangent() const;
  /// (N × 3) all forces of the last evaluation but what `damping` times velocity takes [N].
  [[nodiscard]] const NodeVectors& force() const;
  /// (N × 3) of these, at a state, what is no gradient of `potential` though its energy terms are:
  /// force fields without a potential, damping of materials [N].
  [[nodiscard]] NodeVectors force_beside_potential(const State& state);
  /// Whether force_beside_potential can be anything but zero.
  [[nodiscard]] bool has_force_beside_potential() const;
  /// From now on, damping of materials whose energy knows strains (TermTraits::strains) takes the
  /// rates (T − T_b)·rate, T_b = (1 − s) T(r) + s T(earlier), T = G, B, in place of those of v: for
  /// methods whose velocity is a difference over a step, in which a turn by a large angle would
  /// count as a strain. Such damping is the gradient of `damping_potential`. `rate` 0 ends that.
  void measure_strains_from(double rate, const NodeVectors& r, double s = 0,
                            const NodeVectors& earlier = {});
  /// Of the state, where strains are so measured [J].
  [[nodiscard]] double damping_potential(const State& state);
  /// From now on, states are the middle of a step from r (N × 3) to 2 r_state − r, and energies
  /// that know strains (TermTraits::strains), or live on tuples of nodes, are those of the mean of
  /// the strains at both ends, their forces those that conserve energy and momenta over the step
  /// (Geometry::make_mean; Simo & Tarnow 1992). These forces are no gradient: what is not one of
  /// the mean strains' energy is part of force_beside_potential; tangents are symmetric and exact
  /// but for the turn within a step. `end_average_of_strains` ends that.
  void average_strains_from(const NodeVectors& r);
  void end_average_of_strains();
  /// (N × 3) all that damps at a state: −`damping` times velocity, and damping of materials [N].
  [[nodiscard]] NodeVectors damping_force(const State& state);
  /// Of the last evaluate_with_tangent: −∂f/∂r of all terms with a potential and all force fields
  /// that know theirs [N/m].
  [[nodiscard]] const BlockMatrix& tangent() const;
  /// (N) −∂f/∂v, or what bounds it, of force fields that say so, of the last
  /// evaluate_with_operator [N·s/m].
  [[nodiscard]] const NodeValues& force_damping() const;
  /// The lagged operator K (N × N, shared by x, y, z) of the last evaluate_with_operator.
  [[nodiscard]] const SparseMatrix& lagged_operator() const;

  /// Chooses the linear solver now, else the first `solve` does. Throws InputError when none takes
  /// this model's matrices.
  void choose_solver();
  /// Solves (K + diag(d)) x = b on the free degrees of freedom; prescribed entries of x (N × 3) are
  /// given, the others a guess, for iterative solvers, which solve to `tolerance`
  /// (LinearSolver::improve). Throws Error with ExitCode::diverged and each solver's reason when
  /// none can.
  void solve(const NodeValues& d, const NodeVectors& b, NodeVectors& x, double tolerance);
  /// Factorises Tᵀ(K + diag(d))T with the tangent of the last evaluate_with_tangent, d (N) for x, y
  /// and z alike [N/m]. Returns "" or why it is not positive definite.
  [[nodiscard]] std::string factor_tangent(const NodeValues& d);
  /// Solves with that factor: x = T y, Tᵀ(K + diag(d))T y = Tᵀb; b and x (N × 3). Prescribed
  /// components of x are 0. Returns "" or why the solver cannot.
  [[nodiscard]] std::string solve_tangent(const NodeVectors& b, NodeVectors& x);
  /// Both at once, for directions that need not be exact: the solution's error, in a norm of the
  /// solver's choice, is `tolerance` of that of 0 or less. Iterative where a solver suits. Returns
  /// "" or why the matrix is not positive definite.
  [[nodiscard]] std::string solve_tangent_to(double tolerance, const NodeValues& d,
                                             const NodeVectors& b, NodeVectors& x);
  /// Solves once more with the matrix of the last `solve_tangent_to`.
  [[nodiscard]] std::string solve_tangent_again(double tolerance, const NodeVectors& b,
                                                NodeVectors& x);
  /// Takes a direction d from r (both N × 3 [m]) for steps that turn parts of the surface by finite
  /// angles where r + s d would stretch them (Huang et al. 2011). Returns d's largest angle [rad].
  double aim(const NodeVectors& r, const NodeVectors& d);
  /// Positions (N × 3) [m] after s times what was aimed at; to first order in s they are r + s d.
  void turn(double s, NodeVectors& r);
  /// The lowest eigenvalue of K x = λ M x on what is free, with K the tangent of the last
  /// evaluate_with_tangent [1/s²]; how many are negative; and its x (N × 3).
  struct Stability {
    double lowest = 0;
    Index negative = 0;
    NodeVectors mode;
  };
  [[nodiscard]] Stability stability();
  /// Tells `factor_tangent` and `factor_jacobian` to hold as many components as it takes for a
  /// surface at r that neither its constraints nor force fields with a stiffness, at the time of
  /// the last evaluation, hold in space (statics, where inertia does not either). Returns them.
  std::vector<Freedom> hold_rigid_motions(const NodeVectors& r);

  /// Evaluates all forces, and −∂f/∂r of all of them by coloured differences: for what has no
  /// tangent. Unsymmetric; lagged coefficients move with the state. `rate` as for
  /// evaluate_with_tangent: velocities move with positions.
  void evaluate_with_jacobian(const State& state, double rate = 0);
  /// As factor_tangent and solve_tangent, with that matrix; "" or why it cannot be factorised.
  [[nodiscard]] std::string factor_jacobian(const NodeValues& d);
  [[nodiscard]] std::string solve_jacobian(const NodeVectors& b, NodeVectors& x);

  /// Writes the components of positions, or of velocities, that are tied to others.
  void follow_ties(NodeVectors& r) const;
  void follow_ties_of_velocity(NodeVectors& v) const;
  /// Solves TᵀMT a = Tᵀf for accelerations T a of what is free; those of prescribed components are
  /// 0 (both N × 3).
  void accelerate(const NodeVectors& f, NodeVectors& acceleration);
  /// Writes the velocities of prescribed components [m/s] at a time, and of those tied to others,
  /// by differences of positions within `reach` [s] of it: before it where that is positive, after
  /// it where negative. The two differ where a path has a corner; a step's length with its sign
  /// looks at that step alone, and is right in any unit of time.
  void prescribe_velocity(double time, double reach, NodeVectors& v) const;
  /// The longest step from a time on that every part of the model stands [s].
  [[nodiscard]] double longest_step(double time) const;
  /// The first time later than `after` at which some part of the model is not smooth in time [s];
  /// infinite where there is none. Throws PluginFailure where one names an earlier time.
  [[nodiscard]] double next_break(double after) const;
  /// Tᵀf in place (N × 3): what acts on free components, that on tied ones included.
  void reduce_force(NodeVectors& f) const;
  /// Writes the prescribed components [m] at a time, and those that are tied to others; leaves
  /// these alone.
  void prescribe(double time, NodeVectors& r) const;

  /// Puts `after`, whose time is `step` seconds later than `before`'s, on the constraints:
  /// prescribed components get their positions and the velocity that led there. What an explicit
  /// step ends with.
  void constrain(const NodeVectors& before, double step, State& after) const;

  /// Puts nodes that `after` has inside of a collider, or on the other side of one than they were
  /// at `before` (N × 3), `step` seconds earlier, on its surface, with friction; their velocities
  /// become those after an inelastic impact. What constraints hold of a node stays. Returns which
  /// nodes, ascending.
  std::vector<Index> collide(const NodeVectors& before, double step, State& after);
  /// The nodes whose gap to a collider is less than `within` [m] at a time, were they at `r`,
  /// having come from `from` (both N × 3); each collider by itself, nodes ascending.
  void find_contacts(double time, const NodeVectors& from, const NodeVectors& r, double within,
                     std::vector<NodeContact>& contacts) const;
  /// Makes velocities at a state, which a step of so many seconds ends with, those that contact
  /// leaves: a node does not move into a collider, nor away from it by a push alone, and what
  /// slides is slowed by friction × push. `impulses`: what the velocities know of it.
  void settle(double step, const std::vector<ContactImpulse>& impulses, State& state) const;
  [[nodiscard]] std::size_t colliders() const;
  /// (M) Distance of points (M × 3) to the nearest collider at a time, negative inside [m];
  /// infinite where there is none.
  [[nodiscard]] NodeValues clearance(double time, const NodeVectors& points) const;
  /// Throws InputError when a node that a collider can push begins inside of it by more than
  /// `slack` [m].
  void require_outside_of_colliders(const NodeVectors& r, double slack) const;

  /// Energy of one term at a state [J] (coefficients lagged at the same state).
  [[nodiscard]] double energy(std::size_t term, const State& state);
  /// Energy per parameter area [J/m²] at the samples of a JetTerm's set, at the updated geometry.
  [[nodiscard]] std::vector<double> energy_density(std::size_t term) const;
  /// Potential energy of the force fields that have one [J].
  [[nodiscard]] double external_potential(const State& state);
  /// Forces of one energy term or of all force fields at a state (N × 3) [N].
  [[nodiscard]] NodeVectors internal_force(std::size_t term, const State& state);
  [[nodiscard]] NodeVectors external_force(const State& state);
  /// K of one energy term alone at a state, and its constant part c: f = c − K r. For checks.
  struct LaggedForce {
    SparseMatrix k;
    NodeVectors c;
  };
  [[nodiscard]] LaggedForce lagged_force(std::size_t term, const State& state);
  /// Name of the energy term or force field with the largest force at a node.
  [[nodiscard]] std::string largest_force_at(Index node, const State& state);

  [[nodiscard]] StepTimes& times();
  /// Emptied by begin_step; integrators write it.
  [[nodiscard]] StepReport& step_report();
  [[nodiscard]] const StepReport& step_report() const;
  /// What a log should say of the model: which terms leave their force to a numerical derivative.
  [[nodiscard]] std::vector<std::string> notes() const;
  /// Why the solver in use is the one in use.
  [[nodiscard]] const std::string& solver_choice() const;

 private:
  void require_promised_symmetry();
  [[noreturn]] void throw_force_not_finite(const State& state);
  [[noreturn]] void throw_operator_not_finite(const State& state);
  [[noreturn]] void throw_prescribed_not_finite(double time, Index node) const;
  /// As energy_density, into room that is kept.
  void find_energy_density(std::size_t term, std::vector<double>& density) const;
  [[noreturn]] void throw_energy_not_finite(std::size_t term, Index node) const;

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace deform
