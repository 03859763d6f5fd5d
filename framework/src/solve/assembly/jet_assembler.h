/// Evaluates the terms on one sample set and gathers their forces and lagged operator.
#pragma once

#include <algorithm>
#include <vector>

#include "deform/geometry/geometry.h"
#include "deform/model/energy_term.h"
#include "deform/solve/sparse_matrix.h"
#include "deform/solve/system.h"

#include "solve/assembly/gather_table.h"

namespace deform {

/// The geometries that an evaluation uses.
struct Geometries {
  const Geometry& now;
  const Geometry& lagged;
  const Geometry& rest;
  const Geometry* origin = nullptr;  // what strains are measured from; null: rest
  const Geometry* mean = nullptr;    // of a step, for terms that know strains; null: as now
};

/// All terms on one set. The order of every sum is fixed by the scene and the set.
class JetAssembler {
 public:
  struct Term {
    std::size_t number;  ///< in the scene's list
    std::string origin;
    std::shared_ptr<const JetTerm> term;
    TermTraits traits;
  };

  JetAssembler(const SampleSet& samples, std::vector<Term> terms);

  [[nodiscard]] const SampleSet& samples() const { return *samples_; }
  [[nodiscard]] const std::vector<Term>& terms() const { return terms_; }
  [[nodiscard]] const GatherTable& gather() const { return gather_; }
  /// As a term sees it: TermTraits::strains decide whether that is the mean of a step.
  [[nodiscard]] SampleBlock sample_block(const Geometries& g, const Term& term, Index first,
                                         Index size) const;
  /// This assembler's place for a scene's term; null when the term is not on this set.
  [[nodiscard]] const Term* find(std::size_t number) const;

  /// What the terms need of a state's geometry.
  [[nodiscard]] Geometry::Detail detail() const;

  /// What to compute in `evaluate`: stress alone; stress and couplings k_mn; or the couplings and
  /// what stress has beside them, c_m.
  enum class Part { stress, stress_and_couplings, couplings_and_constant };
  /// Before samples first … first+size−1 are read, from the thread that reads them.
  using Prepare = std::function<void(Index first, Index size)>;
  /// Computes that at all samples, of all terms or of one.
  void evaluate(const Geometries& geometries, Part part = Part::stress, const Term* only = nullptr,
                const Prepare& prepare = nullptr);
  /// Whether there are terms and none reads samples of other blocks than its own.
  [[nodiscard]] bool evaluates_by_blocks() const;
  /// f_a −= Σ L σ of the last evaluation.
  void add_force(NodeVectors& f) const;

  /// Calls visit(a, b) for every entry that the lagged operator may have.
  template <class Visit>
  void visit_pattern(const Visit& visit) const;
  /// Calls visit(a, b) for every node b that the force on node a depends on, however indirectly;
  /// some more than once.
  template <class Visit>
  void visit_dependence(const Visit& visit) const;
  /// Remembers where in a matrix of that pattern the entries are.
  void bind(const SparseMatrix& pattern);
  /// K += Σ L k D of the last evaluation.
  void add_operator(SparseMatrix& k) const;

  /// Whether the force of a term comes from a numerical derivative of its energy.
  [[nodiscard]] bool is_numerical(const Term& term, const Geometries& geometries) const;

  /// W at the samples of a block's term, written to density (m).
  void energy_density(const Term& term, const Geometries& geometries, Values density) const;
  /// Unit normals at the nodes: area-weighted means of the samples' exact ones (N × 3).
  void node_normals(const Geometry& now, NodeVectors& normals) const;

 private:
  void evaluate_auxiliary(const Geometries& g, std::size_t number, std::size_t offset);
  void evaluate_block(const Geometries& g, Part part, const Term* only, Index first, Index size);
  void evaluate_term(std::size_t number, Part part, const SampleBlock& block);
  void mark_active(const Term& t);
  void add_affine_part(const GeometryBlock& now);
  [[nodiscard]] bool operator_goes_on(const SparseMatrix& pattern, Index a) const;
  void add_operator_to(Index a, Index size, double* rows) const;
  void add_force_of_run(Index a, Index size, NodeVectors& f) const;
  [[nodiscard]] double* coupling(std::size_t c) {
    return k_.data() + static_cast<Index>(c) * samples_->stride();
  }
  [[nodiscard]] const double* coupling(std::size_t c) const {
    return k_.data() + static_cast<Index>(c) * samples_->stride();
  }
  [[nodiscard]] Vectors sigma(int m) {
    double* x = sigma_.data() + 3 * m * samples_->stride();
    return {x, x + samples_->stride(), x + 2 * samples_->stride()};
  }

  const SampleSet* samples_;
  std::vector<Term> terms_;
  GatherTable gather_;
  std::vector<Coupling> couplings_;                     // of all terms, each once
  std::vector<std::vector<std::size_t>> of_term_;       // their numbers in couplings_, a term
  std::array<bool, kChannels> active_{};                // channels that some stress may use
  std::vector<double> k_;                               // (couplings × m)
  std::vector<double> sigma_;                           // (channels × 3 × m)
  std::vector<double> auxiliary_;                       // (fields of all terms × m)
  std::vector<std::size_t> fields_of_;                  // number of auxiliary fields, a term
  std::vector<std::vector<ConstValues>> auxiliary_of_;  // whole fields, a term
  static constexpr std::uint16_t kNoSlot = 0xFFFF;
  std::vector<std::size_t> slot_begin_;  // of each (node, sample) pair
  std::vector<std::uint16_t> slot_;      // column places within the node's row
  std::vector<Index> operator_run_end_;  // of the rows of the operator that are alike
};

template <class Visit>
void JetAssembler::visit_pattern(const Visit& visit) const {
  for (Index a = 0; a < gather_.nodes(); ++a) {
    const GatherTable::Row row = gather_.row(a);
    for (std::size_t e = 0; e < row.samples.size(); ++e) {
      const SampleSet::Stencil at = samples_->stencil(row.samples[e]);
      for (std::size_t k = 0; k < at.nodes.size(); ++k)
        for (const auto& [m, n] : couplings_)
          if (row.l[e][static_cast<std::size_t>(slot(m))] != 0 &&
              at.d[k][static_cast<std::size_t>(slot(n))] != 0) {
            visit(a, Index{at.nodes[k]});
            break;
          }
    }
  }
}

template <class Visit>
void JetAssembler::visit_dependence(const Visit& visit) const {
  const FieldDifferences* differences =
      std::ranges::any_of(terms_, [](const Term& t) { return t.traits.strong_form; })
          ? samples_->field_differences()
          : nullptr;
  for (Index a = 0; a < gather_.nodes(); ++a)
    for (const std::int32_t s : gather_.row(a).samples) {
      const auto visit_sample = [&](Index sample) {
        for (const std::int32_t b : samples_->stencil(sample).nodes) visit(a, Index{b});
      };
      visit_sample(s);
      for (int d = 1; differences != nullptr && d < kDerivatives; ++d)
        for (const FieldDifferences::Term& term : differences->row(static_cast<Derivative>(d), s))
          visit_sample(term.sample);
    }
}

}  // namespace deform
