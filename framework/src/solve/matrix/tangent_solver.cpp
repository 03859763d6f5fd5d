#include "solve/matrix/tangent_solver.h"

#include <utility>

#include "deform/error.h"
#include "deform/log.h"
#include "deform/parallel.h"

#include "plugin/guard.h"
#include "profile/profile.h"

namespace deform {
namespace {

ReducedMatrix reduced_matrix(const Unknowns& unknowns, const BlockMatrix& pattern,
                             TangentSolver::Entries entries) {
  ReducedMatrix::Rows rows;
  for (Index a = 0; a < pattern.nodes; ++a)
    for (int c = 0; c < 3; ++c) rows.push_back(unknowns.row({a, c}));
  return {unknowns.size(), rows, 3, [&](const ReducedMatrix::Visit& visit) {
            for (Index a = 0; a < pattern.nodes; ++a)
              for (std::int32_t p = pattern.row_begin[static_cast<std::size_t>(a)];
                   p < pattern.row_begin[static_cast<std::size_t>(a) + 1]; ++p) {
                const Index b = pattern.column[static_cast<std::size_t>(p)];
                for (Index i = 0; i < 3; ++i)
                  for (Index j = 0; j < 3; ++j) {
                    const Index place = 9 * Index{p} + 3 * i + j;
                    if (entries == TangentSolver::Entries::nonzero &&
                        pattern.value[static_cast<std::size_t>(place)] == 0)
                      continue;
                    visit(3 * a + i, 3 * b + j, place);
                    if (a != b) visit(3 * b + j, 3 * a + i, place);
                  }
              }
          }};
}

const char* why_left(Outcome outcome) {
  switch (outcome) {
    case Outcome::indefinite:
      return "in its precision it is not positive definite";
    case Outcome::unfinished:
      return "too many iterations";
    case Outcome::solved:
      break;
  }
  return "its solution is not finite";
}

}  // namespace

TangentSolver::TangentSolver(const ReductionMap& map, const BlockMatrix& pattern,
                             const std::vector<Freedom>& held, const SolverSource& solvers,
                             Whole whole, Entries entries)
    : unknowns_(map, held),
      pattern_(&pattern),
      entries_(entries),
      source_(solvers),
      whole_(std::move(whole)) {}

const SparseMatrix& TangentSolver::reduced(const NodeValues& d) {
  const Span span("matrix filling");
  if (!matrix_) matrix_.emplace(reduced_matrix(unknowns_, *pattern_, entries_));
  matrix_->fill(whole_().value, d);
  return matrix_->matrix();
}

std::string TangentSolver::factor(const NodeValues& d) {
  if (!solvers_) {
    solvers_.emplace(
        source_,
        MatrixTraits{.size = unknowns_.size(), .symmetric = true, .positive_definite = true});
    choice_ += (choice_.empty() ? "" : "; where that ends nowhere ") + solvers_->choice(reduced(d));
  }
  return solvers_->factor_definite(reduced(d));
}

void TangentSolver::choose_block_solver() {
  has_chosen_ = true;
  if (unknowns_.has_ties()) return;
  double best = 0;
  for (const Named<LinearSolver>& solver : source_()) {
    const double suitability = guarded(solver.origin, "judging a matrix", [&] {
      BlockSolver* const blocks = solver.object->blocks();
      if (blocks != nullptr) return blocks->block_suitability(pattern_->nodes);
      return solver.object->suitability(
          {.size = unknowns_.size(), .symmetric = true, .positive_definite = true});
    });
    if (!(suitability > best)) continue;
    best = suitability;
    iterative_ = solver.object->blocks() != nullptr ? solver : Named<LinearSolver>{};
  }
  if (!iterative_.object) return;
  guarded(iterative_.origin, "analysing a matrix",
          [&] { iterative_.object->blocks()->analyse(*pattern_, unknowns_.held()); });
  choice_ += (choice_.empty() ? "" : "; ") + iterative_.name + " (tangents of " +
             std::to_string(pattern_->nodes) + " nodes, " +
             std::to_string(pattern_->column.size()) + " blocks, to a tolerance)";
}

bool TangentSolver::takes_rows() {
  if (!has_chosen_) choose_block_solver();
  return iterative_.object != nullptr;
}

void TangentSolver::put(const BlockRows& rows) {
  guarded(iterative_.origin, "taking rows of a matrix",
          [&] { iterative_.object->blocks()->put(rows); });
}

void TangentSolver::put(const BlockMatrix& k) {
  parallel_blocks(k.nodes, kBlock, [&](Index first, Index size) {
    for (Index a = first; a < first + size; ++a) put(k.row(a));
  });
}

std::string TangentSolver::factor_to_tolerance(const NodeValues& d, const NodeValues& beside_rows,
                                               const NodeBlocks& blocks, bool renew) {
  if (!takes_rows()) return factor(d);
  d_ = d;
  is_handed_over_ = false;
  guarded(iterative_.origin, "preparing to solve",
          [&] { iterative_.object->blocks()->factor(beside_rows, blocks, renew); });
  return "";
}

std::string TangentSolver::solve_to_tolerance(double tolerance, bool must_be_definite,
                                              const NodeVectors& b, NodeVectors& x) {
  iterations_ = 0;
  if (iterative_.object && !is_handed_over_) {
    BlockSolver& blocks = *iterative_.object->blocks();
    const Outcome outcome =
        guarded(iterative_.origin, "solving", [&] { return blocks.solve(b, tolerance, x); });
    iterations_ = blocks.iterations();
    if (outcome == Outcome::indefinite && !must_be_definite)
      return iterative_.name + ": not positive definite";
    if (outcome == Outcome::solved && x.allFinite()) return "";
    const std::string handover =
        "solver " + iterative_.name + " leaves a matrix to a factorisation";
    if (source_.is_new(handover)) log::info(handover + ": " + why_left(outcome));
    std::string reason;
    try {
      reason = factor(d_);
    } catch (const InputError&) {  // the scene names a solver that cannot factorise
      reason = iterative_.name + ": too many iterations, and the scene names no other solver";
    }
    if (!reason.empty()) return reason;
    is_handed_over_ = true;
  }
  return solve(b, x);
}

std::string TangentSolver::solve(const NodeVectors& b, NodeVectors& x) {
  return solvers_->solve(unknowns_, b, x);
}

}  // namespace deform
