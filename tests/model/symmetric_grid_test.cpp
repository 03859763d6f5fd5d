/// The grid's symmetric differences: orders of convergence, energies, what alternates from node to
/// node, and a second implementation.
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "deform/check/mechanics.h"

#include "model/support/analytic.h"
#include "model/support/simulate.h"

namespace deform {
namespace {

using test::analytic_surfaces;
using test::simulation_from_text;

constexpr double kEta11 = 0.02, kEta12 = 0.005, kEta22 = 0.01;
constexpr double kXi11 = 2e-4, kXi12 = 1e-4, kXi22 = 3e-4;
constexpr std::size_t kStretching = 0, kBending = 1;

/// Stretching and bending on a grid over the unit square, flat at rest unless `more` says
/// otherwise.
Simulation sheet(const std::string& differences, int n_1, int n_2, const std::string& more = "") {
  return simulation_from_text(fmt::format(
      R"({{"surface": {{"plugin": "grid", "nodes": [{}, {}], "differences": "{}"{}}},
        "energies": [{{"plugin": "stretching", "eta": [[{}, {}], [{}, {}]]}},
                     {{"plugin": "bending_variational", "xi": [[{}, {}], [{}, {}]]}}],
        "integrator": {{"plugin": "semi_implicit", "step": 0.01}}, "duration": 0.01}})",
      n_1, n_2, differences, more, kEta11, kEta12, kEta12, kEta22, kXi11, kXi12, kXi12, kXi22));
}

State state_of(Simulation& s, const test::Analytic& shape) {
  const Eigen::MatrixX2d& a = s.system().surface().parameters();
  State state{NodeVectors(a.rows(), 3), NodeVectors::Zero(a.rows(), 3), 0};
  for (Index i = 0; i < a.rows(); ++i) state.r.row(i) = shape.jet(a(i, 0), a(i, 1))[0];
  return state;
}

double order(double coarse, double fine) { return std::log2(coarse / fine); }

/// Errors of n and B at the bending samples against the closed form.
struct FrameErrors {
  double n = 0, n_border = 0;                     // largest
  std::array<double, 3> B{}, B_border{}, mean{};  // largest inside and at the border; mean of |·|
};
FrameErrors frame_errors(const test::Analytic& shape, int n) {
  Simulation s = sheet("symmetric", n, n);
  const SampleSet& samples = s.system().surface().samples(SampleRole::bending);
  Geometry geometry(samples);
  geometry.compute(samples, state_of(s, shape).r);
  const GeometryBlock found = geometry.all();
  FrameErrors errors;
  for (Index i = 0; i < samples.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Vec2 a = samples.parameters()[k];
    const test::Jet jet = shape.jet(a.x(), a.y());
    const bool border = a.minCoeff() < 1e-9 || a.maxCoeff() > 1 - 1e-9;
    double& worst = border ? errors.n_border : errors.n;
    worst = std::max(worst, (found.n()[i] - test::normal(jet)).norm());
    for (const Pair ij : kPairs) {
      const auto p = static_cast<std::size_t>(slot(ij));
      const double error = std::abs(found.B(ij)[k] - test::curvature(jet, ij));
      double& worst_B = border ? errors.B_border[p] : errors.B[p];
      worst_B = std::max(worst_B, error);
      errors.mean[p] += samples.weights()[k] * error;
    }
  }
  return errors;
}

