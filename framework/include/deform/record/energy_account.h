/// An account of energy over steps: what loads and constraints put in, what damping took, and what
/// remains.
#pragma once

#include <cstdint>
#include <memory>

#include "deform/export.h"
#include "deform/record/frame.h"

namespace deform {

/// What went in and out between two states [J], and what the surface has gained.
struct EnergyFigures {
  double change = 0;  ///< of kinetic and internal energy (terms with a potential)
  double loads = 0, constraints = 0;
  double damping = 0;  ///< taken
  /// Of colliders on the surface, along their normals (impacts take energy, bodies that move put
  /// some in) and across.
  double contact = 0, friction = 0;
  double turnover = 0;  ///< sum of the sizes of all work and of damping
  double largest_kinetic = 0;

  /// None of these: the method's, that of terms without a potential.
  [[nodiscard]] double drift() const {
    return change - loads - constraints + damping - contact - friction;
  }
  /// What a drift is measured by; 0 where nothing happens.
  [[nodiscard]] double scale() const;
};

/// Forces, damping among them, count by the mean of both ends of a step, times the displacement in
/// between: exact where they change linearly along it. Where loads or supports are not smooth in
/// time within a step, its parts count one by one, and a load that jumps at the end of one counts
/// before the jump for that one and after it for the next. What prescribed components are pushed by
/// is what is missing in the equation of motion there, m a = f + damping + reaction. Its inertia
/// counts by the mean velocity of the step instead, m (v⁺ − v) · (v + v⁺)/2: that is the change of
/// kinetic energy exactly, also where a prescribed velocity jumps. So do impulses of colliders
/// (ContactReport).
class DEFORM_API EnergyAccount {
 public:
  explicit EnergyAccount(const System& system);
  ~EnergyAccount();
  EnergyAccount(EnergyAccount&&) noexcept;
  EnergyAccount& operator=(EnergyAccount&&) noexcept;

  [[nodiscard]] bool has_started() const;
  /// The account begins with this state, whatever there was before.
  void start(const Frame& frame);
  /// The step, or the part of it, that leads to this frame, `length` [s]; the first call starts the
  /// account. A part may end at a break (Probe::follow_break), or with the step.
  enum class End : std::uint8_t { at_break, of_step };
  void add_part(const Frame& frame, double length, End end);
  /// Until this frame, the last that was added or started with.
  [[nodiscard]] EnergyFigures figures(const Frame& frame) const;

  void save(Memory& memory) const;
  void load(const Memory& memory);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace deform
