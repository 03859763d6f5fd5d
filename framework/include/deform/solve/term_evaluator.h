/// What single parts of a model contribute at a state: for probes, outputs, checks.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "deform/export.h"
#include "deform/geometry/geometry.h"
#include "deform/solve/sparse_matrix.h"
#include "deform/solve/state.h"
#include "deform/types.h"

namespace deform {

class Assembly;
class SampleSet;

/// As for an Evaluator, everything here depends on its arguments alone. Terms by their number among
/// System::energies.
class DEFORM_API TermEvaluator {
 public:
  explicit TermEvaluator(Assembly& assembly) : assembly_(&assembly) {}

  /// All of a state's geometry at the samples of one of the surface's sets; stays what it is while
  /// anybody holds it.
  [[nodiscard]] std::shared_ptr<const Geometry> geometry(const NodeVectors& r,
                                                         const SampleSet& samples) const;
  [[nodiscard]] const Geometry& rest_geometry(const SampleSet& samples) const;

  /// Energy of one term [J].
  [[nodiscard]] double energy(std::size_t term, const State& state) const;
  /// Energy per parameter area [J/m²] at the samples of a JetTerm's set; empty for other terms.
  [[nodiscard]] std::vector<double> energy_density(std::size_t term, const NodeVectors& r) const;
  /// Potential energy of the force fields that have one [J].
  [[nodiscard]] double external_potential(const State& state) const;
  /// Forces of one energy term or of all force fields (N × 3) [N].
  [[nodiscard]] NodeVectors internal_force(std::size_t term, const State& state) const;
  [[nodiscard]] NodeVectors external_force(const State& state) const;
  /// K of one energy term alone, and its constant part c: f = c − K r. For checks.
  struct LaggedForce {
    SparseMatrix k;
    NodeVectors c;
  };
  [[nodiscard]] LaggedForce lagged_force(std::size_t term, const State& state) const;
  /// Name of the energy term or force field with the largest force at a node.
  [[nodiscard]] std::string largest_force_at(Index node, const State& state) const;
  /// What a log should say of the model: which terms leave their force to a numerical derivative.
  [[nodiscard]] std::vector<std::string> notes() const;

 private:
  Assembly* assembly_;
};

}  // namespace deform
