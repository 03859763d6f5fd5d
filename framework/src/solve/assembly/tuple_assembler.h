/// Evaluates one term on tuples of nodes and gathers its force and lagged operator.
#pragma once

#include <vector>

#include "deform/model/energy_term.h"
#include "deform/solve/block_matrix.h"
#include "deform/solve/sparse_matrix.h"
#include "deform/types.h"

namespace deform {

class TupleAssembler {
 public:
  /// Of a model's unknowns: nodes; these and the surface's scalars behind them, which terms share;
  /// all; and how many scalars terms before this one have.
  struct Rows {
    Index nodes, shared, all, before;
  };
  TupleAssembler(std::size_t number, std::string origin, std::shared_ptr<const TupleTerm> term,
                 const TermTraits& traits, const Rows& rows);
  /// How many the term has of its own.
  [[nodiscard]] Index scalars() const { return scalars_; }
  /// Whether its energy can be averaged over a step: distances of nodes say nothing of scalars.
  [[nodiscard]] bool averages() const { return has_potential() && !names_scalars_; }

  [[nodiscard]] std::size_t number() const { return number_; }
  enum class Part { stress, constant };
  void evaluate(const NodeVectors& now, const NodeVectors& lagged, Part part = Part::stress);
  /// The force over a step from `from` to `to` with which energy is conserved, `middle` being their
  /// mean (all N × 3): Σ F_a·Δr_a = −ΔE for each tuple. The secant stiffness is the mean of both
  /// ends' (the force in the middle where a term has none), and what then is missing of the work
  /// acts along the tuple's distances, |r_a − r_b|² being quadratic in r, so that it has neither a
  /// resultant nor a moment (Gonzalez 1996, discrete gradients by invariants). `energies` are those
  /// at `from` [J].
  void evaluate_over_step(const NodeVectors& from, const NodeVectors& middle, const NodeVectors& to,
                          const std::vector<double>& energies);
  [[nodiscard]] bool has_potential() const { return traits_.potential; }
  void add_force(NodeVectors& f) const;

  template <class Visit>
  void visit_pattern(const Visit& visit) const {
    for (std::size_t t = 0; t < count(); ++t)
      for (int a = 0; a < width_; ++a)
        for (int b = 0; b < width_; ++b) visit(Index{node(t, a)}, Index{node(t, b)});
  }
  void bind(const SparseMatrix& pattern);
  void add_operator(SparseMatrix& k) const;

  /// K += factor · the second derivatives of the tuples' energies; nothing where there is no
  /// potential.
  void add_tangent(const NodeVectors& r, Tangent kind, BlockMatrix& k, double factor = 1);

  /// [J], one a tuple.
  [[nodiscard]] std::vector<double> energies(const NodeVectors& r) const;
  /// The first of a tuple's nodes, to name it by.
  [[nodiscard]] Index first_node(std::size_t tuple) const { return node(tuple, 0); }

 private:
  [[nodiscard]] std::size_t count() const {
    return tuples_.size() / static_cast<std::size_t>(width_);
  }
  [[nodiscard]] std::int32_t node(std::size_t t, int a) const {
    return tuples_[t * static_cast<std::size_t>(width_) + static_cast<std::size_t>(a)];
  }
  void evaluate_affine(const NodeVectors& now, const NodeVectors& lagged, bool with_k);
  void add_missing_work(const NodeVectors& from, const NodeVectors& to,
                        const std::vector<double>& energies_from,
                        const std::vector<double>& energies_to);
  [[nodiscard]] bool is_explicit() const { return traits_.lagged == Lagged::none; }
  void check_tuples(Index nodes) const;
  void number_scalars(const Rows& rows);
  [[nodiscard]] TupleBlock block(const NodeVectors& now, const NodeVectors& lagged, Index first,
                                 Index size) const;

  std::size_t number_;
  std::string origin_;
  std::shared_ptr<const TupleTerm> term_;
  TermTraits traits_;
  int width_ = 0;
  Index scalars_ = 0;
  bool names_scalars_ = false;
  std::vector<std::int32_t> tuples_;  // (T × width), a copy: as checked, whatever the term does
  std::vector<double> k_;             // (T × width × width)
  std::vector<Vec3> force_;           // (T × width), of the last evaluation
  std::vector<Vec3> force_at_end_;    // likewise, over a step, with the secant stiffness of its end
  std::vector<Index> begin_;          // of each node's (tuple, place) pairs
  std::vector<Index> places_;         // tuple * width + place, ascending within a node
  std::vector<double> h_;             // (T × 3 width × 3 width)
  std::vector<Index> slot_;           // (T × width × width) places in the matrix' values
};

}  // namespace deform
