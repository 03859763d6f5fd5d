/// Linear solvers: residuals of a few systems, other values in the same pattern, memory.
#include <numeric>
#include <random>
#include <set>
#include <span>

#include <Eigen/Dense>

#include "deform/solve/linear_solver.h"
#include "deform/surface/surface.h"

#include "check/bitwise.h"
#include "check/contracts.h"

namespace deform {
namespace {

using Eigen::MatrixXd;

/// About five entries a row in a symmetric pattern, diagonally dominant; the same for the same n
/// and seed, the pattern whatever the seed.
MatrixXd random_matrix(Index n, unsigned seed, bool symmetric) {
  std::mt19937 places(static_cast<unsigned>(n)), values(seed);
  std::uniform_int_distribution<Index> node(0, n - 1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  MatrixXd a = MatrixXd::Zero(n, n);
  for (Index k = 0; k < 2 * n; ++k) {
    const Index i = node(places), j = node(places);
    a(i, j) = uniform(values);
    a(j, i) = symmetric ? a(i, j) : uniform(values);
  }
  a.diagonal().setZero();
  a.diagonal() = a.cwiseAbs().rowwise().sum().array() + 0.1;
  return a;
}

SparseMatrix sparse(const MatrixXd& a) {
  SparseMatrix s;
  s.size = a.rows();
  for (Index i = 0; i < a.rows(); ++i) {
    for (Index j = 0; j < a.cols(); ++j) {
      if (a(i, j) == 0 && a(j, i) == 0) continue;
      s.column.push_back(static_cast<std::int32_t>(j));
      s.value.push_back(a(i, j));
    }
    s.row_begin.push_back(static_cast<std::int32_t>(s.column.size()));
  }
  return s;
}

MatrixXd right_hand_sides(Index n) {
  return MatrixXd::NullaryExpr(n, 3, [](Index i, Index j) { return std::sin(double(7 * i + j)); });
}

MatrixXd solution(LinearSolver& solver, const MatrixXd& a, Checks& checks) {
  const std::string why_not = solver.factor(sparse(a)).reason;
  checks.holds("factorises regular matrices that suit it", why_not.empty(), why_not);
  MatrixXd x = MatrixXd::Zero(a.rows(), 3);
  if (why_not.empty()) solver.solve(right_hand_sides(a.rows()), x);
  return x;
}

/// Unknowns that belong to the nodes of the terrain, or to none that the solver is told of.
MatrixTraits traits_of(Index n, bool symmetric, std::span<const std::int32_t> nodes = {}) {
  return {.size = n, .symmetric = symmetric, .positive_definite = symmetric, .nodes = nodes};
}

/// From guesses far from the solution and close to it: where the tolerance were one of B, the
/// latter would be left as they are.
void check_improvement(LinearSolver& solver, const MatrixXd& a, const MatrixXd& x, Checks& checks) {
  constexpr double kTolerance = 1e-6;
  if (!solver.factor(sparse(a)).reason.empty()) return;
  const MatrixXd b = right_hand_sides(a.rows());
  for (const double distance : {1e-2, 1e-7}) {
    const MatrixXd guess = x + distance * x.cwiseAbs().maxCoeff() * b;
    MatrixXd improved = guess;
    solver.improve(b, kTolerance, improved);
    const double rounding = 1e-13 * b.norm();
    checks.below("|A x − b| / |A x₀ − b|, from a guess x₀, tolerance 1e-6",
                 (a * improved - b).norm() / ((a * guess - b).norm() + rounding / kTolerance),
                 10 * kTolerance);
  }
}

void check_matrices(const Subject& subject, const Terrain& terrain, bool symmetric,
                    std::span<const std::int32_t> nodes, Checks& checks) {
  const auto made = [&] { return subject.make<LinearSolver>(terrain).object; };
  std::vector<Index> sizes{1, 2, 7, 40, 150};
  if (!nodes.empty()) sizes = {static_cast<Index>(nodes.size())};
  for (const Index n : sizes) {
    const MatrixTraits traits = traits_of(n, symmetric, nodes);
    const auto solver = made();
    solver->analyse(sparse(random_matrix(n, 1, symmetric)), traits);
    for (const unsigned seed : {1U, 2U, 3U}) {  // analysed once, other values in the same pattern
      const MatrixXd a = random_matrix(n, seed, symmetric);
      const MatrixXd b = right_hand_sides(n), x = solution(*solver, a, checks);
      checks.below(
          symmetric ? "|A x − b| / |b|, symmetric definite" : "|A x − b| / |b|, unsymmetric",
          (a * x - b).norm() / b.norm(), 1e-8);
      check_improvement(*solver, a, x, checks);
      const auto fresh = made();
      fresh->analyse(sparse(a), traits);
      checks.holds("remembers nothing of earlier values", solution(*fresh, a, checks) == x,
                   "a fresh object gives other bits");
    }
  }
}

/// Links along the faces, each resisting what it is stretched and turned by differently; every node
/// held a little.
BlockMatrix block_matrix(const Surface& surface, double sign) {
  BlockMatrix k;
  k.nodes = surface.nodes();
  std::vector<std::set<Index>> columns(static_cast<std::size_t>(k.nodes));
  const Faces& faces = surface.faces();
  const auto each_link = [&](const auto& visit) {
    for (std::size_t f = 0; f < static_cast<std::size_t>(faces.size()); ++f)
      for (auto i = faces.begin[f]; i + 1 < faces.begin[f + 1]; ++i) {
        const Index a = faces.nodes[static_cast<std::size_t>(i)],
                    b = faces.nodes[static_cast<std::size_t>(i) + 1];
        visit(std::min(a, b), std::max(a, b));
      }
  };
  each_link([&](Index a, Index b) { columns[static_cast<std::size_t>(a)].insert(b); });
  for (Index a = 0; a < k.nodes; ++a) {
    columns[static_cast<std::size_t>(a)].insert(a);
    for (const Index b : columns[static_cast<std::size_t>(a)])
      k.column.push_back(static_cast<std::int32_t>(b));
    k.row_begin.push_back(static_cast<std::int32_t>(k.column.size()));
  }
  k.value.assign(9 * k.column.size(), 0.0);
  each_link([&](Index a, Index b) {
    const Vec3 along = Vec3(std::sin(double(a)), std::cos(double(b)), 1).normalized();
    const Eigen::Matrix3d link =
        sign * (10 * along * along.transpose() + Eigen::Matrix3d::Identity());
    k.block(a, a) += link;
    k.block(b, b) += link;
    k.block(a, b) -= link;
  });
  for (Index a = 0; a < k.nodes; ++a) k.block(a, a) += 0.01 * sign * Eigen::Matrix3d::Identity();
  return k;
}

void check_blocks(const Subject& subject, const Terrain& terrain, Checks& checks) {
  const Made<LinearSolver> made = subject.make<LinearSolver>(terrain);
  BlockSolver& solver = *made.object->blocks();
  const BlockMatrix k = block_matrix(*made.surface, 1);
  checks.report("suitability for matrices of blocks", solver.block_suitability(k.nodes));
  std::vector<std::uint8_t> held(static_cast<std::size_t>(k.nodes), 0);
  held[0] = 7, held[5] = 2;
  solver.analyse(k, held);
  const NodeValues d = NodeValues::Constant(k.nodes, 0.1);
  NodeBlocks blocks = NodeBlocks::Zero(k.nodes, 6);  // of contact along (1, 2, 3), here and there
  for (Index a = 0; a < k.nodes; a += 3) blocks.row(a) << 1, 2, 3, 4, 6, 9;
  NodeVectors b = right_hand_sides(k.nodes), x, again, product;
  const auto hold = [](NodeVectors& v) { v.row(0).setZero(), v(5, 1) = 0; };
  const auto factor = [&](const BlockMatrix& matrix) {
    for (Index a = 0; a < matrix.nodes; ++a) solver.put(matrix.row(a));
    solver.factor(d, blocks, true);
  };
  factor(k);
  checks.holds("solves with definite matrices of blocks",
               solver.solve(b, 1e-5, x) == Outcome::solved, "it says that it does not");
  NodeVectors kept = x;
  hold(kept);
  checks.holds("leaves held components at 0", kept == x, "they move");
  k.multiply(x, product);
  product += d.asDiagonal() * x;
  for (Index a = 0; a < k.nodes; a += 3)
    product.row(a) += x.row(a).dot(Eigen::RowVector3d(1, 2, 3)) * Eigen::RowVector3d(1, 2, 3);
  hold(product), hold(b);
  checks.below("|A x − b| / |b|, blocks, tolerance 1e-5", (product - b).norm() / b.norm(), 1e-3);
  const BlockMatrix negative = block_matrix(*made.surface, -1);
  factor(negative);
  checks.holds("says that a matrix of blocks is not positive definite",
               solver.solve(b, 1e-5, again) == Outcome::indefinite, "it solves with it");
  factor(k);
  checks.holds("a renewed matrix of blocks remembers nothing of earlier ones",
               solver.solve(b, 1e-5, again) == Outcome::solved && again == x, "other bits");
}

void report_singular(LinearSolver& solver, bool symmetric, Checks& checks) {
  MatrixXd a = random_matrix(30, 1, symmetric);
  const SparseMatrix pattern = sparse(a);
  SparseMatrix singular = pattern;
  for (Index i = 0; i < 30; ++i)
    for (std::int32_t p = pattern.row_begin[static_cast<std::size_t>(i)];
         p < pattern.row_begin[static_cast<std::size_t>(i) + 1]; ++p)
      if (i == 17 || pattern.column[static_cast<std::size_t>(p)] == 17)
        singular.value[static_cast<std::size_t>(p)] = 0;
  solver.analyse(pattern, traits_of(30, symmetric));
  const std::string why = solver.factor(singular).reason;
  checks.report("on a singular matrix", why.empty() ? "says nothing" : "says: " + why);
}

}  // namespace

void check_solver_contract(const Subject& subject, Checks& checks) {
  const Terrain terrain = terrains(9, 7).front();
  bool suits_the_run = false;  // whose matrix is symmetric
  checks.runs("solves", [&] {
    const Made<LinearSolver> made = subject.make<LinearSolver>(terrain);
    const auto& solver = made.object;
    bool is_of_use = false;
    std::vector<std::int32_t> all(static_cast<std::size_t>(made.surface->nodes()));
    std::iota(all.begin(), all.end(), 0);
    for (const bool symmetric : {true, false})
      for (const std::span<const std::int32_t> nodes : {std::span<const std::int32_t>(), {all}}) {
        const Index n = nodes.empty() ? 9 : made.surface->nodes();
        const double suitability = solver->suitability(traits_of(n, symmetric, nodes));
        checks.report(std::string("suitability for ") +
                          (symmetric ? "symmetric definite" : "unsymmetric") + " matrices" +
                          (nodes.empty() ? "" : " with an unknown a node"),
                      suitability);
        if (suitability <= 0) continue;
        is_of_use = true;
        suits_the_run = suits_the_run || symmetric;
        check_matrices(subject, terrain, symmetric, nodes, checks);
        if (nodes.empty()) report_singular(*solver, symmetric, checks);
      }
    if (solver->blocks() != nullptr) {
      is_of_use = true;
      check_blocks(subject, terrain, checks);
    }
    checks.holds("suits some matrices", is_of_use, "its suitability is 0 for all");
  });
  if (suits_the_run) check_run(subject, checks);
}

}  // namespace deform
