// Links SuiteSparse's UMFPACK, which is under the GPL: whoever distributes a binary of this plugin
// does so under the terms of the GPL. This source file is under the licence of the project. See
// LICENSES.md.
#include <limits>
#include <memory>
#include <umfpack.h>

#include <deform/solve/linear_solver.h>

#include "one_thread.h"

namespace {
using namespace deform;

struct FreeSymbolic {
  void operator()(void* object) const { umfpack_di_free_symbolic(&object); }
};
struct FreeNumeric {
  void operator()(void* object) const { umfpack_di_free_numeric(&object); }
};

std::string failure(int status) {
  switch (status) {
    case UMFPACK_WARNING_singular_matrix:
      return "singular";
    case UMFPACK_ERROR_out_of_memory:
      return "out of memory";
    case UMFPACK_ERROR_invalid_matrix:
      return "columns of a row do not ascend, or are out of range";
    case UMFPACK_ERROR_different_pattern:
      return "the pattern is not the one that was analysed";
    default:
      return "UMFPACK's status " + std::to_string(status);
  }
}

/// P R A Q = L U with rows scaled by R, and iterative refinement. UMFPACK reads columns: what it
/// sees is Aᵀ.
class Umfpack final : public LinearSolver {
 public:
  Umfpack(const NoParameters& /*p*/, const Setup& /*setup*/) { umfpack_di_defaults(control_); }

  [[nodiscard]] double suitability(const MatrixTraits& /*traits*/) const override { return 5; }

  /// From the pattern alone: with values, the ordering and so the bits of all later solutions could
  /// depend on which matrix happened to be the first, and a resumed run would differ.
  void analyse(const SparseMatrix& a, const MatrixTraits& /*traits*/) override {
    const OneThread one;
    numeric_.reset();
    symbolic_.reset();
    a_ = a;
    if (a.size == 0) return;
    const int n = size();
    void* symbolic = nullptr;
    const int status = umfpack_di_symbolic(n, n, a_.row_begin.data(), a_.column.data(), nullptr,
                                           &symbolic, control_, info_);
    symbolic_.reset(symbolic);
    if (status != UMFPACK_OK)
      throw std::runtime_error("UMFPACK cannot analyse the matrix: " + failure(status));
    integers_.resize(static_cast<std::size_t>(n));
    numbers_.resize(5 * static_cast<std::size_t>(n));  // as much as refinement needs
  }

  [[nodiscard]] Factorisation factor(const SparseMatrix& a) override {
    const OneThread one;
    if (a.size != a_.size || a.value.size() != a_.column.size())
      throw std::logic_error("factor() of a matrix that was not analysed");
    if (a.size == 0) return "";
    a_.value = a.value;  // refinement needs them when the caller's may be gone
    numeric_.reset();    // before the next, so that there are never two
    void* numeric = nullptr;
    const int status = umfpack_di_numeric(a_.row_begin.data(), a_.column.data(), a_.value.data(),
                                          symbolic_.get(), &numeric, control_, info_);
    numeric_.reset(numeric);
    if (status != UMFPACK_OK) return failure(status);
    if (!(info_[UMFPACK_RCOND] > std::numeric_limits<double>::epsilon()))  // not a number, too
      return "singular to working precision, or not finite";
    return "";
  }

  void solve(const Eigen::Ref<const Eigen::MatrixXd>& b, Eigen::Ref<Eigen::MatrixXd> x) override {
    const OneThread one;
    if (b.size() == 0) return;
    for (Index k = 0; k < b.cols(); ++k) {
      const int status = umfpack_di_wsolve(
          UMFPACK_At, a_.row_begin.data(), a_.column.data(), a_.value.data(), x.col(k).data(),
          b.col(k).data(), numeric_.get(), control_, info_, integers_.data(), numbers_.data());
      if (status != UMFPACK_OK)
        throw std::runtime_error("UMFPACK cannot solve: " + failure(status));
    }
  }

 private:
  [[nodiscard]] int size() const { return static_cast<int>(a_.size); }

  double control_[UMFPACK_CONTROL]{};
  double info_[UMFPACK_INFO]{};
  SparseMatrix a_;  // the analysed pattern and the factorised values
  std::unique_ptr<void, FreeSymbolic> symbolic_;
  std::unique_ptr<void, FreeNumeric> numeric_;
  std::vector<int> integers_;  // workspaces of solve
  std::vector<double> numbers_;
};

}  // namespace

DEFORM_PLUGIN(Umfpack, NoParameters, .name = "umfpack", .version = "1.0",
              .summary = "sparse LU factorisation with pivoting, for any regular matrix",
              .formula = "P R A Q = L U", .source = "Davis 2004 (SuiteSparse)")
