#include <cmath>
#include <string>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>

#include <deform/solve/linear_solver.h>

namespace {
using namespace deform;

struct Parameters {
  double tolerance = 1e-10;
  std::int64_t iterations = 500;
  double drop = 1e-4;
  std::int64_t fill = 10;
  static void declare(Declaration<Parameters>& d) {
    d("tolerance", &Parameters::tolerance, "1",
      "of the residual in systems that want to be solved exactly, relative to the right-hand side")
        .above(0)
        .at_most(0.01);
    d("iterations", &Parameters::iterations, "", "for a right-hand side, at most").at_least(1);
    d("drop", &Parameters::drop, "1",
      "what the preconditioner leaves out: entries of its rows below this part of their norm")
        .at_least(0)
        .at_most(1);
    d("fill", &Parameters::fill, "1", "entries of the preconditioner, times those of the matrix")
        .at_least(1);
  }
};

/// Stabilised bi-conjugate gradients, preconditioned by an incomplete factorisation: less memory
/// than a whole one, for large matrices without symmetry.
class BiCgStab final : public LinearSolver {
 public:
  BiCgStab(const Parameters& p, const Setup& /*setup*/) : p_(p) {
    krylov_.preconditioner().setDroptol(p.drop);
    krylov_.preconditioner().setFillfactor(static_cast<int>(p.fill));
    krylov_.setMaxIterations(p.iterations);
  }

  /// For those who name it: as a last resort it would hide that a matrix is singular.
  [[nodiscard]] double suitability(const MatrixTraits& /*traits*/) const override {
    return 0.5 * kSuitable;
  }

  void analyse(const SparseMatrix& /*a*/, const MatrixTraits& /*traits*/) override {}

  [[nodiscard]] Factorisation factor(const SparseMatrix& a) override {
    for (const double value : a.value)
      if (!std::isfinite(value)) return "an entry is not finite";
    a_ = Eigen::Map<const Rows>(a.size, a.size, static_cast<Index>(a.value.size()),
                                a.row_begin.data(), a.column.data(), a.value.data());
    if (a.size == 0) return "";
    krylov_.compute(a_);
    return krylov_.info() == Eigen::Success ? "" : "no incomplete factorisation";
  }

  void solve(const Eigen::Ref<const Eigen::MatrixXd>& b, Eigen::Ref<Eigen::MatrixXd> x) override {
    x.setZero();
    improve(b, p_.tolerance, x);
  }

  /// A (x⁺ − x) = b − A x, unless that is rounding: the change to the tolerance.
  void improve(const Eigen::Ref<const Eigen::MatrixXd>& b, double tolerance,
               Eigen::Ref<Eigen::MatrixXd> x) override {
    krylov_.setTolerance(tolerance);
    for (Index c = 0; c < b.cols() && b.rows() > 0; ++c) {
      residual_ = b.col(c) - a_ * x.col(c);
      const double before = residual_.norm();
      if (before <= kRounding * b.col(c).norm()) continue;
      change_ = krylov_.solve(residual_);
      residual_ -= a_ * change_;  // the iteration's own may have drifted from it
      if (krylov_.info() != Eigen::Success || !(residual_.norm() <= kDrift * tolerance * before))
        throw Error(ExitCode::diverged, "bicgstab: " + std::to_string(krylov_.iterations()) +
                                            " iterations do not reduce the residual enough");
      x.col(c) += change_;
    }
  }

 private:
  using Rows = Eigen::SparseMatrix<double, Eigen::RowMajor, std::int32_t>;

  /// Part of the right-hand side that the residual of a solution may be, for its rounding.
  static constexpr double kRounding = 1e-15;
  /// What the true residual may be, relative to that which the iteration believes in.
  static constexpr double kDrift = 10;

  Parameters p_;
  Eigen::VectorXd residual_, change_;
  Rows a_;  // of the last factor: the iteration refers to it
  Eigen::BiCGSTAB<Rows, Eigen::IncompleteLUT<double, std::int32_t>> krylov_;
};

}  // namespace

DEFORM_PLUGIN(BiCgStab, Parameters, .name = "bicgstab", .version = "1.0",
              .summary =
                  "iterative, with an incomplete factorisation, for large matrices without "
                  "symmetry",
              .formula = "A M⁻¹ y = b, M ≈ A by ILUT",
              .source = "van der Vorst 1992; ILUT: Saad 1994; Eigen::BiCGSTAB")