/// At the border D_11 and D_22 across it are the neighbour's, so B across it is of first order
/// there (and of second in the mean): the sample then stands for the same row as its neighbour,
/// which is what makes energies and clamped edges of second order. A second-order row would not.
TEST(SymmetricGrid, NormalsAndCurvatureAreOfSecondOrder) {
  for (const test::Analytic& shape : analytic_surfaces()) {
    const FrameErrors coarse = frame_errors(shape, 33), fine = frame_errors(shape, 65);
    const auto expect = [&](const std::string& what, double at_33, double at_65, double least) {
      if (at_65 < 1e-11) return;  // exact
      EXPECT_GE(order(at_33, at_65), least) << shape.name << ": " << what;
      std::printf("%-16s %-14s %.3e  order %.2f\n", shape.name.c_str(), what.c_str(), at_65,
                  order(at_33, at_65));
    };
    expect("n inside", coarse.n, fine.n, 1.9);
    expect("n border", coarse.n_border, fine.n_border, 1.9);
    for (const Pair ij : kPairs) {
      const auto p = static_cast<std::size_t>(slot(ij));
      const std::string name = std::array{"B_11", "B_12", "B_22"}[p];
      expect(name + " inside", coarse.B[p], fine.B[p], 1.9);
      expect(name + " border", coarse.B_border[p], fine.B_border[p], ij == Pair::p12 ? 1.9 : 0.9);
      expect(name + " mean", coarse.mean[p], fine.mean[p], 1.9);
    }
  }
}

/// Of a cell's four corners the errors of the metric cancel, in cells at the border, too.
TEST(SymmetricGrid, MetricOfACellIsOfSecondOrder) {
  const auto largest_error = [](const test::Analytic& shape, int n) {
    Simulation s = sheet("symmetric", n, n);
    const SampleSet& samples = s.system().surface().samples(SampleRole::membrane);
    Geometry geometry(samples);
    geometry.compute(samples, state_of(s, shape).r);
    struct Cell {
      int corners = 0;
      Vec2 centre = Vec2::Zero();
      std::array<double, 3> G{};
    };
    std::map<std::vector<std::int32_t>, Cell> cells;
    for (Index i = 0; i < samples.size(); ++i) {
      const auto nodes = samples.stencil(i).nodes;
      std::vector<std::int32_t> key(nodes.begin(), nodes.end());
      std::ranges::sort(key);
      Cell& cell = cells[key];
      ++cell.corners;
      cell.centre += samples.parameters()[static_cast<std::size_t>(i)] / 4;
      for (const Pair ij : kPairs)
        cell.G[static_cast<std::size_t>(slot(ij))] +=
            geometry.all().G(ij)[static_cast<std::size_t>(i)] / 4;
    }
    EXPECT_EQ(cells.size(), static_cast<std::size_t>((n - 1) * (n - 1)));
    double worst = 0;
    for (const auto& [nodes, cell] : cells) {
      EXPECT_EQ(cell.corners, 4);
      const test::Jet jet = shape.jet(cell.centre.x(), cell.centre.y());
      for (const Pair ij : kPairs)
        worst = std::max(
            worst, std::abs(cell.G[static_cast<std::size_t>(slot(ij))] - test::metric(jet, ij)));
    }
    return worst;
  };
  for (const test::Analytic& shape : analytic_surfaces()) {
    const double found = order(largest_error(shape, 33), largest_error(shape, 65));
    EXPECT_GE(found, 1.9) << shape.name;
    std::printf("%-16s metric of cells  order %.2f\n", shape.name.c_str(), found);
  }
}

/// Both energies of a deformation that is smooth up to the border.
TEST(SymmetricGrid, EnergiesAreOfSecondOrder) {
  for (const test::Analytic& shape : analytic_surfaces()) {
    const double stretching = test::integral([&](double a, double b) {
      const test::Jet jet = shape.jet(a, b);
      const auto square = [&](Pair ij) {
        return std::pow(test::metric(jet, ij) - (ij == Pair::p12 ? 0 : 1), 2);
      };
      return 0.25 * (kEta11 * square(Pair::p11) + 2 * kEta12 * square(Pair::p12) +
                     kEta22 * square(Pair::p22));
    });
    const double bending = test::integral([&](double a, double b) {
      const test::Jet jet = shape.jet(a, b);
      const auto square = [&](Pair ij) { return std::pow(test::curvature(jet, ij), 2); };
      return 0.5 * (kXi11 * square(Pair::p11) + 2 * kXi12 * square(Pair::p12) +
                    kXi22 * square(Pair::p22));
    });
    for (const auto& [term, exact] : {std::pair{kStretching, stretching}, {kBending, bending}}) {
      const auto error = [&shape, term = term, exact = exact](int n) {
        Simulation s = sheet("symmetric", n, n);
        return std::abs(s.system().terms().energy(term, state_of(s, shape)) / exact - 1);
      };
      const double coarse = error(33), fine = error(65);
      EXPECT_GE(order(coarse, fine), 1.9) << shape.name << " term " << term;
      EXPECT_LT(fine, 5e-3) << shape.name << " term " << term;
      std::printf("%-16s %-10s relative error %.2e  order %.2f\n", shape.name.c_str(),
                  term == kStretching ? "stretching" : "bending", fine, order(coarse, fine));
    }
  }
}

