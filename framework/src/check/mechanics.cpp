#include "deform/check/mechanics.h"

#include <cmath>
#include <random>

#include <Eigen/Eigenvalues>

#include "deform/solve/newton_matrix.h"

#include "check/noise.h"

namespace deform {
namespace {

Eigen::MatrixXd dense(const SparseMatrix& k) {
  Eigen::MatrixXd full = Eigen::MatrixXd::Zero(k.size, k.size);
  for (Index a = 0; a < k.size; ++a) {
    const auto row = static_cast<std::size_t>(a);
    for (auto p = static_cast<std::size_t>(k.row_begin[row]);
         p < static_cast<std::size_t>(k.row_begin[row + 1]); ++p)
      full(a, k.column[p]) = k.value[p];
  }
  return full;
}

double ratio(double part, double whole) { return part == 0 ? 0 : part / whole; }

NodeVectors random_directions(Index nodes) {
  std::mt19937 random(54321);
  std::uniform_real_distribution<double> uniform(-1, 1);
  return NodeVectors::NullaryExpr(nodes, 3, [&] { return uniform(random); });
}

/// K x of the exact tangent.
NodeVectors tangent_times(const System& system, const State& state, const NodeVectors& x) {
  NewtonMatrix tangent(system);
  tangent.evaluate(state);
  NodeVectors product;
  tangent.matrix().multiply(x, product);
  return product;
}

/// The factor of x that moves the nodes by about the surface's size.
double tangent_scale(const NodeVectors& r, const NodeVectors& x) {
  return (r.rowwise() - r.colwise().mean()).norm() / x.norm();
}

/// The change of the whole force along x.
Difference<NodeVectors> change_of_force(const System& system, State state, const NodeVectors& x) {
  const NodeVectors r = state.r;
  const double scale = tangent_scale(r, x);
  const auto force_at = [&](double s) {
    state.r = r + s * x;
    return system.evaluator().force(state);
  };
  return difference_of(force_at, 1e-4 * scale, 1e-8 * scale);
}

}  // namespace

State disturbed(const NodeVectors& rest, double strain) {
  State state{rest, NodeVectors::Zero(rest.rows(), 3), 0};
  std::mt19937 random(12345);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (Index a = 0; a < state.r.rows(); ++a) {
    const Vec3 r = state.r.row(a);
    const Vec3 smooth(0.3 * std::sin(2 * r.y()), 0.2 * std::cos(3 * r.x()),
                      std::sin(3 * r.x() + r.y()));
    for (int c = 0; c < 3; ++c) state.r(a, c) += strain * (smooth[c] + 0.02 * uniform(random));
  }
  return state;
}

State disturbed(const System& system, double strain) {
  State state = system.at_rest();
  state.r.topRows(system.nodes()) = disturbed(system.rest(), strain).r;
  std::mt19937 random(4321);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (Index a = system.nodes(); a < system.rows(); ++a) state.r(a, 0) += strain * uniform(random);
  return state;
}

double gradient_error(const System& system, std::size_t term, State state) {
  constexpr double h = 1e-5;
  const NodeVectors force = system.terms().internal_force(term, state);
  NodeVectors difference(force.rows(), 3);
  for (Index a = 0; a < force.rows(); ++a)
    for (int c = 0; c < 3; ++c) {
      const double r = state.r(a, c);
      const auto energy_at = [&](double x) {
        state.r(a, c) = x;
        return system.terms().energy(term, state);
      };
      difference(a, c) = -(8 * (energy_at(r + h) - energy_at(r - h)) -
                           (energy_at(r + 2 * h) - energy_at(r - 2 * h))) /
                         (12 * h);
      state.r(a, c) = r;
    }
  return ratio((force - difference).norm(), force.norm());
}

double lagged_error(const System& system, std::size_t term, const State& state) {
  const NodeVectors force = system.terms().internal_force(term, state);
  const auto [k, c] = system.terms().lagged_force(term, state);
  return ratio((force - (c - dense(k) * state.r)).norm(), force.norm());
}

double gradient_resolution(const System& system, std::size_t term, State state) {
  constexpr double h = 1e-5, spacing = 1e-9;
  const NodeVectors r = state.r, x = random_directions(r.rows());
  const auto energy_at = [&](double s) {
    state.r = r + s * x;
    return Eigen::Matrix<double, 1, 1>(system.terms().energy(term, state));
  };
  const auto force_at = [&](double s) {
    state.r = r + s * x;
    return system.terms().internal_force(term, state);
  };
  // Of each component of the gradient: those of the derivative along x, which moves all at once,
  // are of the same kind.
  const double components = std::sqrt(3.0 * static_cast<double>(r.rows()));
  const double rounding = components * std::sqrt(130.0) / (12 * h) * noise_of(energy_at, spacing);
  return ratio(rounding + noise_of(force_at, spacing), force_at(0).norm());
}

double tangent_error(const System& system, State state) {
  const NodeVectors x = random_directions(state.r.rows());
  const NodeVectors product = tangent_times(system, state, x);
  const auto found = change_of_force(system, state, x);
  return ratio((product + found.derivative).norm(), product.norm());
}

double tangent_resolution(const System& system, State state) {
  const NodeVectors r = state.r, x = random_directions(r.rows());
  const double open = change_of_force(system, state, x).error;
  const auto product_at = [&](double s) {
    state.r = r + s * x;
    return tangent_times(system, state, x);
  };
  const double rounding = noise_of(product_at, 1e-8 * tangent_scale(state.r, x));
  return ratio(open + rounding, product_at(0).norm());
}

double tangent_indefiniteness(const System& system, const State& state, Tangent kind) {
  NewtonMatrix tangent(system);
  tangent.evaluate(state, {.kind = kind});
  const Index n = 3 * system.rows();
  Eigen::MatrixXd full(n, n);
  NodeVectors x = NodeVectors::Zero(system.rows(), 3), y;
  for (Index j = 0; j < n; ++j) {
    x(j / 3, j % 3) = 1;
    tangent.matrix().multiply(x, y);
    for (Index i = 0; i < n; ++i) full(i, j) = y(i / 3, i % 3);
    x(j / 3, j % 3) = 0;
  }
  const Eigen::VectorXd values =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(full, Eigen::EigenvaluesOnly).eigenvalues();
  return ratio(std::max(0.0, -values.minCoeff()), values.cwiseAbs().maxCoeff());
}

Momenta momenta(const NodeVectors& force, const NodeVectors& r) {
  const Vec3 centre = r.colwise().mean();
  Vec3 sum = Vec3::Zero(), torque = Vec3::Zero();
  double force_scale = 0, torque_scale = 0;
  for (Index a = 0; a < force.rows(); ++a) {
    const Vec3 f = force.row(a), arm = Vec3(r.row(a)) - centre;
    sum += f;
    torque += arm.cross(f);
    force_scale += f.norm();
    torque_scale += arm.norm() * f.norm();
  }
  return {ratio(sum.norm(), force_scale), ratio(torque.norm(), torque_scale)};
}

double asymmetry(const SparseMatrix& k) {
  const Eigen::MatrixXd full = dense(k);
  return ratio((full - full.transpose()).norm(), full.norm());
}

double indefiniteness(const SparseMatrix& k) {
  const Eigen::MatrixXd full = dense(k);
  const Eigen::MatrixXd symmetric = 0.5 * (full + full.transpose());
  const Eigen::VectorXd values =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric, Eigen::EigenvaluesOnly)
          .eigenvalues();
  const double largest = values.cwiseAbs().maxCoeff();
  return ratio(-values.minCoeff(), largest);
}

}  // namespace deform
