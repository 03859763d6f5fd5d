/// How Newton's method moves positions.
#pragma once

#include <memory>

#include "deform/export.h"
#include "deform/types.h"

namespace deform {

class System;

/// Positions r(s) along a direction d from r(0): straight, r + s d, or, where d rotates some part
/// of the surface by more than a small angle, along a rotation–strain direction, which rotates
/// parts by finite angles where r + s d would stretch them (Huang et al. 2011); to first order in s
/// both are the same. Nothing else moves positions inside of Newton's method.
class DEFORM_API Path {
 public:
  /// `system` must live as long.
  explicit Path(const System& system);
  ~Path();
  Path(const Path&) = delete;
  Path& operator=(const Path&) = delete;

  /// From r along d (both N × 3) [m]; `rotates`: whether it may do more than go straight.
  void begin(const NodeVectors& r, const NodeVectors& d, bool rotates);
  /// The largest angle by which d rotates a part of the surface [rad]; 0 where it goes straight
  /// whatever d is.
  [[nodiscard]] double angle() const;
  [[nodiscard]] bool is_straight() const;
  /// How far d moves the farthest node, were it straight [m].
  [[nodiscard]] double length() const;
  [[nodiscard]] const NodeVectors& from() const;
  [[nodiscard]] const NodeVectors& direction() const;
  /// Positions (N × 3) [m] at s ≥ 0.
  void at(double s, NodeVectors& r) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace deform
