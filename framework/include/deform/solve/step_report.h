/// What an iterative integrator's step took: for logs and probes.
#pragma once

#include <vector>

#include "deform/solve/contact_report.h"

namespace deform {

/// What an iterative integrator's last step took.
struct StepReport {
  long iterations = 0;  ///< of Newton's method, all substeps together
  /// Of them with the projected tangent, as the exact one was not positive definite (buckling);
  /// with the Jacobian of all forces (forces that turn); how often contact became another one.
  long projected = 0, with_jacobian = 0, contact_changes = 0;
  long solver_iterations = 0;     ///< of the linear solver, where it is iterative
  long substeps = 1;              ///< of time or of load
  long rejected = 0;              ///< substeps that were tried and given up
  double smallest = 0;            ///< shortest and longest substep [s]; 0 where there is none
  double largest = 0;             ///<
  double residual = 0;            ///< where the last substep ended, relative to the forces at work
  std::vector<double> residuals;  ///< one an iteration of the last substep
  /// Change of the incremental potential over the last substep [J]: never positive; not a number
  /// where some force has no potential.
  double potential_change = 0;
  ContactReport contact;
};

}  // namespace deform
