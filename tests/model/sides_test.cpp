/// Constraints and loads along open sides: what holds after they have acted, and closed forms.
#include <numbers>

#include <fmt/format.h>

#include "deform/check/mechanics.h"
#include "deform/solve/newton_matrix.h"

#include "model/support/random.h"
#include "model/support/simulate.h"

namespace deform {
namespace {

constexpr const char* kFlat = R"({"plugin": "flat"})";
constexpr const char* kSphere = R"({"plugin": "sphere_patch", "radius": 1.5})";
constexpr const char* kTurned = R"({"plugin": "formula", "x": "0.6*a1", "y": "a2", "z": "0.8*a1"})";
constexpr const char* kBendable =
    R"({"plugin": "stretching", "eta": 0.5}, {"plugin": "bending_variational", "xi": 1e-3})";

Simulation sheet(const std::string& constraints, const std::string& forces = "",
                 const std::string& shape = kFlat,
                 const std::string& surface = R"(, "nodes": [7, 6])",
                 const std::string& energies = kBendable) {
  return test::simulation_from_text(fmt::format(
      R"({{"surface": {{"plugin": "grid", "size": [1.0, 0.8], "rest": {}{}}},
        "material": {{"density": 0.1, "damping": 0.1}}, "energies": [{}], "forces": [{}],
        "constraints": [{}], "integrator": {{"plugin": "semi_implicit", "step": 0.01}},
        "duration": 0.2}})",
      shape, surface, energies, forces, constraints));
}

std::string clamp(const std::string& sides, const std::string& tangent = "direction") {
  return fmt::format(R"({{"plugin": "clamp", "where": {{"boundary": {}}}, "tangent": "{}"}})",
                     sides, tangent);
}
std::string symmetry(const std::string& sides) {
  return fmt::format(R"({{"plugin": "symmetry", "where": {{"boundary": {}}}}})", sides);
}

Vec3 derivative(const std::vector<EdgeNode::Entry>& row, const NodeVectors& r) {
  Vec3 sum = Vec3::Zero();
  for (const auto& [node, coefficient] : row) sum += coefficient * Vec3(r.row(node));
  return sum;
}

/// Positions that the constraints allow, far from the initial ones.
NodeVectors allowed(Simulation& s, unsigned seed) {
  NodeVectors r =
      s.system().surface().initial() + 0.3 * test::random_vectors(s.system().nodes(), seed);
  s.system().constraints().prescribe(0, r);
  return r;
}

/// The largest change of n0·t, the normal's part of the derivative across a clamped side.
double turn_of(Simulation& s, const std::string& side, const NodeVectors& r) {
  const NodeVectors& initial = s.system().surface().initial();
  double largest = 0;
  for (const EdgeNode& edge : s.system().surface().edge(side)) {
    const Vec3 t0 = derivative(edge.inwards, initial);
    const Vec3 n = t0.cross(derivative(edge.along, initial)).normalized();
    largest = std::max(largest, std::abs(n.dot(derivative(edge.inwards, r) - t0)));
    largest = std::max(largest, (r.row(edge.node) - initial.row(edge.node)).norm());
  }
  return largest;
}

/// The largest part of the derivative across a side other than along `normal`, and what the side
/// has moved along that.
double slope_of(Simulation& s, const std::string& side, int normal, const NodeVectors& r) {
  double largest = 0;
  for (const EdgeNode& edge : s.system().surface().edge(side)) {
    Vec3 t = derivative(edge.inwards, r);
    t[normal] = r(edge.node, normal) - s.system().surface().initial()(edge.node, normal);
    largest = std::max(largest, t.norm());
  }
  return largest;
}

