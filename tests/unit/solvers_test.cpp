#include <dlfcn.h>
#include <random>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "deform/solve/linear_solver.h"

#include "support/builtin.h"

namespace deform {
namespace {

using Eigen::MatrixXd;
using test::make_builtin;
using test::parameters;

// About five entries a row, in a symmetric pattern, diagonal included; the same for the same n.
MatrixXd random_pattern(Index n) {
  std::mt19937 generator(static_cast<unsigned>(n));
  std::uniform_int_distribution<Index> node(0, n - 1);
  MatrixXd pattern = MatrixXd::Identity(n, n);
  for (Index k = 0; k < 2 * n; ++k) {
    const Index i = node(generator), j = node(generator);
    pattern(i, j) = pattern(j, i) = 1;
  }
  return pattern;
}

MatrixXd random_unsymmetric(Index n, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const MatrixXd a = MatrixXd::NullaryExpr(n, n, [&] { return uniform(generator); });
  return (random_pattern(n).array() * a.array()).matrix() + 2 * MatrixXd::Identity(n, n);
}

// Diagonally dominant, hence positive definite.
MatrixXd random_definite(Index n, unsigned seed) {
  const MatrixXd a = random_unsymmetric(n, seed);
  MatrixXd symmetric = a + a.transpose();
  symmetric.diagonal() = symmetric.cwiseAbs().rowwise().sum().array() + 0.1;
  return symmetric;
}

// Entries where `pattern` is not zero.
SparseMatrix sparse(const MatrixXd& a, const MatrixXd& pattern) {
  SparseMatrix s;
  s.size = a.rows();
  for (Index i = 0; i < a.rows(); ++i) {
    for (Index j = 0; j < a.cols(); ++j) {
      if (pattern(i, j) == 0) continue;
      s.column.push_back(static_cast<std::int32_t>(j));
      s.value.push_back(a(i, j));
    }
    s.row_begin.push_back(static_cast<std::int32_t>(s.column.size()));
  }
  return s;
}

// Factorises and solves with k right-hand sides; they and the solution are parts of larger
// matrices.
void expect_solves(LinearSolver& solver, const MatrixXd& a, const SparseMatrix& s, Index k) {
  ASSERT_EQ(solver.factor(s).reason, "");
  const MatrixXd b = MatrixXd::Random(a.rows() + 3, k);
  MatrixXd x = MatrixXd::Zero(a.rows() + 2, k);
  solver.solve(b.topRows(a.rows()), x.topRows(a.rows()));
  const MatrixXd reference = a.partialPivLu().solve(b.topRows(a.rows()));
  // The condition numbers are below 1e4.
  EXPECT_LT((x.topRows(a.rows()) - reference).norm(), 1e-11 * reference.norm());
  EXPECT_EQ(x.bottomRows(2).norm(), 0);
}

MatrixTraits traits_of(const MatrixXd& a) {
  const bool symmetric = a == a.transpose();
  return {.size = a.rows(), .symmetric = symmetric, .positive_definite = symmetric};
}

struct SolverCase {
  std::string name;
  ParameterValues values;
  bool symmetric;
  friend void PrintTo(const SolverCase& c, std::ostream* out) {
    *out << c.name << (c.symmetric ? ", symmetric" : ", unsymmetric");
  }
};

class Solvers : public testing::TestWithParam<SolverCase> {
 public:
  [[nodiscard]] std::shared_ptr<LinearSolver> make() const {
    return make_builtin<LinearSolver>(GetParam().name, GetParam().values);
  }
  [[nodiscard]] MatrixXd random_matrix(Index n, unsigned seed) const {
    return GetParam().symmetric ? random_definite(n, seed) : random_unsymmetric(n, seed);
  }
};

TEST_P(Solvers, AgreeWithDenseLu) {
  for (const Index n : {1, 2, 7, 40, 150}) {
    const auto solver = make();
    const MatrixXd a = random_matrix(n, 1);
    const SparseMatrix s = sparse(a, random_pattern(n));
    solver->analyse(s, traits_of(a));
    expect_solves(*solver, a, s, 3);
  }
}

TEST_P(Solvers, RefactoriseWithTheSamePattern) {
  const Index n = 60;
  const MatrixXd pattern = random_pattern(n);
  const auto solver = make();
  for (const unsigned seed : {1u, 2u, 3u}) {
    const MatrixXd a = random_matrix(n, seed);
    const SparseMatrix s = sparse(a, pattern);
    if (seed == 1) solver->analyse(s, traits_of(a));
    for (const Index k : {3, 1, 5}) expect_solves(*solver, a, s, k);
  }
}

TEST_P(Solvers, AnalyseOtherPatterns) {
  const auto solver = make();
  for (const Index n : {50, 20, 80}) {
    const MatrixXd a = random_matrix(n, 4);
    const SparseMatrix s = sparse(a, random_pattern(n));
    solver->analyse(s, traits_of(a));
    expect_solves(*solver, a, s, 3);
  }
}

TEST_P(Solvers, DoNotRememberEarlierValues) {
  const Index n = 60;
  const MatrixXd a = random_matrix(n, 1), b = MatrixXd::Random(n, 3);
  const SparseMatrix s = sparse(a, random_pattern(n));
  const SparseMatrix other = sparse(random_matrix(n, 2), random_pattern(n));
  MatrixXd fresh(n, 3), later(n, 3);
  const auto solver = make(), used = make();
  solver->analyse(s, traits_of(a));
  ASSERT_EQ(solver->factor(s).reason, "");
  solver->solve(b, fresh);
  used->analyse(other, traits_of(a));
  ASSERT_EQ(used->factor(other).reason, "");
  ASSERT_EQ(used->factor(s).reason, "");
  used->solve(b, later);
  EXPECT_EQ(fresh, later);  // bit by bit
}

TEST_P(Solvers, GiveAReasonForSingularMatricesAndRecover) {
  const Index n = 30;
  const MatrixXd pattern = random_pattern(n);
  const MatrixXd good = random_matrix(n, 1);
  MatrixXd zero_row = good;
  zero_row.row(17).setZero(), zero_row.col(17).setZero();
  MatrixXd floating = good;  // rows sum to zero, like a sheet that nothing holds
  floating.diagonal().setZero();
  floating.diagonal() = -floating.rowwise().sum();
  if (GetParam().symmetric) {
    floating = -good.cwiseAbs();
    floating.diagonal().setZero();
    floating.diagonal() = -floating.rowwise().sum();
  }
  MatrixXd not_a_number = good;
  not_a_number(4, 4) = std::numeric_limits<double>::quiet_NaN();
  const auto solver = make();
  const SparseMatrix s = sparse(good, pattern);
  solver->analyse(s, traits_of(good));
  for (const MatrixXd& bad : {zero_row, floating, not_a_number}) {
    EXPECT_NE(solver->factor(sparse(bad, pattern)).reason, "");
    expect_solves(*solver, good, s, 3);
  }
}

TEST_P(Solvers, TakeAnEmptyMatrix) {
  const auto solver = make();
  const SparseMatrix nothing;
  solver->analyse(nothing, {});
  EXPECT_EQ(solver->factor(nothing).reason, "");
  MatrixXd x(0, 3);
  solver->solve(MatrixXd(0, 3), x);
}

TEST_P(Solvers, KeepBlasOnOneThread) {
  const auto solver = make();
  void* blas = dlopen("libopenblas.so.0", RTLD_LAZY | RTLD_NOLOAD);
  if (blas == nullptr) GTEST_SKIP() << "another BLAS than OpenBLAS";
  const auto threads = reinterpret_cast<int (*)()>(dlsym(blas, "openblas_get_num_threads"));
  ASSERT_NE(threads, nullptr);
  EXPECT_EQ(threads(), 1);
  dlclose(blas);
}

SolverCase cholmod_case(const std::string& ordering, const std::string& supernodal) {
  return {"cholmod", parameters({{"ordering", ordering}, {"supernodal", supernodal}}), true};
}
INSTANTIATE_TEST_SUITE_P(
    Builtin, Solvers,
    testing::Values(SolverCase{"cholmod", {}, true}, cholmod_case("amd", "always"),
                    cholmod_case("metis", "never"), cholmod_case("natural", "never"),
                    cholmod_case("natural", "always"), SolverCase{"umfpack", {}, false},
                    SolverCase{"umfpack", {}, true}, SolverCase{"eigen_lu", {}, false},
                    SolverCase{"eigen_lu", {}, true}));

TEST(Cholmod, NamesTheColumnWhereDefinitenessEnds) {
  for (const std::string supernodal : {"never", "always"}) {
    const auto solver =
        make_builtin<LinearSolver>("cholmod", parameters({{"supernodal", supernodal}}));
    const MatrixXd pattern = random_pattern(30);
    MatrixXd a = random_definite(30, 1);
    a(17, 17) = -1;
    solver->analyse(sparse(a, pattern), traits_of(a));
    EXPECT_EQ(solver->factor(sparse(a, pattern)).reason, "not positive definite (at column 17)");
  }
}

TEST(Cholmod, RefusesIndefiniteMatricesThatHaveAnLdlFactor) {
  const auto solver = make_builtin<LinearSolver>("cholmod");
  MatrixXd a = MatrixXd::Identity(4, 4);
  a(2, 2) = -1;
  const SparseMatrix s = sparse(a, a);
  solver->analyse(s, traits_of(a));
  EXPECT_NE(solver->factor(s).reason, "");
}

TEST(Umfpack, SolvesIndefiniteMatrices) {
  const auto solver = make_builtin<LinearSolver>("umfpack");
  MatrixXd a(3, 3);
  a << 0, 1, 0, 2, 0, 3, 0, 4, 5;  // zeros on the diagonal, but regular
  const SparseMatrix s = sparse(a, MatrixXd::Ones(3, 3));
  solver->analyse(s, {.size = 3});
  expect_solves(*solver, a, s, 2);
}

TEST(Suitability, PrefersCholeskyWhereItFits) {
  const auto cholmod = make_builtin<LinearSolver>("cholmod");
  const auto umfpack = make_builtin<LinearSolver>("umfpack");
  const MatrixTraits symmetric{.size = 9, .symmetric = true, .positive_definite = true};
  const MatrixTraits unsymmetric{.size = 9};
  EXPECT_GT(cholmod->suitability(symmetric), umfpack->suitability(symmetric));
  EXPECT_EQ(cholmod->suitability(unsymmetric), 0);
  EXPECT_GT(umfpack->suitability(unsymmetric), 0);
}

}  // namespace
}  // namespace deform
