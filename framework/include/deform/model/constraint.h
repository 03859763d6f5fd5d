/// Constraints: a reduction r = T q + b of the degrees of freedom.
#pragma once

#include "deform/model/reduction.h"
#include "deform/plugin/descriptor.h"
#include "deform/types.h"

namespace deform {

/// Takes degrees of freedom away and says where they are at any time.
class DEFORM_API Constraint : public Plugin {
 public:
  static constexpr PluginKind kKind = PluginKind::constraint;
  ~Constraint() override;

  virtual void reduce(Reduction& reduction) const = 0;
  /// Writes the prescribed components [m] at a time [s]; leaves the others alone. A pure function
  /// of time.
  virtual void prescribe(double time, NodeVectors& r) const = 0;
};

}  // namespace deform