/// A flat sheet rolled onto a cylinder: ½ xi A/R² with the curvature of the discrete arc, of which
/// nothing is lost at the border.
TEST(SymmetricGrid, RolledSheetHasTheBendingEnergyOfItsArc) {
  constexpr double R = 0.5;
  double last = 0;
  for (const int n : {11, 21, 41}) {
    Simulation s = sheet("symmetric", n, n);
    const test::Analytic roll{"roll", [](double a, double b) -> test::Jet {
                                return {Vec3(R * std::sin(a / R), b, R * (1 - std::cos(a / R)))};
                              }};
    const double h = 1.0 / (n - 1), angle = h / R;
    const double inside = 2 * R * (1 - std::cos(angle)) / (h * h);
    // At the border the neighbour's r_11 on the normal of the parabola's tangent.
    const Vec2 tangent = -3 * Vec2(1, 0) + 4 * Vec2(std::cos(angle), std::sin(angle)) -
                         Vec2(std::cos(2 * angle), std::sin(2 * angle));
    const Vec2 towards_centre = -Vec2(std::cos(angle), std::sin(angle));
    const double at_border =
        inside * Vec2(-tangent.y(), tangent.x()).normalized().dot(towards_centre);
    const double expected = 0.5 * kXi11 * ((1 - h) * inside * inside + h * at_border * at_border);
    const double found = s.system().terms().energy(kBending, state_of(s, roll));
    EXPECT_NEAR(found / expected, 1, 1e-10) << n;
    const double continuum = 0.5 * kXi11 / (R * R), error = 1 - found / continuum;
    EXPECT_LT(std::abs(error), 0.5 * h * h / (R * R)) << n;
    if (last != 0) {
      EXPECT_GE(order(last, error), 1.9);
    }
    last = error;
    std::printf("rolled sheet, %2d²: %.6f xi A/R²\n", n, 0.5 * found / continuum);
  }
}

/// A bilinear element with quadrature at its vertices, element by element.
TEST(SymmetricGrid, StretchingIsThatOfBilinearElements) {
  constexpr int n_1 = 7, n_2 = 5;
  constexpr double h_1 = 1.0 / (n_1 - 1), h_2 = 1.0 / (n_2 - 1);
  Simulation s = sheet("symmetric", n_1, n_2);
  const State state = disturbed(s.system().rest(), 0.1);
  const auto r = [&](int i, int j) -> Vec3 { return state.r.row(i + n_1 * j); };
  double energy = 0;
  for (int j = 0; j + 1 < n_2; ++j)
    for (int i = 0; i + 1 < n_1; ++i)
      for (const double x : {0.0, 1.0})
        for (const double y : {0.0, 1.0}) {  // derivatives of the bilinear r(x, y)
          const Vec3 r_1 =
              ((1 - y) * (r(i + 1, j) - r(i, j)) + y * (r(i + 1, j + 1) - r(i, j + 1))) / h_1;
          const Vec3 r_2 =
              ((1 - x) * (r(i, j + 1) - r(i, j)) + x * (r(i + 1, j + 1) - r(i + 1, j))) / h_2;
          energy +=
              h_1 * h_2 / 4 * 0.25 *
              (kEta11 * std::pow(r_1.dot(r_1) - 1, 2) + 2 * kEta12 * std::pow(r_1.dot(r_2), 2) +
               kEta22 * std::pow(r_2.dot(r_2) - 1, 2));
        }
  EXPECT_NEAR(s.system().terms().energy(kStretching, state) / energy, 1, 1e-13);
}

