// Links SuiteSparse's CHOLMOD with its modules under the GPL: whoever distributes a binary of this
// plugin does so under the terms of the GPL. This source file is under the licence of the project.
// See LICENSES.md.
#include <cholmod.h>
#include <limits>

#include <deform/solve/linear_solver.h>

#include "one_thread.h"

namespace {
using namespace deform;

struct Parameters {
  std::string ordering = "amd";
  std::string supernodal = "auto";
  static void declare(Declaration<Parameters>& d) {
    d("ordering", &Parameters::ordering, "",
      "how the unknowns are ordered to keep the factor sparse")
        .one_of({"amd", "metis", "natural"});
    d("supernodal", &Parameters::supernodal, "", "whether dense blocks are factorised as such")
        .one_of({"auto", "never", "always"});
  }
};

int ordering_of(const std::string& name) {
  return name == "amd" ? CHOLMOD_AMD : name == "metis" ? CHOLMOD_METIS : CHOLMOD_NATURAL;
}
int supernodal_of(const std::string& name) {
  return name == "auto" ? CHOLMOD_AUTO : name == "never" ? CHOLMOD_SIMPLICIAL : CHOLMOD_SUPERNODAL;
}

/// CHOLMOD's view of a symmetric matrix: its rows are its columns, and of both triangles one is
/// read.
cholmod_sparse view_of(const SparseMatrix& a) {
  cholmod_sparse view{};
  view.nrow = view.ncol = static_cast<std::size_t>(a.size);
  view.nzmax = a.column.size();
  view.p = const_cast<std::int32_t*>(a.row_begin.data());
  view.i = const_cast<std::int32_t*>(a.column.data());
  view.x = const_cast<double*>(a.value.data());
  view.stype = 1;
  view.itype = CHOLMOD_INT;
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  view.sorted = view.packed = 1;
  return view;
}
cholmod_dense view_of(const Eigen::Ref<const Eigen::MatrixXd>& b) {
  cholmod_dense view{};
  view.nrow = static_cast<std::size_t>(b.rows());
  view.ncol = static_cast<std::size_t>(b.cols());
  view.d = static_cast<std::size_t>(b.outerStride());
  view.nzmax = view.d * view.ncol;
  view.x = const_cast<double*>(b.data());
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  return view;
}

/// A = L Lᵀ.
class Cholmod final : public LinearSolver {
 public:
  Cholmod(const Parameters& p, const Setup& /*setup*/) {
    cholmod_start(&common_);
    common_.print = 0;  // failures are reported, not printed
    common_.nmethods = 1;
    common_.method[0].ordering = ordering_of(p.ordering);
    common_.supernodal = supernodal_of(p.supernodal);
    common_.final_ll = 1;  // L D Lᵀ would factorise indefinite matrices without a word
    common_.quick_return_if_not_posdef = 1;
  }
  ~Cholmod() override {
    cholmod_free_dense(&x_, &common_);
    cholmod_free_dense(&y_, &common_);
    cholmod_free_dense(&e_, &common_);
    cholmod_free_factor(&factor_, &common_);
    cholmod_finish(&common_);
  }

  [[nodiscard]] double suitability(const MatrixTraits& traits) const override {
    return traits.symmetric ? 10 : 0;
  }

  void analyse(const SparseMatrix& a, const MatrixTraits& /*traits*/) override {
    const OneThread one;
    cholmod_free_factor(&factor_, &common_);
    if (a.size == 0) return;
    cholmod_sparse view = view_of(a);
    factor_ = cholmod_analyze(&view, &common_);
    if (factor_ == nullptr)
      throw std::runtime_error("CHOLMOD cannot analyse the matrix: " + failure());
  }

  [[nodiscard]] Factorisation factor(const SparseMatrix& a) override {
    const OneThread one;
    if (a.size == 0) return "";
    if (factor_ == nullptr || factor_->n != static_cast<std::size_t>(a.size))
      throw std::logic_error("factor() of a matrix that was not analysed");
    cholmod_sparse view = view_of(a);
    if (cholmod_factorize(&view, factor_, &common_) == 0) return "CHOLMOD: " + failure();
    if (common_.status == CHOLMOD_NOT_POSDEF)
      return Factorisation::not_positive_definite("not positive definite (at column " +
                                                  std::to_string(failed_column()) + ")");
    if (common_.status != CHOLMOD_OK) return "CHOLMOD: " + failure();
    const double rcond = cholmod_rcond(factor_, &common_);
    if (!(rcond > std::numeric_limits<double>::epsilon()))  // not a number, too
      return "singular to working precision, or not finite";
    return "";
  }

  void solve(const Eigen::Ref<const Eigen::MatrixXd>& b, Eigen::Ref<Eigen::MatrixXd> x) override {
    const OneThread one;
    if (b.size() == 0) return;
    cholmod_dense view = view_of(b);
    if (cholmod_solve2(CHOLMOD_A, factor_, &view, nullptr, &x_, nullptr, &y_, &e_, &common_) == 0)
      throw std::runtime_error("CHOLMOD cannot solve: " + failure());
    x = Eigen::Map<const Eigen::MatrixXd>(static_cast<const double*>(x_->x), b.rows(), b.cols());
  }

 private:
  /// Where the factorisation stopped, in the matrix' own numbering.
  [[nodiscard]] std::size_t failed_column() const {
    const auto* permutation = static_cast<const std::int32_t*>(factor_->Perm);
    return factor_->minor < factor_->n ? static_cast<std::size_t>(permutation[factor_->minor])
                                       : factor_->n;
  }
  [[nodiscard]] std::string failure() const {
    switch (common_.status) {
      case CHOLMOD_OUT_OF_MEMORY:
        return "out of memory";
      case CHOLMOD_TOO_LARGE:
        return "the factor is too large for 32-bit indices";
      case CHOLMOD_NOT_INSTALLED:
        return "the ordering is not in this build of CHOLMOD";
      default:
        return "status " + std::to_string(common_.status);
    }
  }

  cholmod_common common_{};
  cholmod_factor* factor_ = nullptr;
  cholmod_dense* x_ = nullptr;  // solution and workspaces, kept from solve to solve
  cholmod_dense* y_ = nullptr;
  cholmod_dense* e_ = nullptr;
};

}  // namespace

DEFORM_PLUGIN(Cholmod, Parameters, .name = "cholmod", .version = "1.0",
              .summary = "sparse Cholesky factorisation, for symmetric positive definite matrices",
              .formula = "P A Pᵀ = L Lᵀ",
              .source = "Chen, Davis, Hager & Rajamanickam 2008 (SuiteSparse)")
