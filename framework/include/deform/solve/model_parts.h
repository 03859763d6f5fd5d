/// The parts of a model, before a System is made of them.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "deform/model/collider.h"
#include "deform/model/constraint.h"
#include "deform/model/energy_term.h"
#include "deform/model/force_field.h"
#include "deform/solve/linear_solver.h"
#include "deform/surface/surface.h"
#include "deform/types.h"

namespace deform {

/// A plugin object with the name it goes by in messages, columns and files ("bending",
/// "bending_2").
template <class Interface>
struct Named {
  std::string name;
  std::string origin;  ///< plugin and file, for messages
  std::shared_ptr<Interface> object;
};

/// A collider with what holds for contact with it.
struct Body {
  Named<Collider> collider;
  double friction = 0;     ///< Coulomb's coefficient
  double thickness = 0;    ///< distance that nodes keep [m]
  double restitution = 0;  ///< part of the speed of approach that an impact gives back
  std::string pointer;     ///< where the scene says so
};

/// Makes a fresh object of each linear solver to choose from (one, where the scene names it).
using MakeSolvers = std::function<std::vector<Named<LinearSolver>>()>;

struct ModelParts {
  std::shared_ptr<const Surface> surface;
  NodeVectors rest;    ///< (N × 3) [m]
  NodeValues areas;    ///< (N) A, that mass and loads per area go by: Setup::areas() [m²]
  NodeValues mass;     ///< (N) mu A [kg]; a System adds those of scalar unknowns
  NodeValues damping;  ///< (N) (gamma + rayleigh_mass mu) A [N·s/m], likewise
  std::vector<Named<EnergyTerm>> energies;
  /// Retardation time of each energy term's material [s]: its damping force is this times the
  /// Gauss–Newton tangent of the term times −v (Kelvin–Voigt). Empty: none.
  std::vector<double> retardation;
  std::vector<Named<ForceField>> forces;
  std::vector<Named<Constraint>> constraints;
  std::vector<Body> bodies;
  /// Components that different constraints hold need a matrix, and so a solver, each.
  MakeSolvers make_solvers;
  /// Of the surface, then of all energy terms in their order: a System collects them.
  std::vector<ScalarUnknown> scalars;
};

}  // namespace deform