TEST(Clamp, OfAFlatSideTiesOneComponentOfTheNextNodes) {
  Simulation s = sheet(clamp(R"("left")"));
  const ReductionMap map(s.system().constraints().reduction());
  EXPECT_FALSE(s.system().constraints().reduction().ties_mix_components());
  ASSERT_EQ(map.ties().size(), 6U);
  for (const Tie& tie : map.ties()) {
    EXPECT_EQ(s.system().surface().parameters()(tie.freedom.node, 0), 1.0 / 6);
    EXPECT_EQ(tie.freedom.component, 2);
    EXPECT_EQ(tie.offset, 0);
    ASSERT_EQ(tie.parts.size(), 2U);
    double sum = 0;
    for (const Tie::Part& part : tie.parts) {
      EXPECT_EQ(part.of.component, 2);
      sum += part.coefficient;
    }
    EXPECT_NEAR(sum, 1, 1e-14);  // a flat sheet may rise as it is
    EXPECT_NEAR(map.row(tie.freedom).at(0).coefficient, 0.25, 1e-14);
  }
}

TEST(Clamp, KeepsTheSideAndItsDirectionOrAllOfItsTangent) {
  for (const char* shape : {kFlat, kTurned, kSphere}) {
    for (const char* side : {"left", "right", "bottom", "top"}) {
      const std::string quoted = fmt::format("\"{}\"", side);
      Simulation s = sheet(clamp(quoted), "", shape);
      EXPECT_LT(turn_of(s, side, allowed(s, 1)), 1e-12) << shape << side;
      Simulation full = sheet(clamp(quoted, "full"), "", shape);
      const NodeVectors r = allowed(full, 2), &initial = full.system().surface().initial();
      EXPECT_FALSE(full.system().constraints().reduction().ties_mix_components());
      for (const EdgeNode& edge : full.system().surface().edge(side))
        EXPECT_LT(derivative(edge.inwards, r - initial).norm(), 1e-12) << shape << side;
    }
    Simulation s = sheet(clamp(R"(["left", "top"])"), "", shape);
    NodeVectors r = s.system().surface().initial();
    s.system().constraints().prescribe(0, r);
    EXPECT_LT((r - s.system().surface().initial()).norm(), 1e-13);  // where it is at first
  }
}

TEST(Clamp, TakesSidesOnly) {
  for (const char* where : {R"({"node": 0})", R"([{"boundary": "left"}, {"corners": "all"}])"})
    EXPECT_THROW(sheet(fmt::format(R"({{"plugin": "clamp", "where": {}}})", where)), InputError);
}

TEST(Clamp, IsThatOfAMirroredWorldInAMirroredRun) {
  for (const char* shape : {kFlat, kSphere}) {
    const std::string text = clamp(R"("left")", std::string(shape) == kFlat ? "direction" : "full");
    Simulation s = sheet(text, R"({"plugin": "gravity", "acceleration": [0.1, 0, -1]})", shape);
    Simulation image(s.scene(), test::built_in(), true);
    for (int step = 0; step < 10; ++step) s.step(), image.step();
    NodeVectors back = image.state().r;
    back.col(2) *= -1;
    EXPECT_LT((back - s.state().r).norm(), 1e-13) << shape;
    EXPECT_GT((s.state().r - s.system().surface().initial()).norm(), 1e-4);
  }
}

constexpr double kXi = 1e-3, kWidth = 0.1;

/// A strip of length 1, clamped at the left.
Simulation cantilever(int n, const std::string& load, const std::string& more = "") {
  return test::simulation_from_text(fmt::format(
      R"({{"surface": {{"plugin": "grid", "nodes": [{}, 3], "size": [1.0, {}]}},
        "energies": [{{"plugin": "stretching", "eta": 100}},
                     {{"plugin": "bending_variational", "xi": {}}}],
        "forces": [{}], "constraints": [{}],
        "integrator": {{"plugin": "semi_implicit", "step": 0.01}}, "duration": 0.2}})",
      n, kWidth, kXi, load, clamp(R"("left")") + more));
}

/// One step of Newton's method towards equilibrium; returns the largest displacement.
double newton_step(const System& system, State& state) {
  NewtonMatrix tangent(system);
  tangent.evaluate(state);
  EXPECT_EQ(tangent.factor(NodeValues::Zero(system.nodes())), "");
  NodeVectors x = NodeVectors::Zero(system.nodes(), 3);
  EXPECT_EQ(tangent.solve(system.evaluator().force(state), x), "");
  state.r += x;
  return x.cwiseAbs().maxCoeff();
}

