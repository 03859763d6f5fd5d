/// Implicit dynamics: orders, invariants, damping, steps that fail, error control.
#include <cmath>
#include <functional>
#include <numbers>
#include <string>

#include <fmt/format.h>

#include "deform/solve/linear_solver.h"
#include "deform/solve/newton_matrix.h"
#include "deform/solve/stepped_integrator.h"

#include "model/support/simulate.h"

namespace deform {
namespace {

using test::run_to_end;
using test::simulation_from_text;

/// Stiff enough to swing without crumpling.
const Replacement kStiffer{"/energies/0/young", "20000"};
/// A soft sheet without supports; what else the scene has is put in by pointers.
const std::string kSheet = R"({
  "surface": {"plugin": "grid", "nodes": [6, 5], "size": [1.0, 0.8], "differences": "symmetric",
              "border": "one_sided", "weights": "area"},
  "material": {"density": 1.0},
  "energies": [{"plugin": "koiter", "young": 200, "poisson": 0.3, "thickness": 0.05}],
  "forces": [], "constraints": [],
  "integrator": {"plugin": "backward_euler", "step": 0.02}, "duration": 0.4})";
const Replacement kGravity{"/forces/-", R"({"plugin": "gravity"})"};
const Replacement kClamped{"/constraints/-",
                           R"({"plugin": "clamp", "where": {"boundary": "left"}})"};
const Replacement kMoved{
    "/constraints/-",
    R"({"plugin": "move", "where": {"boundary": "right"}, "components": ["x"], "times": [0, 1],
        "displacements": [[0, 0, 0], [-0.3, 0, 0]]})"};

Replacement integrator(const std::string& name, double step, const std::string& more = "") {
  return {"/integrator", fmt::format(R"({{"plugin": "{}", "step": {}{}}})", name, step, more)};
}
const std::string kExactly = R"(, "tolerance": 1e-12)";

State end_of(const std::vector<Replacement>& replacements) {
  Simulation s = simulation_from_text(kSheet, replacements);
  const auto diverged = run_to_end(s);
  EXPECT_FALSE(diverged) << (diverged ? diverged->what() : "");
  return s.state();
}

double order(double coarse, double fine) { return std::log2(coarse / fine); }

/// Errors at the end of a smooth motion against runge_kutta with a step that is far shorter.
class OrderOf : public testing::TestWithParam<std::tuple<std::string, double, double>> {};

TEST_P(OrderOf, TheMethodIsAsPromised) {
  const auto& [name, step, promised] = GetParam();
  const std::string more = name == "runge_kutta" ? "" : kExactly;
  for (const Replacement& motion : {kClamped, kMoved}) {
    const State exact = end_of({kGravity, motion, integrator("runge_kutta", 1.0 / 2560)});
    std::vector<double> r, v;
    for (const double h : {step, step / 2, step / 4}) {
      const State end = end_of({kGravity, motion, integrator(name, h, more)});
      r.push_back((end.r - exact.r).norm());
      v.push_back((end.v - exact.v).norm());
    }
    EXPECT_GT(order(r[1], r[2]), promised) << r[0] << ' ' << r[1] << ' ' << r[2];
    EXPECT_GT(order(v[1], v[2]), promised) << v[0] << ' ' << v[1] << ' ' << v[2];
    RecordProperty("order", std::to_string(order(r[1], r[2])));
  }
}

INSTANTIATE_TEST_SUITE_P(Integrators, OrderOf,
                         testing::Values(std::tuple{"backward_euler", 0.0025, 0.95},
                                         std::tuple{"bdf2", 0.01, 1.9},
                                         std::tuple{"implicit_midpoint", 0.01, 1.9},
                                         std::tuple{"runge_kutta", 0.01, 3.9}),
                         [](const auto& each) { return std::get<0>(each.param); });