/// Eigenvalues of the second derivative of the energy of a flat sheet, by differences of the force.
Eigen::VectorXd stiffnesses(const std::string& differences, int n_1, int n_2) {
  Simulation s = sheet(differences, n_1, n_2);
  State state{s.system().rest(), NodeVectors::Zero(s.system().nodes(), 3), 0};
  const Index n = state.r.size();
  const auto force = [&] {
    const NodeVectors f = s.system().terms().internal_force(kStretching, state) +
                          s.system().terms().internal_force(kBending, state);
    return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(f.data(), n));
  };
  constexpr double step = 1e-6;
  Eigen::MatrixXd hessian(n, n);
  for (Index k = 0; k < n; ++k) {
    double& x = state.r.data()[k];
    const double at = x;
    x = at + step;
    const Eigen::VectorXd above = force();
    x = at - step;
    hessian.col(k) = -(above - force()) / (2 * step);
    x = at;
  }
  const Eigen::MatrixXd symmetric = (hessian + hessian.transpose()) / 2;
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric, Eigen::EigenvaluesOnly)
      .eigenvalues();
}

/// Nothing but the rigid motions is without resistance.
TEST(SymmetricGrid, OnlyRigidMotionsAreFree) {
  const Eigen::VectorXd found = stiffnesses("symmetric", 7, 6);
  EXPECT_LT(found.head<6>().cwiseAbs().maxCoeff(), 1e-9 * found.tail<1>()[0]);
  EXPECT_GT(found[6], 1e-6 * found.tail<1>()[0]);
  std::printf("eigenvalues: 6th %.1e, 7th %.1e, last %.1e\n", found[5], found[6],
              found.tail<1>()[0]);
}

/// Energies of r = rest + ε s bump e_c, with s = ±1 alternating along a1, a2 or both, over
/// ε² ∫ bump². The bump keeps what a border could resist away.
struct Mode {
  std::string name;
  int component;
  bool along_1, along_2;
};
std::array<double, 2> resistance(const std::string& differences, int n, const Mode& mode) {
  constexpr double epsilon = 1e-7;
  Simulation s = sheet(differences, n, n);
  State state{s.system().rest(), NodeVectors::Zero(n * n, 3), 0};
  double norm = 0;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const Index a = i + n * j;
      const Vec2 at = s.system().surface().parameters().row(a);
      const double bump =
          std::pow(std::sin(std::numbers::pi * at.x()) * std::sin(std::numbers::pi * at.y()), 2);
      const int number = (mode.along_1 ? i : 0) + (mode.along_2 ? j : 0);
      state.r(a, mode.component) += epsilon * (number % 2 == 0 ? 1 : -1) * bump;
      norm += s.system().surface().areas()[a] * std::pow(epsilon * bump, 2);
    }
  return {s.system().terms().energy(kStretching, state) / norm,
          s.system().terms().energy(kBending, state) / norm};
}