TEST(Clamp, BendsACantileverAsABeam) {
  constexpr const char* kTip =
      R"({"plugin": "edge_load", "force": [0, 0, -1e-6], "where": {"boundary": "right"}})";
  constexpr const char* kCouple = R"({"plugin": "moment", "moment": 1e-7, "axis": [0, 1, 0],
    "where": {"boundary": "right"}})";
  const double ei = kXi * kWidth, by_force = -1e-6 * kWidth / (3 * ei),
               by_couple = -1e-7 / (2 * ei);
  for (const auto& [load, beam] : {std::pair(kTip, by_force), std::pair(kCouple, by_couple)}) {
    const auto error = [&, load = load, beam = beam](int n) {
      Simulation s = cantilever(n, load);
      State state = disturbed(s.system().rest(), 0);
      newton_step(s.system(), state);
      const double tip = state.r(n - 1, 2);
      EXPECT_LT(std::abs(state.r(2 * n - 1, 2) - tip), 0.01 * std::abs(tip));
      return tip / beam - 1;
    };
    const double coarse = error(11), fine = error(21);
    EXPECT_LT(std::abs(fine), 0.002) << coarse << " " << fine;
    EXPECT_LT(std::abs(fine), std::abs(coarse) / 3 + 1e-6) << coarse << " " << fine;
  }
}

// A couple about a fixed axis lets a free end buckle sideways on the way: y is held.
TEST(Moment, RollsAStripIntoACircle) {
  constexpr int kNodes = 41, kIncrements = 50;
  constexpr double kFull = 2 * std::numbers::pi * kXi * kWidth;
  Simulation s = cantilever(kNodes,
                            fmt::format(R"({{"plugin": "moment", "moment": {},
    "axis": [0, -1, 0], "where": {{"boundary": "right"}}, "time": {{"ramp": [0, 1]}}}})",
                                        kFull),
                            R"(, {"plugin": "pin", "where": {"box": [[0, 0], [1, 0.1]]},
    "components": ["y"]})");
  State state = disturbed(s.system().rest(), 0);
  int steps = 0;
  for (int increment = 1; increment <= kIncrements; ++increment) {
    state.time = increment / static_cast<double>(kIncrements);
    double change = 1;
    for (int i = 0; i < 20 && change > 1e-9; ++i, ++steps) change = newton_step(s.system(), state);
    ASSERT_LT(change, 1e-9) << increment;
  }
  EXPECT_NEAR(-s.system().terms().external_potential(state) / kFull, 2 * std::numbers::pi, 0.1)
      << steps;
  EXPECT_LT((state.r.row(2 * kNodes - 1) - state.r.row(kNodes)).norm(), 0.02) << steps;
  EXPECT_LE(steps, 7 * kIncrements);  // the tangent is exact
}

TEST(Symmetry, HoldsThePlaneAndNoSlope) {
  Simulation s = sheet(symmetry(R"(["left", "bottom"])"));
  const NodeVectors r = allowed(s, 3);
  EXPECT_LT(slope_of(s, "left", 0, r), 1e-12);
  EXPECT_LT(slope_of(s, "bottom", 1, r), 1e-12);
  Simulation turned = sheet(symmetry(R"("bottom")"), "", kTurned);
  EXPECT_LT(slope_of(turned, "bottom", 1, allowed(turned, 4)), 1e-12);
}

TEST(Symmetry, RefusesSidesWithoutAPlane) {
  EXPECT_THROW(sheet(symmetry(R"("left")"), "", kSphere), InputError);
  EXPECT_THROW(sheet(symmetry(R"("left")"), "", kTurned), InputError);
  EXPECT_NO_THROW(
      sheet(R"({"plugin": "symmetry", "where": {"boundary": "left"}, "plane": "x"})", "", kTurned));
}

