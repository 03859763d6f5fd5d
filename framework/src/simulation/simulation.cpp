#include "deform/simulation/simulation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "deform/error.h"
#include "deform/geometry/characteristic_length.h"
#include "deform/log.h"
#include "deform/solve/lagged_matrix.h"

#include "model/mirrored_parts.h"
#include "model/moving_collider.h"
#include "not_finite.h"
#include "plugin/common_parameters.h"
#include "plugin/guard.h"
#include "profile/profile.h"
#include "simulation/compound_terms.h"
#include "simulation/initial_velocity.h"
#include "simulation/masses.h"
#include "simulation/memory_sections.h"
#include "simulation/part_maker.h"
#include "simulation/report_memory.h"
#include "simulation/selection_remarks.h"
#include "simulation/solver_check.h"
#include "simulation/solver_uses.h"
#include "solve/asked.h"
#include "solve/system_parts.h"

namespace deform {
namespace {

class MirrorImage final : public CompanionRun {
 public:
  explicit MirrorImage(std::unique_ptr<Simulation> simulation)
      : simulation_(std::move(simulation)) {}
  void step() override { simulation_->step(); }
  [[nodiscard]] const State& state() const override { return simulation_->state(); }
  [[nodiscard]] long steps() const override { return simulation_->steps(); }
  void save(Memory& memory) const override { simulation_->save(memory); }
  void load(const Memory& memory) override { simulation_->load(memory); }

 private:
  std::unique_ptr<Simulation> simulation_;
};

/// A double counts no further.
constexpr double kMostSteps = 9007199254740992;  // 2^53

/// Times of one step that are nearer to each other count as one: parts of a step that are much
/// shorter than it have velocities of few digits, and times late in a run few digits themselves.
double rounding_of_time(double end, double step) {
  return std::max(1e-9 * step, 16 * std::numeric_limits<double>::epsilon() * std::abs(end));
}

/// Reflection at z = 0.
NodeVectors reflected(NodeVectors v) {
  v.col(2) = -v.col(2);
  return v;
}

std::vector<double> flattened(const NodeVectors& v) { return {v.data(), v.data() + v.size()}; }

NodeVectors unflattened(const Memory& memory, const std::string& name, Index nodes) {
  const std::vector<double>& values = memory.get(name, static_cast<std::size_t>(3 * nodes));
  NodeVectors v = Eigen::Map<const NodeVectors>(values.data(), nodes, 3);
  if (!v.allFinite()) throw InputError("the checkpoint's \"" + name + "\" is not finite");
  return v;
}

/// Puts force fields, constraints and colliders, which speak of the scene's world, into the
/// mirrored one.
void mirror(ModelParts& parts) {
  for (auto& field : parts.forces) field.object = mirrored(field.object, parts.rest.rows());
  for (auto& constraint : parts.constraints) constraint.object = mirrored(constraint.object);
  for (Body& body : parts.bodies) body.collider.object = mirrored(body.collider.object);
}

/// An equilibrium that is looked for as if there were no bodies is not made right by putting nodes
/// outside of them afterwards.
void require_no_colliders(const Scene& scene, const Named<Integrator>& integrator,
                          PartMaker& maker) {
  const std::size_t colliders = scene.plugins[PluginKind::collider].size();
  if (colliders == 0) return;
  const bool ignores_bodies = guarded(integrator.origin, "saying what it is", [&] {
    return integrator.object->is_static() && !integrator.object->resolves_contacts();
  });
  if (!ignores_bodies) return;
  maker.add({{"/colliders",
              fmt::format("at /colliders: found {} of them, expected none: integrator \"{}\" looks "
                          "for equilibria without contact; take \"static\", not 'linear', or "
                          "\"backward_euler\" with damping ('damping' of the material), until the "
                          "surface rests",
                          colliders, integrator.name)}});
}

/// Contact is part of minimising a potential.
void require_potential_in_contact(const System& system, const Named<Integrator>& integrator) {
  if (system.contact().bodies() == 0 || !integrator.object->is_static()) return;
  const std::vector<std::string> without = system.evaluator().without_potential();
  if (system.evaluator().energies_have_potential()) return;
  throw InputError(
      {{"/colliders",
        fmt::format("at /colliders: equilibria in contact take energies with a potential, but {} "
                    "has none; take \"bending_variational\", or \"backward_euler\" with damping "
                    "('damping' of the material) until the surface rests",
                    without.empty() ? std::string("an energy") : without.front())}});
}

/// Velocities whose energy overflows are no state to begin with.
void require_finite_energy(const NodeVectors& v, const NodeValues& mass) {
  if (std::isfinite(v.rowwise().squaredNorm().dot(mass))) return;
  throw InputError({{"/velocity", fmt::format("at /velocity: velocities of up to {:.3g} m/s, whose "
                                              "kinetic energy no number holds",
                                              v.cwiseAbs().maxCoeff())}});
}

}  // namespace

struct Simulation::Impl {
  Impl(Scene scene_, std::shared_ptr<const PluginRegistry> registry_, bool mirrored_)
      : scene(std::move(scene_)), registry(std::move(registry_)), mirrored(mirrored_) {
    make_system();
    measure_rest();
    set_initial_state();
  }

