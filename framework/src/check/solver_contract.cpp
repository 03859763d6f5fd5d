/// Linear solvers: residuals of a few systems, other values in the same pattern, memory.
#include <random>

#include <Eigen/Dense>

#include "deform/solve/linear_solver.h"

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
  const std::string why_not = solver.factor(sparse(a));
  checks.holds("factorises regular matrices that suit it", why_not.empty(), why_not);
  MatrixXd x = MatrixXd::Zero(a.rows(), 3);
  if (why_not.empty()) solver.solve(right_hand_sides(a.rows()), x);
  return x;
}

void check_matrices(const Subject& subject, const Terrain& terrain, bool symmetric,
                    Checks& checks) {
  const auto made = [&] { return subject.make<LinearSolver>(terrain).object; };
  for (const Index n : {1, 2, 7, 40, 150}) {
    const MatrixTraits traits{.size = n, .symmetric = symmetric, .positive_definite = symmetric};
    const auto solver = made();
    solver->analyse(sparse(random_matrix(n, 1, symmetric)), traits);
    for (const unsigned seed : {1U, 2U, 3U}) {  // analysed once, other values in the same pattern
      const MatrixXd a = random_matrix(n, seed, symmetric);
      const MatrixXd b = right_hand_sides(n), x = solution(*solver, a, checks);
      checks.below(
          symmetric ? "|A x − b| / |b|, symmetric definite" : "|A x − b| / |b|, unsymmetric",
          (a * x - b).norm() / b.norm(), 1e-8);
      const auto fresh = made();
      fresh->analyse(sparse(a), traits);
      checks.holds("remembers nothing of earlier values", solution(*fresh, a, checks) == x,
                   "a fresh object gives other bits");
    }
  }
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
  solver.analyse(pattern, {.size = 30, .symmetric = symmetric, .positive_definite = symmetric});
  const std::string why = solver.factor(singular);
  checks.report("on a singular matrix", why.empty() ? "says nothing" : "says: " + why);
}

}  // namespace

void check_solver_contract(const Subject& subject, Checks& checks) {
  const Terrain terrain = terrains(9, 7).front();
  bool suits_the_run = false;  // whose matrix is symmetric
  checks.runs("solves", [&] {
    const auto solver = subject.make<LinearSolver>(terrain).object;
    bool is_of_use = false;
    for (const bool symmetric : {true, false}) {
      const MatrixTraits traits{.size = 9, .symmetric = symmetric, .positive_definite = symmetric};
      const double suitability = solver->suitability(traits);
      checks.report(symmetric ? "suitability for symmetric definite matrices"
                              : "suitability for unsymmetric matrices",
                    suitability);
      if (suitability <= 0) continue;
      is_of_use = true;
      suits_the_run = suits_the_run || symmetric;
      check_matrices(subject, terrain, symmetric, checks);
      report_singular(*solver, symmetric, checks);
    }
    checks.holds("suits some matrices", is_of_use, "its suitability is 0 for all");
  });
  if (suits_the_run) check_run(subject, checks);
}

}  // namespace deform