/// Order two with damping, too: force fields that depend on velocities and the material's own are
/// taken at the stage.
TEST(Dynamics, DampingKeepsTheOrder) {
  const std::vector<Replacement> damped{
      kGravity,
      kClamped,
      {"/material/damping", "0.4"},
      {"/material/rayleigh_mass", "0.3"},
      {"/energies/0/retardation", "0.02"},
      {"/forces/-", R"({"plugin": "viscous_fluid", "viscosity": 0.5})"},
      {"/forces/-", R"({"plugin": "wind", "velocity": [0, 1, 0]})"}};
  const auto run = [&](const std::string& name, double step, const std::string& more) {
    std::vector<Replacement> all = damped;
    all.push_back(integrator(name, step, more));
    return end_of(all).r;
  };
  const NodeVectors exact = run("runge_kutta", 1.0 / 2560, "");
  for (const char* name : {"bdf2", "implicit_midpoint"}) {
    const double coarse = (run(name, 0.01, kExactly) - exact).norm();
    const double fine = (run(name, 0.005, kExactly) - exact).norm();
    EXPECT_GT(order(coarse, fine), 1.9) << name << ' ' << coarse << ' ' << fine;
  }
}

Vec3 angular_momentum(const System& system, const State& state) {
  Vec3 sum = Vec3::Zero();
  for (Index a = 0; a < state.r.rows(); ++a)
    sum +=
        system.mass()[a] * Vec3(state.r.row(a).transpose()).cross(Vec3(state.v.row(a).transpose()));
  return sum;
}
Vec3 momentum(const System& system, const State& state) {
  return state.v.transpose() * system.mass();
}

/// A sheet that is thrown, turning and vibrating; steps it and gives the largest change of momentum
/// and of angular momentum relative to the first.
std::pair<double, double> changes_in_flight(const std::string& name, double step,
                                            const std::string& more = "") {
  Simulation s = simulation_from_text(kSheet, {integrator(name, step, more),
                                               {"/duration", "2.0"},
                                               {"/limits", R"({"distance": 100})"},
                                               {"/energies/0/retardation", "0.01"}});
  State state = s.state();
  for (Index a = 0; a < state.r.rows(); ++a) {
    const Vec3 r = state.r.row(a);
    state.v.row(a) = Vec3(1, 0.5, 2) + Vec3(1, 2, -1).cross(r) + Vec3(0, 0, 0.5 * r.x() * r.x());
  }
  // Its own copy of the integrator: the simulation starts at rest.
  const auto& registry = *s.registry();
  const auto own = registry.create<Integrator>(s.scene().integrator(), Setup(nullptr));
  const Vec3 p = momentum(s.system(), state), l = angular_momentum(s.system(), state);
  double of_p = 0, of_l = 0;
  for (int i = 0; i < std::lround(2.0 / step); ++i) {
    s.system().begin_step();
    own->advance(s.system(), state, step);
    of_p = std::max(of_p, (momentum(s.system(), state) - p).norm() / p.norm());
    of_l = std::max(of_l, (angular_momentum(s.system(), state) - l).norm() / l.norm());
  }
  return {of_p, of_l};
}

/// All keep momentum. The midpoint rule keeps angular momentum, whatever the step, damping of the
/// material included; the others to their order.
TEST(Dynamics, FreeFlightKeepsMomentumAsEachMethodPromises) {
  for (const auto& [name, promised] : {std::pair{"backward_euler", 0.9}, {"bdf2", 1.9}}) {
    const auto [p, l] = changes_in_flight(name, 0.01, kExactly);
    const auto [p_fine, l_fine] = changes_in_flight(name, 0.005, kExactly);
    EXPECT_LT(p, 1e-9) << name;
    EXPECT_LT(p_fine, 1e-9) << name;
    EXPECT_GT(order(l, l_fine), promised) << name << ' ' << l << ' ' << l_fine;
  }
  const auto [p, l] = changes_in_flight("implicit_midpoint", 0.02, kExactly);
  EXPECT_LT(p, 1e-10);
  EXPECT_LT(l, 1e-10);
}

double total_energy(const System& system, const State& state) {
  return system.evaluator().potential(state) +
         0.5 * system.mass().dot(NodeValues(state.v.rowwise().squaredNorm()));
}

