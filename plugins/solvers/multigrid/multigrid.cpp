#include <deform/solve/linear_solver.h>
#include <deform/surface/surface.h>

#include "block_system.h"
#include "scalar_system.h"

namespace {
using namespace deform;

/// Entries a row of stretching alone: a node and those around it. Bending links nodes beyond.
constexpr double kOfMembranes = 9;

struct Parameters {
  double tolerance = 1e-9;
  std::int64_t iterations = 100;
  std::int64_t smallest = 1000;
  static void declare(Declaration<Parameters>& d) {
    d("tolerance", &Parameters::tolerance, "1",
      "of the error that is left in systems that want to be solved exactly, relative, in the norm "
      "of the preconditioner")
        .above(0)
        .at_most(0.1);
    d("iterations", &Parameters::iterations, "", "of conjugate gradients for a system, at most")
        .at_least(1);
    d("smallest", &Parameters::smallest, "",
      "nodes from which on it is preferred to a factorisation where the scene names no solver")
        .at_least(1);
  }
};

/// Conjugate gradients, preconditioned by one cycle over the surface's coarser nodes: Galerkin's
/// matrices, (block) Jacobi steps. The work is proportional to the number of nodes.
class Multigrid final : public LinearSolver, public BlockSolver {
 public:
  Multigrid(const Parameters& p, const Setup& setup)
      : p_(p),
        total_(setup.surface().nodes()),
        coarsening_(setup.surface().coarsening()),
        smooth_coarsening_(setup.surface().smooth_coarsening()) {
    // Kinks of one level make bending twice as stiff there at most, and the matrix of the largest
    // coarse level has half as many entries a row.
    if (!coarsening_.empty() && !smooth_coarsening_.empty())
      smooth_coarsening_.front() = coarsening_.front();
  }

  [[nodiscard]] double suitability(const MatrixTraits& traits) const override {
    const bool is_possible = traits.symmetric && traits.positive_definite &&
                             traits.nodes.size() == static_cast<std::size_t>(traits.size) &&
                             !coarsening_.empty();
    return is_possible ? preference(traits.size) : 0;
  }
  [[nodiscard]] double block_suitability(Index nodes) const override {
    return coarsening_.empty() || nodes != total_ ? 0 : preference(nodes);
  }

  void analyse(const SparseMatrix& a, const MatrixTraits& traits) override {
    const bool is_bending =
        static_cast<double>(a.column.size()) > kOfMembranes * static_cast<double>(a.size);
    scalar_.emplace(a, traits.nodes, total_, is_bending ? smooth_coarsening_ : coarsening_);
  }
  [[nodiscard]] Factorisation factor(const SparseMatrix& a) override {
    scalar_->factor(a);
    return "";
  }
  void solve(const Eigen::Ref<const Eigen::MatrixXd>& b, Eigen::Ref<Eigen::MatrixXd> x) override {
    x.setZero();
    improve(b, p_.tolerance, x);
  }

  void improve(const Eigen::Ref<const Eigen::MatrixXd>& b, double tolerance,
               Eigen::Ref<Eigen::MatrixXd> x) override {
    const std::string reason = scalar_->improve(b, tolerance, most(), x);
    if (!reason.empty()) throw Error(ExitCode::diverged, "multigrid: " + reason);
  }

  [[nodiscard]] BlockSolver* blocks() override { return this; }
  void analyse(const BlockMatrix& pattern, const std::vector<std::uint8_t>& held) override {
    block_.emplace(pattern, held, coarsening_,
                   multigrid::BlockSystem::Limits{.iterations = most()});
  }
  void put(const BlockRows& rows) override { block_->put(rows); }
  void factor(const NodeValues& d, const NodeBlocks& blocks, bool renew) override {
    block_->factor(d, blocks, renew);
  }
  [[nodiscard]] Outcome solve(const NodeVectors& b, double tolerance, NodeVectors& x) override {
    return block_->solve(b, tolerance, x);
  }
  [[nodiscard]] long iterations() const override {
    return block_ ? block_->iterations() : scalar_ ? scalar_->iterations() : 0;
  }

 private:
  /// Above what factorisations say of themselves from `smallest` nodes on.
  [[nodiscard]] double preference(Index nodes) const { return nodes >= p_.smallest ? 20 : 2; }
  [[nodiscard]] int most() const { return static_cast<int>(p_.iterations); }

  Parameters p_;
  Index total_;
  std::vector<Prolongation> coarsening_, smooth_coarsening_;
  std::optional<multigrid::ScalarSystem> scalar_;
  std::optional<multigrid::BlockSystem> block_;
};

}  // namespace

DEFORM_PLUGIN(Multigrid, Parameters, .name = "multigrid", .version = "1.0",
              .summary =
                  "conjugate gradients preconditioned by geometric multigrid, for symmetric "
                  "positive definite matrices of large surfaces that have coarser nodes",
              .formula = "z = ω D⁻¹ r + P V(Pᵀ r), A_coarse = Pᵀ A P",
              .source =
                  "Briggs, Henson & McCormick, A Multigrid Tutorial; additive finest level: "
                  "Bramble, Pasciak & Xu 1990")