  void make_system();
  void make_energies(PartMaker& maker, const Setup& setup, ModelParts& parts) const;
  [[nodiscard]] std::vector<Body> make_bodies(PartMaker& maker, const Setup& setup) const;
  [[nodiscard]] std::function<std::vector<Named<LinearSolver>>()> solver_factory(
      PartMaker& maker, const std::shared_ptr<Surface>& surface);
  void check_solver(const MakeSolvers& make_solvers);
  void require_masses() const;
  void measure_rest();
  void set_initial_state();
  void advance_by_parts(const AtBreak& at_break);
  void advance_smoothly(double step);
  void advance(double step);
  void collide(const State& begin, double step);
  void report_parts(long parts, double shortest, double longest);
  [[nodiscard]] Frame frame(double step);
  void check_state();
  [[noreturn]] void throw_not_finite();
  [[noreturn]] void throw_out_of_bounds(Index node);
  [[nodiscard]] Index node_of_largest_force();
  [[nodiscard]] std::string guilty_term(Index node);
  void restore();

  Scene scene;
  std::shared_ptr<const PluginRegistry> registry;
  bool mirrored;

  std::vector<MadePart> checkpointed;
  Named<Integrator> integrator;
  // Of this world; outlive the objects that saw them in their Setup.
  NodeVectors rest;
  NodeValues areas;
  std::unique_ptr<System> system;

  Vec3 centroid = Vec3::Zero();  // of the rest state
  double size = 0;

  const std::atomic<bool>* stop = nullptr;  // of a step; see stop_when