/// Largest deviation of the energy in the first and in the second half of a run, relative to the
/// energy that comes and goes.
std::pair<double, double> drift_of(const std::string& name, double step, long steps) {
  const std::string more = name == "implicit_midpoint" ? kExactly : "";
  Simulation s = simulation_from_text(
      kSheet, {kGravity,
               kClamped,
               kStiffer,
               integrator(name, step, more),
               {"/forces/0/acceleration", "[0, 0, -1]"},
               {"/duration", std::to_string(step * static_cast<double>(steps))}});
  const double begin = total_energy(s.system(), s.state());
  double first = 0, second = 0, exchanged = 0;
  while (s.steps() < steps) {
    s.step();
    const double energy = total_energy(s.system(), s.state());
    exchanged = std::max(exchanged, std::abs(s.system().terms().external_potential(s.state())));
    double& half = 2 * s.steps() <= steps ? first : second;
    half = std::max(half, std::abs(energy - begin));
  }
  return {first / exchanged, second / exchanged};
}

/// Symplectic methods: the energy's error is bounded; it does not grow with the number of steps.
TEST(Dynamics, EnergyDoesNotDrift) {
  for (const auto& [name, step, bound] :
       {std::tuple{"implicit_midpoint", 0.01, 0.02}, {"symplectic_euler", 0.001, 0.02}}) {
    const auto [first, second] = drift_of(name, step, 6000);
    EXPECT_LT(first, bound) << name;
    EXPECT_LT(second, 1.3 * first + 1e-9) << name;  // what Newton's method leaves, step by step
  }
}

/// First frequency of a clamped strip (ν = 0): ω = 3.516 √(EI/(μ L⁴)), by the eigenvalue of the
/// tangent and by the time that ten swings take.
TEST(Dynamics, CantileverSwingsAtItsFrequency) {
  const double EI = 1000 * 1e-6 / 12, mu = 0.01, omega = 3.516015 * std::sqrt(EI / mu);
  const double period = 2 * std::numbers::pi / omega;
  Simulation s = simulation_from_text(fmt::format(
      R"({{"surface": {{"plugin": "grid", "nodes": [41, 3], "size": [1.0, 0.05],
              "differences": "symmetric", "border": "one_sided", "weights": "area"}},
          "material": {{"density": {}}},
          "energies": [{{"plugin": "koiter", "young": 1000, "poisson": 0, "thickness": 0.01}}],
          "forces": [{{"plugin": "edge_load", "where": {{"boundary": "right"}},
                       "force": [0, 0, 2e-6], "time": {{"pulse": [0, {}]}}}}],
          "constraints": [{{"plugin": "clamp", "where": {{"boundary": "left"}}}}],
          "integrator": {{"plugin": "implicit_midpoint", "step": {}}}, "duration": {}}})",
      mu, period / 2, period / 200, 11 * period));
  NewtonMatrix tangent(s.system());
  tangent.evaluate(s.state());
  EXPECT_NEAR(std::sqrt(tangent.stability().lowest) / omega, 1, 0.002);

  const Index tip = s.system().surface().boundary("right")[1];
  std::vector<double> crossings;  // of z = 0, upwards, after the push
  double before = 0;
  while (s.steps() < s.scene().steps()) {
    s.step();
    const double z = s.state().r(tip, 2), t = s.state().time;
    if (t > period && before < 0 && z >= 0)
      crossings.push_back(t - s.scene().step * z / (z - before));
    before = z;
  }
  ASSERT_GE(crossings.size(), 8U);
  const double swings = static_cast<double>(crossings.size() - 1);
  EXPECT_NEAR(swings * period / (crossings.back() - crossings.front()), 1, 0.005);
}

