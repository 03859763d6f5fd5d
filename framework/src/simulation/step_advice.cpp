#include "simulation/step_advice.h"

#include <algorithm>

#include <fmt/format.h>

#include "deform/log.h"

namespace deform {
namespace {

/// A cause has a part in a hard step where so many of its iterations were about it.
constexpr long kEvery = 4;

struct Cause {
  long count;
  const char* name;
  const char* advice;
};

}  // namespace

void StepAdvice::look(long step, const StepReport& report) {
  const long parts = std::max(report.substeps + report.rejected, 1L);
  const bool is_hard = report.rejected > 0 || report.iterations > kMany * parts;
  if (!is_hard || report.iterations == 0) return;
  const Cause causes[] = {
      {has_bodies_ ? report.contact_changes : 0, "contact that changes",
       "a shorter 'step', less 'friction', or bodies with rounder edges"},
      {report.projected, "buckling: the exact tangent is not positive definite",
       "a shorter 'step', a method that damps (backward_euler, bdf2), or a coarser grid where the "
       "sheet is much thinner than its spacing"},
      {report.with_jacobian, "forces that turn with the surface", "a shorter 'step'"},
  };
  const auto* const worst = std::ranges::max_element(causes, {}, &Cause::count);
  const bool is_known = kEvery * worst->count >= report.iterations;
  const char* const name = is_known ? worst->name : "no single cause";
  const char* const advice =
      is_known ? worst->advice : "a shorter 'step', or error control ('error')";
  if (!said_.insert(name).second) return;
  log::info(
      fmt::format("step {} was hard ({} iterations of Newton's method, {} of {} parts given "
                  "up): {} (in {} of them). If many are so: {}",
                  step, report.iterations, report.rejected, parts, name,
                  is_known ? worst->count : report.iterations, advice));
}

}  // namespace deform
