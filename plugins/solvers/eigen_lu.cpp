#include <cmath>
#include <limits>

#include <Eigen/SparseLU>

#include <deform/solve/linear_solver.h>

namespace {
using namespace deform;

/// P A Q = L U by Eigen: slower than SuiteSparse, but under a permissive licence, so that a
/// distribution without the GPL solvers still runs every scene; and an independent implementation
/// to hold them against.
class EigenLu final : public LinearSolver {
 public:
  EigenLu(const NoParameters& /*parameters*/, const Setup& /*setup*/) {}

  [[nodiscard]] double suitability(const MatrixTraits& /*traits*/) const override { return 1; }

  void analyse(const SparseMatrix& a, const MatrixTraits& /*traits*/) override {
    if (a.size > 0) lu_.analyzePattern(columns_of(a));
  }

  [[nodiscard]] Factorisation factor(const SparseMatrix& a) override {
    for (const double value : a.value)
      if (!std::isfinite(value)) return "an entry is not finite";
    if (a.size == 0) return "";
    const Columns columns = columns_of(a);
    lu_.factorize(columns);
    if (lu_.info() != Eigen::Success) return "singular (" + lu_.lastErrorMessage() + ")";
    return is_singular_to_working_precision(columns) ? "singular to working precision" : "";
  }

  void solve(const Eigen::Ref<const Eigen::MatrixXd>& b, Eigen::Ref<Eigen::MatrixXd> x) override {
    if (b.rows() == 0) return;
    solution_ = lu_.solve(
        b);  // not into x: SparseLU takes its columns for contiguous, which a Ref's need not be
    x = solution_;
  }

 private:
  using Columns = Eigen::SparseMatrix<double, Eigen::ColMajor, std::int32_t>;
  using Rows = Eigen::SparseMatrix<double, Eigen::RowMajor, std::int32_t>;

  /// SparseLU stops at pivots that are exactly 0 only: a solution as large as 1/ε betrays the
  /// others.
  [[nodiscard]] bool is_singular_to_working_precision(const Columns& a) const {
    const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(a.rows(), 1, 2);
    const Eigen::VectorXd x = lu_.solve(b);
    const double scale = a.coeffs().abs().maxCoeff();
    return !(x.lpNorm<Eigen::Infinity>() * scale * std::numeric_limits<double>::epsilon() <
             b.lpNorm<Eigen::Infinity>());
  }

  static Columns columns_of(const SparseMatrix& a) {
    return Columns(Eigen::Map<const Rows>(a.size, a.size, static_cast<Index>(a.value.size()),
                                          a.row_begin.data(), a.column.data(), a.value.data()));
  }

  Eigen::MatrixXd solution_;
  Eigen::SparseLU<Columns, Eigen::COLAMDOrdering<std::int32_t>> lu_;
};

}  // namespace

DEFORM_PLUGIN(EigenLu, NoParameters, .name = "eigen_lu", .version = "1.0",
              .summary = "sparse LU factorisation without GPL parts, for any regular matrix",
              .formula = "P A Q = L U", .source = "Eigen::SparseLU, after Demmel et al. 1999")