/// Mass damping takes e^{−α t} of a flight's velocity; stiffness damping e^{−β ω² t/2} of a
/// vibration's amplitude, and nothing of a turning sheet.
TEST(Dynamics, RayleighDampingIsAsKnown) {
  const State fallen = end_of({{"/velocity", "[1, 0, 0]"},
                               {"/material/rayleigh_mass", "0.7"},
                               integrator("implicit_midpoint", 0.005)});
  EXPECT_NEAR(fallen.v.col(0).mean(), std::exp(-0.7 * 0.4), 1e-6);

  const auto swing = [](double retardation) {
    Simulation s = simulation_from_text(
        kSheet, {kClamped,
                 kStiffer,
                 {"/velocity", "[0, 0, 1e-3]"},
                 {"/duration", "20"},
                 {"/material/rayleigh_stiffness", fmt::format("{}", retardation)},
                 integrator("implicit_midpoint", 0.02)});
    const Index tip = s.system().surface().boundary("right")[2];
    double early = 0, late = 0;  // amplitudes
    while (s.steps() < s.scene().steps()) {
      s.step();
      double& part = s.state().time < 10 ? early : late;
      part = std::max(part, std::abs(s.state().r(tip, 2)));
    }
    return std::pair(early, late);
  };
  Simulation s = simulation_from_text(kSheet, {kClamped, kStiffer});
  NewtonMatrix tangent(s.system());
  tangent.evaluate(s.state());
  const double lowest = tangent.stability().lowest;  // ω² [1/s²]
  const double retardation = 0.2 / lowest;           // e^{−2} in 20 s
  const auto [early, late] = swing(retardation);
  EXPECT_NEAR(late / early, std::exp(-retardation * lowest / 2 * 10), 0.05);
  const auto [undamped_early, undamped_late] = swing(0);
  EXPECT_GT(undamped_late / undamped_early, 0.97);
}

/// The retardation of one energy acts on it alone, and one without a potential has none.
TEST(Dynamics, RetardationNeedsAPotential) {
  try {
    (void)simulation_from_text(
        kSheet, {{"/energies/-", R"({"plugin": "bending", "xi": 1e-5, "retardation": 0.1})"}});
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("/energies/1/retardation"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("no potential"), std::string::npos) << e.what();
  }
}

/// The damping force of one state: power −vᵀDv is that of the stress θ C Ṫ, so twice the energy of
/// strains that grow by the strain rates.
TEST(Dynamics, DampingForceIsThatOfStrainRates) {
  Simulation s = simulation_from_text(kSheet, {{"/energies/0/retardation", "0.25"}});
  State state = s.state();
  for (Index a = 0; a < state.r.rows(); ++a) {
    const Vec3 r = state.r.row(a);
    state.r(a, 2) += 0.1 * std::sin(3 * r.x() + r.y());
    state.v.row(a) = Vec3(r.y(), r.x() * r.y(), std::cos(2 * r.x()));
  }
  // d²/dt² of the energy is ṪᵀCṪ + σ·T̈; the second part goes where the state is its own rest.
  Simulation at_rest = simulation_from_text(kSheet, {{"/energies/0/retardation", "0.25"}});
  State flat = at_rest.state();
  flat.v = state.v;
  const double h = 1e-4;
  State forward = flat, backward = flat;
  forward.r += h * flat.v, backward.r -= h * flat.v;
  System& system = at_rest.system();
  const double curvature =
      (system.evaluator().potential(forward) + system.evaluator().potential(backward) -
       2 * system.evaluator().potential(flat)) /
      (h * h);
  const double power = system.evaluator().damping_force(flat).cwiseProduct(flat.v).sum();
  EXPECT_NEAR(power, -0.25 * curvature, 1e-5 * std::abs(power));
  // Anywhere: dissipates, and a rigid motion feels nothing.
  EXPECT_LT(s.system().evaluator().damping_force(state).cwiseProduct(state.v).sum(), 0);
  const double largest = s.system().evaluator().damping_force(state).cwiseAbs().maxCoeff();
  for (Index a = 0; a < state.r.rows(); ++a)
    state.v.row(a) = Vec3(1, 2, 3) + Vec3(-1, 2, 0.5).cross(Vec3(state.r.row(a).transpose()));
  EXPECT_LT(s.system().evaluator().damping_force(state).cwiseAbs().maxCoeff(), 1e-12 * largest);
}

/// A method that cannot take steps longer than it says: r⁺ = r + h v.
class Picky final : public SteppedIntegrator {
 public:
  Picky(double longest, bool asks, StepControl control = {})
      : SteppedIntegrator(control), longest_(longest), asks_(asks) {}

 protected:
  Attempt attempt(System& /*system*/, const State& from, double step, State& to) override {
    if (step > longest_ * (1 + 1e-12)) {
      if (asks_) throw StepTooLong("it is picky", longest_);
      return {.failure = "it is picky", .error = {}, .resolved_contacts = true};
    }
    to.r = from.r + step * from.v;
    to.v = from.v;
    to.time = from.time + step;
    return {.failure = "", .error = {}, .resolved_contacts = true};
  }
  [[nodiscard]] int local_order() const override { return 2; }

