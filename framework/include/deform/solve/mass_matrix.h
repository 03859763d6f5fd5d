/// Accelerations: M with what constraints leave free.
#pragma once

#include <memory>

#include "deform/export.h"
#include "deform/types.h"

namespace deform {

class SystemParts;

class DEFORM_API MassMatrix {
 public:
  explicit MassMatrix(SystemParts& parts);
  ~MassMatrix();
  MassMatrix(const MassMatrix&) = delete;
  MassMatrix& operator=(const MassMatrix&) = delete;

  /// Solves TᵀMT a = Tᵀf for accelerations T a of what is free; those of prescribed components are
  /// 0 (both N × 3) [N], [m/s²]. Throws Error (diverged) where no solver can.
  void accelerate(const NodeVectors& f, NodeVectors& acceleration) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace deform
