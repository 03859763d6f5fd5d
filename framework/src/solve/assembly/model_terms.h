/// The energy terms and force fields of a model, ready to be evaluated.
#pragma once

#include <cstddef>
#include <iterator>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "deform/geometry/geometry.h"
#include "deform/solve/model_parts.h"
#include "deform/solve/sparse_matrix.h"
#include "deform/solve/state.h"
#include "deform/solve/step_strains.h"
#include "deform/types.h"

#include "solve/assembly/external_forces.h"
#include "solve/assembly/geometry_cache.h"
#include "solve/assembly/jet_assembler.h"
#include "solve/assembly/tuple_assembler.h"
#include "solve/work_meter.h"

namespace deform {

/// The terms on one sample set, and the set's geometry at rest.
struct SetTerms {
  /// As far as terms and forces need it.
  void compute(Geometry& of, const NodeVectors& r) const {
    of.compute(assembler.samples(), r, detail);
  }
  JetAssembler assembler;
  Geometry::Detail detail;
  Geometry rest;
};

using Strains = StepStrains::Impl;

/// What a stress, a force or a tangent is of is an argument; assemblers keep the stress of the last
/// evaluation until it is gathered, which whoever evaluates does at once.
class ModelTerms {
 public:
  /// `parts` and `meter` must live as long.
  ModelTerms(const ModelParts& parts, WorkMeter& meter);
  ModelTerms(const ModelTerms&) = delete;
  ModelTerms& operator=(const ModelTerms&) = delete;

  [[nodiscard]] const ModelParts& parts() const { return *parts_; }
  [[nodiscard]] WorkMeter& meter() const { return *meter_; }
  [[nodiscard]] Index nodes() const { return parts_->surface->nodes(); }
  /// Nodes, and scalar unknowns behind them.
  [[nodiscard]] Index rows() const { return nodes() + std::ssize(parts_->scalars); }
  [[nodiscard]] const std::vector<TermTraits>& traits() const { return traits_; }
  [[nodiscard]] std::vector<SetTerms>& sets() { return sets_; }
  [[nodiscard]] std::vector<TupleAssembler>& tuples() { return tuples_; }
  [[nodiscard]] ExternalForces& external() { return external_; }
  [[nodiscard]] const Named<EnergyTerm>& energy(std::size_t term) const {
    return parts_->energies[term];
  }
  /// Entries that lagged operators may have, all 0.
  [[nodiscard]] const SparseMatrix& lagged_pattern() const { return lagged_pattern_; }
  /// For StepStrains: tells what is asked for from all that was asked for before.
  [[nodiscard]] long next_version() { return ++versions_; }
  /// Of one term, for its sum: kept for its memory.
  [[nodiscard]] std::vector<double>& room_for_density() { return density_; }
  /// Whether some term has strains that a step can average.
  [[nodiscard]] bool know_strains() const;
  /// Whether the matrix of a tangent has a part of every term (TangentAssembler).
  [[nodiscard]] bool have_tangents() const;

  /// The number of one of the surface's sets here.
  [[nodiscard]] std::size_t set_of(const SampleSet& samples) const;
  [[nodiscard]] std::shared_ptr<const StateGeometry> geometry_at(const NodeVectors& r);
  /// All of it at one set.
  [[nodiscard]] std::shared_ptr<const Geometry> complete_geometry(const NodeVectors& r,
                                                                  const SampleSet& samples);
  /// What set number i's terms are evaluated with: at a state, and where a step averages strains
  /// with its means.
  [[nodiscard]] Geometries geometries(std::size_t i, const StateGeometry& now,
                                      Strains* strains) const;
  /// The same, one a set, by a function of the set's number; until the next call.
  template <class Of>
  [[nodiscard]] std::span<const Geometries> geometries_of_sets(const Of& of) {
    all_geometries_.clear();
    for (std::size_t i = 0; i < sets_.size(); ++i) all_geometries_.push_back(of(i));
    return all_geometries_;
  }

  /// Evaluates stress, or what `part` says, of all terms at a state's positions.
  std::shared_ptr<const StateGeometry> evaluate(const NodeVectors& r, Strains* strains,
                                                JetAssembler::Part part);
  /// −Σ L σ of that, to f.
  void add_internal_force(NodeVectors& f) const;
  /// Of one term alone, at a state: evaluates, gathers.
  void add_force_of(std::size_t term, const StateGeometry& now, Strains* strains, NodeVectors& f);
  void evaluate_tuples(const NodeVectors& r, Strains* strains);
  [[nodiscard]] NodeVectors force_of(const Named<ForceField>& field, const State& state,
                                     const StateGeometry& now);

 private:
  void read_traits();
  [[nodiscard]] SampleRole role_of(std::size_t term, const JetTerm& jet) const;
  void make_sets();
  [[nodiscard]] Geometry::Detail detail_of_normals(const SampleSet& set) const;
  void make_tuples();
  [[nodiscard]] Index scalars_before(std::size_t number) const;
  void make_lagged_pattern();
  [[nodiscard]] std::shared_ptr<StateGeometry> room();
  [[nodiscard]] std::shared_ptr<StateGeometry> known_or_new(const NodeVectors& r);
  void keep(const std::shared_ptr<StateGeometry>& geometry, const NodeVectors& r);

  const ModelParts* parts_;
  WorkMeter* meter_;
  std::vector<TermTraits> traits_;  // of the energies
  ExternalForces external_;
  std::vector<SetTerms> sets_;
  std::vector<TupleAssembler> tuples_;
  SparseMatrix lagged_pattern_;
  GeometryCache cache_;
  long versions_ = 0;
  std::vector<double> density_;
  std::vector<Geometries> all_geometries_;
};

}  // namespace deform