 private:
  double longest_;
  bool asks_;
};

TEST(SteppedIntegrator, HalvesAStepThatFails) {
  Simulation s = simulation_from_text(kSheet);
  State state = s.state();
  state.v.col(0).setConstant(1);
  const double begin = state.r(0, 0);
  Picky picky(0.3, false);
  picky.advance(s.system(), state, 1.0);
  EXPECT_DOUBLE_EQ(state.time, 1.0);
  EXPECT_NEAR(state.r(0, 0) - begin, 1.0, 1e-14);
  EXPECT_DOUBLE_EQ(s.system().step_report().largest, 0.25);
  EXPECT_GE(s.system().step_report().rejected, 2);
}

TEST(SteppedIntegrator, TakesTheStepThatAPluginAsksFor) {
  Simulation s = simulation_from_text(kSheet);
  State state = s.state();
  Picky picky(0.3, true);
  picky.advance(s.system(), state, 1.0);
  EXPECT_DOUBLE_EQ(s.system().step_report().largest, 0.3);
  EXPECT_DOUBLE_EQ(state.time, 1.0);
}

TEST(SteppedIntegrator, GivesUpAfterTenHalvings) {
  Simulation s = simulation_from_text(kSheet);
  State state = s.state();
  Picky picky(1.0 / 1024, false);
  picky.advance(s.system(), state, 1.0);
  EXPECT_EQ(s.system().step_report().substeps, 1024);
  Picky pickier(1.0 / 1100, false);
  try {
    pickier.advance(s.system(), state, 1.0);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ExitCode::diverged);
    EXPECT_NE(std::string(e.what()).find("it is picky"), std::string::npos) << e.what();
  }
}

/// Steps end where a load jumps or has a corner.
TEST(SteppedIntegrator, EndsStepsWhereALoadChanges) {
  Simulation s = simulation_from_text(
      kSheet, {{"/forces/-", R"({"plugin": "gravity", "time": {"pulse": [0.005, 0.006]}})"},
               {"/integrator/step", "0.02"}});
  s.step();
  EXPECT_EQ(s.system().step_report().substeps, 3);
  EXPECT_NEAR(s.system().step_report().smallest, 0.001, 1e-12);
  EXPECT_NEAR(s.state().v.col(2).mean(), -9.81 * 0.001, 1e-12);
}

/// With error control the end state is as near as asked for, over a range of tolerances, and
/// recorded states do not depend on where they fall within the steps.
TEST(SteppedIntegrator, ControlsTheError) {
  const State exact = end_of({kGravity, kClamped, integrator("runge_kutta", 1.0 / 2560)});
  for (const auto& [name, order] : {std::pair{"backward_euler", 1},
                                    {"bdf2", 2},
                                    {"implicit_midpoint", 2},
                                    {"runge_kutta", 3}}) {
    double last = kInfinity;
    for (const double error : {1e-4, 1e-6}) {
      const std::string more =
          fmt::format(R"(, "error": {}{})", error,
                      std::string(name) == "runge_kutta" ? "" : R"(, "tolerance": 1e-10)");
      const double there = (end_of({kGravity, kClamped, integrator(name, 0.02, more)}).r - exact.r)
                               .rowwise()
                               .norm()
                               .maxCoeff();
      EXPECT_LT(there, 0.3 * last) << name << ' ' << error;
      // As many steps as the error of one allows add theirs up.
      EXPECT_LT(there, 10 * std::pow(error, order / (order + 1.0))) << name;
      last = there;
    }
  }
}

