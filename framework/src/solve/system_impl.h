/// What a System is made of.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "deform/solve/system.h"

#include "solve/coloured_jacobian.h"
#include "solve/contacts.h"
#include "solve/external_forces.h"
#include "solve/jet_assembler.h"
#include "solve/reduced_solver.h"
#include "solve/rigid_modes.h"
#include "solve/tangent_matrix.h"
#include "solve/tangent_solver.h"
#include "solve/tuple_assembler.h"
#include "solve/turning_step.h"

namespace deform {

/// One sample set with its terms, and its geometry at the states that matter.
struct SetPart {
  /// As far as terms and forces need it.
  void compute(Geometry& of, const NodeVectors& r) const {
    of.compute(assembler.samples(), r, detail);
  }
  JetAssembler assembler;
  Geometry::Detail detail;
  Geometry rest;
  std::array<Geometry, 2> geometry;  // one of a step's start, one of any other state
  Geometry before;                   // a Newton step earlier; made when first needed
  Geometry damped;                   // that the material's damping is of, likewise
  Geometry begun, earlier;           // that strains are measured from within a step
  Geometry from, to, mean;  // of a step whose strains are averaged: ends, Geometry::make_mean
};

struct System::Impl {
  explicit Impl(ModelParts p);

  template <class Ask>
  void ask_parts(const Ask& ask) const;
  void read_traits();
  [[nodiscard]] SampleRole role_of(std::size_t term, const JetTerm& jet) const;
  void make_sets();
  [[nodiscard]] Geometry::Detail detail_of_normals(const SampleSet& set) const;
  void make_tuples();
  void make_pattern();
  void make_tangent_pattern();
  void make_tangent_solver();
  [[nodiscard]] std::span<const Geometries> geometries_of_tangent();
  [[nodiscard]] bool give_tangent_to_solver();
  [[nodiscard]] bool make_tangent();
  void add_to_tangent(const State& state, double rate);
  const BlockMatrix& whole_tangent();
  [[nodiscard]] bool adds_to_tangent(double rate) const;
  [[nodiscard]] bool has_material_damping() const;
  void update_damping(const NodeVectors& r);
  void add_material_damping(const State& state, NodeVectors& f);
  /// What a term's damping is multiplied by where strains are measured over a step, or v is taken.
  [[nodiscard]] std::vector<double> damping_factors(bool of_strains) const;
  /// One a set, by a function of a set.
  template <class Of>
  [[nodiscard]] std::span<const Geometries> geometries_of_sets(const Of& of) {
    all_geometries.clear();
    for (SetPart& set : sets) all_geometries.push_back(of(set));
    return all_geometries;
  }
  [[nodiscard]] Geometries since_begun(SetPart& set) {
    return {set.geometry[current], set.geometry[current], set.rest, &set.begun};
  }
  void add_strain_damping(NodeVectors& f);
  void add_strain_damping_tangent(Tangent kind, BlockMatrix& sum);
  [[nodiscard]] std::vector<std::vector<std::int32_t>> dependence() const;
  [[nodiscard]] RigidStiffness rigid_stiffness_of_forces(const NodeVectors& r);
  [[nodiscard]] SetPart& set_of(const SampleSet& samples);
  [[nodiscard]] Geometries geometries(SetPart& set) {
    return {set.geometry[current], set.geometry[current], set.rest, nullptr,
            averages_strains ? &set.mean : nullptr};
  }
  void update_mean_geometry(const NodeVectors& r);
  void evaluate_tuples(const NodeVectors& r);
  [[nodiscard]] std::vector<double> mean_energies(const TupleAssembler& term, const NodeVectors& r);
  void add_strain_forces(NodeVectors& f);
  void add_gradient_of_mean_energy(NodeVectors& f);
  [[nodiscard]] bool knows_strains() const;
  [[nodiscard]] bool is_of(std::size_t place, const NodeVectors& r) const;
  [[nodiscard]] bool knows_geometry(const NodeVectors& r);
  [[nodiscard]] std::size_t place_for_geometry();
  void set_geometry(std::size_t place, const NodeVectors& r);
  void set_current_geometry(std::size_t place);
  void update_geometry(const NodeVectors& r);
  [[nodiscard]] std::size_t place_of_start();
  [[nodiscard]] const Geometry& complete_geometry(const SampleSet& samples, std::size_t place);
  void update_normals();
  void evaluate_geometry_and_stress(const NodeVectors& r, JetAssembler::Part part);
  /// All forces at a state, to `force`.
  void evaluate(const State& state, JetAssembler::Part part);
  void add_internal_force(NodeVectors& f) const;
  [[nodiscard]] NodeVectors force_of(const Named<ForceField>& field, const State& state);
  [[nodiscard]] bool operator_is_finite() const;
  /// Throws Error where the step is to be given up.
  void require_going_on() const {
    if (stop != nullptr && stop->load(std::memory_order_relaxed))
      throw Error(ExitCode::interrupted, "interrupted");
  }

  ModelParts parts;
  std::vector<TermTraits> traits;   // of the energies
  std::optional<ReductionMap> map;  // made when the constraints have said what they hold
  std::vector<SetPart> sets;
  std::vector<TupleAssembler> tuples;
  ExternalForces external;
  std::optional<Contacts> contacts;  // made when the reduction is known

  std::array<NodeVectors, 2> known;  // positions of geometry[0] and [1] …
  std::array<bool, 2> is_known{};    // … if they are of any
  std::size_t current = 0;           // which of both is that of the last updated state
  std::optional<std::size_t> held;   // which is that of the step's start, if either is
  NodeVectors start;                 // positions there
  NodeVectors normals;               // at the nodes, of the current geometry

  std::vector<Geometries> all_geometries;

  NodeVectors force;
  double evaluated_at = 0;  // time of `force` [s]
  NodeValues force_stiffness, force_damping;
  SparseMatrix k;
  long version = 0;
  std::optional<ReducedSolver> solver;
  std::string no_solver = "none was needed";
  /// Of the last evaluate_with_tangent: its values, unless its rows went to the solver …
  BlockMatrix tangent;
  bool tangent_is_whole = false, solver_has_tangent = false;
  NodeValues tangent_diagonal;  // … without this, of force fields [N/m]
  NodeValues solver_diagonal;   // that, and what solve_tangent_to adds
  NodeVectors tangent_at;       // positions, kind, and whether `before` is that of the kind
  Tangent tangent_kind = Tangent::exact;
  bool tangent_is_foreseen = false;
  TangentMatrix tangents;  // makes the one before and the next; bound when first asked for
  BlockMatrix damping;     // of the material, N·s/m, where some term has a retardation time …
  NodeVectors damped_at;   // … at these positions
  bool averages_strains = false;                    // over a step from `step_from` …
  NodeVectors step_from, step_to, mean_at;          // … to this, of which this is the middle
  std::vector<std::vector<double>> tuple_energies;  // at step_from, one a tuple of each term [J]
  double strain_rate = 0;  // [1/s], of strains since `begun`; 0: strain rates are those of v
  std::optional<TangentSolver> tangent_solver;
  bool renews = true;  // the next iterative solve takes nothing from earlier ones
  std::vector<Freedom> held_freedoms;
  std::optional<ColouredJacobian> jacobian;
  std::vector<double> energy_density;        // of one term, for its sum
  BlockMatrix no_stiffness;                  // of the pattern of masses
  std::optional<TangentSolver> mass_solver;  // made when first needed
  std::optional<TurningStep> turning;        // likewise
  StepReport report;
  StepTimes times;
  const std::atomic<bool>* stop = nullptr;  // see System::stop_when
};

}  // namespace deform