TEST(SymmetricGrid, ResistsWhatAlternatesFromNodeToNode) {
  for (const auto& [name, along_1, along_2] :
       {std::tuple{"along both", true, true}, {"along a1", true, false}, {"along a2", false, true}})
    for (const int component : {0, 1}) {
      const Mode mode{name, component, along_1, along_2};
      const double e_ii = component == 0 ? kEta11 : kEta22;
      const bool lengthwise = component == 0 ? along_1 : along_2,
                 crosswise = component == 0 ? along_2 : along_1;
      // Edges along the component change by 2 ε, so G by 4 ε/h; those across shear by 2 ε/h.
      const double expected = (lengthwise ? 4 * e_ii : 0) + (crosswise ? 2 * kEta12 : 0);
      const auto times_h2 = [&](const char* differences, int n) {
        return resistance(differences, n, mode)[kStretching] / std::pow(n - 1, 2);
      };
      EXPECT_NEAR(times_h2("symmetric", 65) / expected, 1, 0.03) << name << " of " << component;
      // Central differences see the bump alone: less by h² at each refinement.
      EXPECT_LT(times_h2("central", 65), 0.02 * expected) << name << " of " << component;
      EXPECT_GT(times_h2("central", 33) / times_h2("central", 65), 3.5)
          << name << " of " << component;
    }
  for (const auto& [along_1, along_2] : {std::pair{true, true}, {true, false}, {false, true}}) {
    // Across a flat sheet stretching is of fourth order; second differences are 4 ε/h².
    const double found =
        resistance("symmetric", 65, {"", 2, along_1, along_2})[kBending] / std::pow(64, 4);
    const double expected = 8 * ((along_1 ? kXi11 : 0) + (along_2 ? kXi22 : 0));
    EXPECT_NEAR(found / expected, 1, 0.03) << along_1 << along_2;
  }
}

/// A closed tube blown up by a factor: both energies are the discrete rest forms' times a number.
TEST(SymmetricGrid, TubeClosesAndSwells) {
  constexpr int n_1 = 24, n_2 = 9;
  constexpr double radius = 1 / (2 * std::numbers::pi), s = 0.1;
  Simulation tube = sheet("symmetric", n_1, n_2,
                          R"(, "periodic": [true, false],
                             "rest": {"plugin": "arc", "radius": 0.15915494309189535})");
  const SampleSet& membrane = tube.system().surface().samples(SampleRole::membrane);
  EXPECT_EQ(membrane.size(), 4 * n_1 * (n_2 - 1));
  State state{tube.system().rest(), NodeVectors::Zero(n_1 * n_2, 3), 0};
  EXPECT_EQ(tube.system().terms().energy(kStretching, state), 0);
  EXPECT_EQ(tube.system().terms().energy(kBending, state), 0);
  // Its axis runs along y.
  const Eigen::RowVector3d middle = state.r.colwise().mean();
  for (const int c : {0, 2})
    state.r.col(c) = middle[c] + (1 + s) * (state.r.col(c).array() - middle[c]);
  const double h = 1.0 / n_1, half = std::numbers::pi / n_1;
  const double chord = 2 * radius * std::sin(half) / h,
               curvature = 4 * radius * std::pow(std::sin(half) / h, 2);
  EXPECT_NEAR(tube.system().terms().energy(kStretching, state) /
                  (0.25 * kEta11 * std::pow(((1 + s) * (1 + s) - 1) * chord * chord, 2)),
              1, 1e-10);
  EXPECT_NEAR(
      tube.system().terms().energy(kBending, state) / (0.5 * kXi11 * std::pow(s * curvature, 2)), 1,
      1e-10);
}

TEST(SymmetricGrid, IsTheDefaultAndNeedsItsBorderAndWeights) {
  const auto scene = [](const std::string& surface) {
    return R"({"surface": {"plugin": "grid", "nodes": [4, 4])" + surface +
           R"(}, "integrator": {"plugin": "semi_implicit", "step": 0.1}, "duration": 0.1})";
  };
  const Simulation s = simulation_from_text(scene(""));
  EXPECT_EQ(s.scene().surface().parameters->get<std::string>("differences"), "symmetric");
  const auto message = [&](const std::string& surface) -> std::string {
    try {
      const Simulation refused = simulation_from_text(scene(surface));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  const std::string said = message(R"(, "border": "paper", "weights": "equal")");
  EXPECT_NE(said.find("at /surface/border: found \"paper\", expected \"one_sided\""), said.npos)
      << said;
  EXPECT_NE(said.find("at /surface/weights: found \"equal\", expected \"area\""), said.npos)
      << said;
  EXPECT_EQ(message(R"(, "differences": "forward", "border": "paper", "weights": "equal")"), "");
}

}  // namespace
}  // namespace deform