TEST(SteppedIntegrator, InterpolatesBetweenItsSteps) {
  const std::string more = R"(, "error": 1e-6, "tolerance": 1e-10)";
  const State often = end_of({kGravity, kClamped, integrator("bdf2", 0.001, more)});
  const State seldom = end_of({kGravity, kClamped, integrator("bdf2", 0.4, more)});
  EXPECT_LT((often.r - seldom.r).cwiseAbs().maxCoeff(), 1e-4);
  EXPECT_NEAR(often.time, seldom.time, 1e-12);
  Simulation s = simulation_from_text(
      kSheet, {kGravity, kClamped, {"/duration", "0.04"}, integrator("bdf2", 0.0001, more)});
  long without = 0;
  while (s.steps() < s.scene().steps()) {
    s.step();
    without += s.system().step_report().substeps == 0 ? 1 : 0;
  }
  EXPECT_GT(without, 0);  // recorded more often than stepped
}

/// A run that goes on in fresh objects has the same bits: history, steps ahead of the record, and
/// contact forces are part of what is saved.
TEST(Dynamics, GoesOnFromWhatWasSaved) {
  const Replacement floor{"/colliders/-",
                          R"({"plugin": "plane", "point": [0, 0, -0.05], "friction": 0.4})"};
  for (const char* name : {"backward_euler", "bdf2", "implicit_midpoint", "runge_kutta"})
    for (const char* more : {"", R"(, "error": 1e-5)"}) {
      const std::vector<Replacement> scene{
          kGravity, kClamped, kStiffer, floor, integrator(name, 0.002, more), {"/duration", "0.3"}};
      Simulation whole = simulation_from_text(kSheet, scene);
      while (whole.steps() < 120) whole.step();
      Memory memory;
      whole.save(memory);
      Simulation resumed = simulation_from_text(kSheet, scene);
      resumed.load(memory);
      while (whole.steps() < 150) whole.step(), resumed.step();
      EXPECT_EQ(whole.state().r, resumed.state().r) << name << more;
      EXPECT_EQ(whole.state().v, resumed.state().v) << name << more;
      // It lies on the floor by then, so that contact had a part in it.
      EXPECT_LT(whole.state().r.col(2).minCoeff(), -0.05 + 1e-3) << name << more;
    }
}

/// Any stiffness, any step: Newton's method converges without shortening it, and the incremental
/// potential falls.
TEST(BackwardEuler, TakesAnyStep) {
  for (const double xi : {1e-6, 1e-3, 1e-1})
    for (const double step : {0.02, 0.2, 1.0}) {
      Simulation s = test::simulation_of(
          "benchmarks/sheet_p.json", "base",
          {{"/energies/1", fmt::format(R"({{"plugin": "bending_variational", "xi": {}}})", xi)},
           {"/surface/border", "\"one_sided\""},
           {"/duration", std::to_string(5 * step)},
           integrator("backward_euler", step, R"(, "tolerance": 1e-6)")});
      while (s.steps() < s.scene().steps()) {
        s.step();
        const StepReport& report = s.system().step_report();
        EXPECT_LE(report.residual, 1e-6) << xi << ' ' << step;
        EXPECT_LE(report.potential_change, 0) << xi << ' ' << step;
        EXPECT_LE(report.iterations, 50) << xi << ' ' << step;
        EXPECT_EQ(report.rejected, 0) << xi << ' ' << step;
      }
    }
}

/// Terms without a potential run with differences of the force: the same motion as the term with
/// a potential that differs from them by little, and as their own semi-implicit steps refined.
TEST(BackwardEuler, TakesTermsWithoutAPotential) {
  const auto run = [](const std::string& name, double step) {
    Simulation s = test::simulation_of("benchmarks/sheet_p.json", "base",
                                       {{"/surface/nodes", "[9, 9]"},
                                        {"/duration", "0.2"},
                                        {"/forces/0/where/radius", "0.13"},
                                        integrator(name, step)});
    const auto diverged = run_to_end(s);
    EXPECT_FALSE(diverged) << (diverged ? diverged->what() : "");
    return s.state().r;
  };
  const NodeVectors reference = run("semi_implicit", 1e-4);
  const double coarse = (run("backward_euler", 0.02) - reference).norm();
  const double fine = (run("backward_euler", 0.01) - reference).norm();
  EXPECT_NEAR(order(coarse, fine), 1, 0.15) << coarse << ' ' << fine;
  const double second = (run("bdf2", 0.01) - reference).norm();
  EXPECT_LT(second, 0.3 * fine);
}

}  // namespace
}  // namespace deform
