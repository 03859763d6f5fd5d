/// Equilibria of surfaces that colliders hold.
#pragma once

#include <memory>
#include <string>

#include "deform/export.h"
#include "deform/plugin/plugin.h"
#include "deform/solve/system.h"

namespace deform {

struct RelaxationSettings {
  double tolerance = 1e-9;       ///< of the residual, relative to the forces at work
  std::int64_t iterations = 50;  ///< of Newton's method in a pseudo-step, at most
};

/// f(r) + contact = 0 for r, by pseudo-transient continuation (Kelley & Keyes 1998): implicit
/// pseudo-steps of a surface that is at rest again after each of them,
///   M (r⁺ − r)/τ² = f(r⁺) + contact,
/// longer and longer as the forces become balanced. What nothing holds falls until something does;
/// Φ falls in every pseudo-step, so that an equilibrium is a stable one, mostly; friction is that
/// of a slow motion from where the surface was, sticking at the end. Prescribed components, and
/// bodies that move, come along by parts that are small beside the surface.
class DEFORM_API Relaxation {
 public:
  explicit Relaxation(RelaxationSettings settings);
  ~Relaxation();
  Relaxation(const Relaxation&) = delete;
  Relaxation& operator=(const Relaxation&) = delete;

  /// Makes `state` the equilibrium under loads, supports and colliders of a time `end` [s]; "" or
  /// why there is none, `state` then being where it came to. Energies must have potentials. Adds to
  /// the system's step report, contact forces among it.
  [[nodiscard]] std::string solve(System& system, double end, State& state);

  /// Friction that the next solution starts from.
  void save(Memory& memory) const;
  void load(const Memory& memory);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace deform