TEST(Sides, BothConditionsHoldWhereTwoMeet) {
  const std::string a = clamp(R"("left")"), b = symmetry(R"("bottom")");
  for (const std::string& constraints : {a + ", " + b, b + ", " + a}) {
    Simulation s = sheet(constraints);
    const NodeVectors r = allowed(s, 5);
    EXPECT_LT(turn_of(s, "left", r), 1e-12);
    EXPECT_LT(slope_of(s, "bottom", 1, r), 1e-12);
  }
  Simulation s = sheet(clamp(R"("all")"));
  const NodeVectors r = allowed(s, 6);
  for (const char* side : {"left", "right", "bottom", "top"})
    EXPECT_LT(turn_of(s, side, r), 1e-12) << side;
}

TEST(Sides, ForcesOnTiedComponentsDoTheirWork) {
  for (const std::string& constraints : {clamp(R"("all")"), symmetry(R"(["left", "bottom"])"),
                                         clamp(R"("left")") + ", " + symmetry(R"("top")")}) {
    Simulation s = sheet(constraints);
    const Reduction& reduction = s.system().constraints().reduction();
    const ReductionMap map(reduction);
    const Index n = s.system().nodes();
    NodeVectors q = test::random_vectors(n, 7), f = test::random_vectors(n, 8), reduced = f;
    for (int c = 0; c < 3; ++c)
      for (Index a = 0; a < n; ++a)
        if (!reduction.free(a, c)) q(a, c) = 0;
    NodeVectors change = q;
    map.complete_changes(change);
    map.transpose(reduced);
    EXPECT_NEAR(f.cwiseProduct(change).sum(), reduced.cwiseProduct(q).sum(), 1e-12);
    for (const Tie& tie : map.ties())  // chains end at what is free
      for (const Tie::Part& part : map.row(tie.freedom))
        EXPECT_TRUE(reduction.free(part.of.node, part.of.component));
  }
}

/// Height of the middle of a sheet that sags between two pinned sides; or of its half.
double sag(int cells, bool is_half) {
  Simulation s = test::simulation_from_text(fmt::format(
      R"({{"surface": {{"plugin": "grid", "nodes": [{}, 5], "size": [{}, 0.5]}},
        "material": {{"density": 0.1, "damping": 0.1}}, "energies": [{}],
        "forces": [{{"plugin": "gravity", "acceleration": [0, 0, -1]}}],
        "constraints": [{{"plugin": "pin", "where": {{"boundary": {}}}}}{}],
        "integrator": {{"plugin": "semi_implicit", "step": 0.01}}, "duration": 0.5}})",
      (is_half ? 1 : 2) * cells + 1, is_half ? 1 : 2, kBendable,
      is_half ? R"("left")" : R"(["left", "right"])",
      is_half ? ", " + symmetry(R"("right")") : ""));
  test::run_to_end(s);
  const Index middle = 2 * (s.system().nodes() / 5) + cells;
  EXPECT_EQ(s.system().surface().parameters()(middle, 0), 1);
  return s.state().r(middle, 2);
}

TEST(Symmetry, HalfASheetIsHalfOfTheWholeToSecondOrder) {
  const double whole = sag(32, false);
  const double coarse = sag(8, true) - sag(8, false), fine = sag(16, true) - sag(16, false);
  EXPECT_LT(whole, -0.05);
  EXPECT_LT(std::abs(fine), 0.01 * std::abs(whole)) << fine;
  EXPECT_LT(std::abs(fine), std::abs(coarse) / 3) << coarse << " " << fine;
}