  State state;
  State before;   // the last step: what previous_geometry is of
  State earlier;  // the step before that one
  long steps = 0;
};

void Simulation::Impl::make_system() {
  PartMaker maker(scene, registry);
  auto surface = maker.make<Surface>(scene.surface(), maker.setup());
  maker.throw_problems();  // nothing else can be made without a surface

  rest = mirrored ? reflected(surface->object->rest()) : surface->object->rest();
  areas = areas_of_mass(*surface->object, scene.material);
  check_areas(scene, areas, maker);
  const Setup setup = maker.setup(*surface->object, rest, areas);
  // Force fields, constraints and colliders are made for the world that the scene describes, and
  // reflected as a whole.
  const Setup unmirrored = maker.setup(*surface->object, surface->object->rest(), areas);

  ModelParts parts;
  parts.surface = surface->object;
  parts.rest = rest;
  parts.areas = areas;
  make_energies(maker, setup, parts);
  const NodeValues density = densities(scene, areas.size(), parts.energies, maker, !mirrored);
  parts.mass = density.cwiseProduct(areas);
  parts.damping =
      (scene.material.damping + scene.material.rayleigh_mass * density.array()) * areas.array();
  parts.forces = maker.make_all<ForceField>(unmirrored);
  parts.constraints = maker.make_all<Constraint>(unmirrored);
  parts.bodies = make_bodies(maker, unmirrored);
  if (mirrored) mirror(parts);
  auto made_integrator = maker.make<Integrator>(scene.integrator(), setup);
  if (made_integrator) require_no_colliders(scene, *made_integrator, maker);
  parts.make_solvers = solver_factory(maker, surface->object);
  maker.throw_problems();
  if (!mirrored) log_selection_remarks(scene, *surface->object);

  checkpointed = maker.made();
  integrator = *made_integrator;
  take_apart_compounds(parts.energies, parts.retardation);
  const auto make_solvers = parts.make_solvers;
  system = std::make_unique<System>(std::move(parts));
  require_masses();
  require_potential_in_contact(*system, integrator);
  if (!scene.plugins[PluginKind::solver].empty()) check_solver(make_solvers);
}

/// Energies and their retardation times. A term without a potential has no stiffness that damping
/// could be a multiple of.
void Simulation::Impl::make_energies(PartMaker& maker, const Setup& setup,
                                     ModelParts& parts) const {
  for (const PluginUse& use : scene.plugins[PluginKind::energy]) {
    auto made = maker.make<EnergyTerm>(use, setup);
    if (!made) continue;
    const bool is_compound = dynamic_cast<const CompoundTerm*>(made->object.get()) != nullptr;
    const bool has_stiffness = is_compound || has_potential(*made);
    const double own = common_parameters<EnergyTerm>(use).retardation;
    if (own > 0 && !has_stiffness)
      maker.add({{use.pointer + "/retardation",
                  fmt::format("at {}/retardation: found {:g}, expected 0: {} has no potential, so "
                              "no stiffness that its damping could be a multiple of",
                              use.pointer, own, made->name)}});
    parts.retardation.push_back(has_stiffness ? own + scene.material.rayleigh_stiffness : 0);
    parts.energies.push_back(std::move(*made));
  }
}

std::vector<Body> Simulation::Impl::make_bodies(PartMaker& maker, const Setup& setup) const {
  std::vector<Body> bodies;
  for (const PluginUse& use : scene.plugins[PluginKind::collider]) {
    const auto common = common_parameters<Collider>(use);
    const RigidPath path{common.times, common.displacements, common.rotations, common.pivot};
    const std::string problem = problem_of(path);
    if (!problem.empty())
      maker.add({{use.pointer + (path.times.empty() ? "" : "/times"),
                  fmt::format("at {}: {}", use.pointer, problem)}});
    auto collider = maker.make<Collider>(use, setup);
    if (!collider || !problem.empty()) continue;
    if (!path.times.empty()) collider->object = moving(collider->object, path);
    bodies.push_back(
        {std::move(*collider), common.friction, common.thickness, common.restitution, use.pointer});
  }
  return bodies;
}

/// Whether the solver that the scene names takes the matrix is a question of the scene: it is asked
/// now, not within the first step.
void Simulation::Impl::check_solver(const MakeSolvers& make_solvers) {
  if (asked(integrator, [](const Integrator& i) { return i.solves(); }) !=
      Integrator::Solves::lagged)
    return require_solver(scene, *registry, *system, integrator, make_solvers);
  try {
    LaggedMatrix(*system).choose_solver();
  } catch (const InputError& e) {
    throw InputError({{"/solver", "at /solver: " + std::string(e.what())}});
  }
}

std::function<std::vector<Named<LinearSolver>>()> Simulation::Impl::solver_factory(
    PartMaker& maker, const std::shared_ptr<Surface>& surface) {
  SolverUses solvers = solver_uses(scene, *registry);
  maker.add(solvers.problems);
  if (!mirrored) {  // once a run is enough
    for (const std::string& reason : solvers.left_out) log::warn(reason);
  }
  const auto make = [this, surface, uses = std::move(solvers.uses)](PartMaker& by) {
    return by.make_all<LinearSolver>(uses, by.setup(*surface, rest, areas));
  };
  PartMaker trial(scene, registry);  // problems must show now, not when the System needs a solver
  (void)make(trial);
  maker.add(trial.problems());
  return [this, make] {
    PartMaker fresh(scene, registry);
    auto made = make(fresh);
    fresh.throw_problems();
    return made;
  };
}

/// An explicit step divides by masses, and a semi-implicit one by what they give its matrix.
void Simulation::Impl::require_masses() const {
  const auto has_none = [](const ScalarUnknown& s) { return s.mass == 0; };
  if (std::ranges::none_of(system->scalars(), has_none)) return;
  if (asked(integrator, [](const Integrator& i) { return i.solves(); }) ==
      Integrator::Solves::tangents)
    return;
  throw InputError(
      {{"/integrator", fmt::format("at /integrator: found \"{}\", expected one that solves with "
                                   "tangents (\"backward_euler\", \"bdf2\", "
                                   "\"implicit_midpoint\", \"static\"): some energy has a scalar "
                                   "unknown without mass",
                                   integrator.name)}});
}

void Simulation::Impl::measure_rest() {
  centroid = rest.colwise().mean().transpose();
  size = characteristic_length(rest);
}

void Simulation::Impl::set_initial_state() {
  const Surface& surface = system->surface();
  const Index nodes = system->nodes();
  state = system->at_rest();
  state.r.topRows(nodes) = mirrored ? reflected(surface.initial()) : surface.initial();
  system->constraints().prescribe(0.0, state.r);
  system->contact().require_outside(state.r, 1e-6 * size);

  // The scene speaks of the unmirrored world, whose spin is not turned round but reflected.
  const auto into_this_world = [this](const NodeVectors& v) { return mirrored ? reflected(v) : v; };
  const NodeVectors velocity =
      into_this_world(velocities_at_first(scene.velocity, surface, system->mass().head(nodes),
                                          into_this_world(state.r.topRows(nodes))));
  for (int c = 0; c < 3; ++c) {
    for (const Index node : system->constraints().reduction().free_nodes(c)) {
      if (node < nodes) state.v(node, c) = velocity(node, c);
    }
  }
  system->constraints().follow_ties_of_velocity(state.v);
  require_finite_energy(state.v, system->mass());
  before = earlier = state;
  system->begin_step();
}

/// From one time at which the model is not smooth to the next.
void Simulation::Impl::advance_by_parts(const AtBreak& at_break) {
  const double end = state.time + scene.step, rounding = rounding_of_time(end, scene.step);
  const bool is_static = deform::is_static(integrator);
  double longest = 0, shortest = scene.step;
  for (long parts = 1;; ++parts) {
    const double begin = state.time,
                 next = is_static ? kInfinity : system->next_break(begin + rounding);
    const bool is_last = next >= end - rounding;
    const double part = is_last ? (parts == 1 ? scene.step : end - begin) : next - begin;
    advance_smoothly(part);
    if (next <= end + rounding)
      guarded(integrator.origin, "starting anew", [this] { integrator.object->restart(); });
    longest = std::max(longest, part), shortest = std::min(shortest, part);
    if (is_last) return report_parts(parts, shortest, longest);
    state.time = next;
    if (at_break) at_break(frame(part));
  }
}

/// Unless the integrator has said what parts it took.
void Simulation::Impl::report_parts(long parts, double shortest, double longest) {
  StepReport& report = system->step_report();
  if (parts == 1 || report.largest > 0) return;
  report.substeps = parts;
  report.smallest = shortest, report.largest = longest;
}

void Simulation::Impl::advance_smoothly(double step) {
  const bool collides =
      system->contact().bodies() > 0 &&
      !asked(integrator, [](const Integrator& i) { return i.resolves_contacts(); });
  const State begin = collides ? state : State{};
  advance(step);
  check_state();
  if (collides) collide(begin, step);
}

void Simulation::Impl::advance(double step) {
  const Span span(integrator.name);
  try {
    guarded(integrator.origin, "taking a step",
            [&] { integrator.object->advance(*system, state, step); });
  } catch (const Diverged&) {
    throw;
  } catch (const NotFinite& e) {
    throw e.at_step(steps + 1, integrator.name);
  } catch (const Error& e) {
    if (e.code() != ExitCode::diverged) throw;
    // The System knows no steps. No solver could: the largest force is what spoiled the matrix.
    const Index node = node_of_largest_force();
    throw Diverged(e.what(), steps + 1, node, guilty_term(node));
  }
}

void Simulation::Impl::collide(const State& begin, double step) {
  const Span span("collision");
  try {
    const std::vector<ContactImpulse> impulses = system->contact().resolve(begin, step, state);
    system->step_report().contact.add(system->mass(), impulses, begin.v, state.v, step);
  } catch (const NotFinite& e) {
    throw e.at_step(steps + 1, "colliders");
  }
}

void Simulation::Impl::check_state() {
  if (state.r.rows() != before.r.rows() || state.v.rows() != before.v.rows()) {
    throw PluginFailure(
        fmt::format("{} changed the number of nodes of the state", integrator.origin));
  }
  const double limit = scene.max_distance * size;
  double largest = 0;
  Index farthest = 0;
  for (Index i = 0; i < state.r.rows(); ++i) {
    if (!state.r.row(i).allFinite() || !state.v.row(i).allFinite()) throw_not_finite();
    if (i >= system->nodes()) continue;  // a scalar unknown is nowhere
    const double distance = (state.r.row(i).transpose() - centroid).squaredNorm();
    if (distance > largest) largest = distance, farthest = i;
  }
  if (largest > limit * limit) throw_out_of_bounds(farthest);
}

void Simulation::Impl::throw_not_finite() {
  // The System lets no force, operator or solution pass that is not finite: what is left is the
  // integrator.
  Index node = first_not_finite(state.r);
  if (node < 0) node = first_not_finite(state.v);
  throw Diverged("the state that " + integrator.origin + " gives is not finite", steps + 1, node,
                 integrator.name);
}

void Simulation::Impl::throw_out_of_bounds(Index node) {
  const double distance = (state.r.row(node).transpose() - centroid).norm();
  throw Diverged(
      fmt::format("a node is {:.3g} m away from the centre of the rest state, more than {:g} "
                  "characteristic lengths ({:.3g} m each)",
                  distance, scene.max_distance, size),
      steps + 1, node, guilty_term(node));
}

/// Where the step began.
Index Simulation::Impl::node_of_largest_force() {
  Index node = 0;
  try {
    system->evaluator().force(before).rowwise().squaredNorm().maxCoeff(&node);
  } catch (const Error&) {
    // The divergence is what the user must hear of.
  }
  return node;
}

std::string Simulation::Impl::guilty_term(Index node) {
  try {
    return system->terms().largest_force_at(node, before);
  } catch (const NotFinite& e) {
    return e.part();
  } catch (const std::exception&) {
    return "unknown";  // the divergence is what the user must hear of
  }
}

void Simulation::Impl::restore() {
  state = before;
  before = earlier;
  system->begin_step();
}

Simulation::Simulation(Scene scene, std::shared_ptr<const PluginRegistry> registry, bool mirrored)
    : impl_(std::make_unique<Impl>(std::move(scene), std::move(registry), mirrored)) {}

Simulation::~Simulation() = default;

void Simulation::step(const AtBreak& at_break) {
  const Span span("step");
  Impl& s = *impl_;
  std::swap(s.earlier, s.before);
  s.before = s.state;
  s.system->begin_step();
  try {
    s.advance_by_parts(at_break);
  } catch (...) {
    s.restore();
    throw;
  }
  ++s.steps;
  s.state.time = static_cast<double>(s.steps) * s.scene.step;  // not summed up: exact to rounding
}

void Simulation::stop_when(const std::atomic<bool>* stop) {
  impl_->stop = stop;
  SystemParts::of(*impl_->system).meter.stop = stop;
}

const Scene& Simulation::scene() const { return impl_->scene; }
const Named<Integrator>& Simulation::integrator() const { return impl_->integrator; }
System& Simulation::system() { return *impl_->system; }
const State& Simulation::state() const { return impl_->state; }
long Simulation::steps() const { return impl_->steps; }
double Simulation::size() const { return impl_->size; }
std::shared_ptr<const PluginRegistry> Simulation::registry() const { return impl_->registry; }

Frame Simulation::Impl::frame(double step) { return {steps, step, state, before.r, *system}; }

Frame Simulation::frame() { return impl_->frame(impl_->scene.step); }

std::unique_ptr<CompanionRun> Simulation::mirrored() const {
  auto image = std::make_unique<Simulation>(impl_->scene, impl_->registry, !impl_->mirrored);
  image->stop_when(impl_->stop);
  return std::make_unique<MirrorImage>(std::move(image));
}

void Simulation::save(Memory& memory) const {
  memory.put("state/steps", {static_cast<double>(impl_->steps)});
  memory.put("state/r", flattened(impl_->state.r));
  memory.put("state/v", flattened(impl_->state.v));
  memory.put("state/previous_r", flattened(impl_->before.r));
  save_report(impl_->system->step_report(), memory);
  for (const MadePart& part : impl_->checkpointed) {
    save_plugin(*part.object, part.origin, part.section, memory);
  }
}

void Simulation::load(const Memory& memory) {
  Impl& s = *impl_;
  const Index nodes = s.state.r.rows();
  State loaded;
  loaded.r = unflattened(memory, "state/r", nodes);
  loaded.v = unflattened(memory, "state/v", nodes);
  s.before.r = unflattened(memory, "state/previous_r", nodes);
  const double steps = memory.get("state/steps", 1).front();
  if (!(steps >= 0 && steps <= kMostSteps && steps == std::floor(steps)))
    throw InputError("the checkpoint's \"state/steps\" is not a number of steps");
  s.steps = static_cast<long>(steps);
  loaded.time = static_cast<double>(s.steps) * s.scene.step;
  s.state = std::move(loaded);
  for (const MadePart& part : s.checkpointed) {
    load_plugin(*part.object, part.origin, part.section, memory);
  }
  s.system->begin_step();
  load_report(s.system->step_report(), memory, s.system->rows());
}

}  // namespace deform