TEST(EdgeLoad, IsForceTimesLength) {
  for (const char* weights : {"area", "equal"}) {
    Simulation s = sheet(
        "", R"({"plugin": "edge_load", "force": [1, -2, 3],
      "where": {"boundary": ["left", "bottom"]}})",
        kSphere,
        fmt::format(R"(, "nodes": [7, 6], "differences": "central", "weights": "{}")", weights));
    State state = disturbed(s.system().rest(), 0.1);
    const NodeVectors f = s.system().terms().external_force(state);
    // A meridian, and a circle of latitude that is shorter than the equator.
    const double length = 0.8 + std::cos(0.8 / (2 * 1.5));
    EXPECT_LT((Vec3(f.colwise().sum()) - length * Vec3(1, -2, 3)).norm(), 1e-4);
    EXPECT_NEAR(s.system().terms().external_potential(state), -f.cwiseProduct(state.r).sum(),
                1e-13);
  }
}

constexpr const char* kMoment = R"({"plugin": "moment", "moment": 0.3, "axis": [0.2, 2, 0.1],
  "where": {"boundary": ["right", "top"]}})";

TEST(Moment, IsACouple) {
  Simulation s = sheet("", kMoment, kSphere);
  const Vec3 axis = Vec3(0.2, 2, 0.1).normalized();
  for (const double strain : {0.0, 0.1, 0.3}) {
    const State state = disturbed(s.system().rest(), strain);
    const NodeVectors f = s.system().terms().external_force(state);
    Vec3 torque = Vec3::Zero();
    for (Index a = 0; a < f.rows(); ++a) torque += Vec3(state.r.row(a)).cross(Vec3(f.row(a)));
    EXPECT_LT(f.colwise().sum().norm(), 1e-13 * f.norm());
    EXPECT_NEAR(axis.dot(torque), 0.3, 1e-13);
  }
}

TEST(Moment, HasThePotentialAndTheTangentOfAnAngle) {
  Simulation s = sheet("", kMoment, kSphere);
  const State at = disturbed(s.system().rest(), 0.1);
  const NodeVectors f = s.system().terms().external_force(at),
                    x = test::random_vectors(f.rows(), 9);
  const auto potential_at = [&](double step) {
    State moved = at;
    moved.r += step * x;
    return s.system().terms().external_potential(moved);
  };
  constexpr double h = 1e-5;
  EXPECT_NEAR(f.cwiseProduct(x).sum(), -(potential_at(h) - potential_at(-h)) / (2 * h), 1e-6);
  EXPECT_LT(tangent_error(s.system(), at), 1e-8);
}

TEST(Moment, CountsTheTurnsOfARolledStrip) {
  Simulation s = sheet("", R"({"plugin": "moment", "moment": 1, "axis": [0, -1, 0],
    "where": {"boundary": "right"}})",
                       kFlat, R"(, "nodes": [41, 3])");
  const Eigen::MatrixX2d& a = s.system().surface().parameters();
  for (const double turns : {-2.6, -0.9, 0.3, 1.4, 3.0}) {
    const double k = 2 * std::numbers::pi * turns;  // of a strip of length 1
    State state = disturbed(s.system().rest(), 0);
    for (Index i = 0; i < a.rows(); ++i)
      state.r.row(i) << std::sin(k * a(i, 0)) / k, a(i, 1), (1 - std::cos(k * a(i, 0))) / k;
    EXPECT_NEAR(s.system().terms().external_potential(state), -k, 0.02 * std::abs(k)) << turns;
  }
}

TEST(Moment, RefusesWhatDoesNotTurn) {
  for (const char* axis : {"[0, 0, 0]", "[1, 0, 0]"})
    EXPECT_THROW(sheet("", fmt::format(R"({{"plugin": "moment", "moment": 1, "axis": {},
      "where": {{"boundary": "right"}}}})",
                                       axis)),
                 InputError);
}

TEST(Pressure, HasAnExactTangentOnAClosedSurface) {
  Simulation s =
      sheet("", R"({"plugin": "pressure", "pressure": 0.7})",
            R"({"plugin": "torus", "radius": 0.5, "tube": 0.2})",
            R"(, "periodic": [true, true], "nodes": [12, 8])", R"({"plugin": "edge_springs"})");
  EXPECT_LT(tangent_error(s.system(), disturbed(s.system().rest(), 0.05)), 1e-8);
}

}  // namespace
}  // namespace deform
