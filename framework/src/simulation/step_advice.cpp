#include "simulation/step_advice.h"

#include <algorithm>

#include <fmt/format.h>

#include "deform/geometry/characteristic_length.h"
#include "deform/log.h"

namespace deform {
namespace {

/// A cause has a part in a hard step where so many of its iterations were about it.
constexpr long kEvery = 4;
/// What is deeper inside of a body than this part of the surface's size is not there by rounding.
constexpr double kDeep = 1e-6;
/// Where |r_1 × r_2| is less than this part of the rest surface's, the surface is folded.
constexpr double kFolded = 0.05;
constexpr const char* kFold = "a fold";

struct Cause {
  long count;
  const char* name;
  const char* advice;
};

}  // namespace

void StepAdvice::look(long step, const State& state) {
  look_at_iterations(step, state);
  if (system_->contact().bodies() > 1 && !has_warned_) look_for_squeezed(step, state);
}

void StepAdvice::look_for_squeezed(long step, const State& state) {
  const double deep = kDeep * characteristic_length(system_->rest());
  const NodeVectors r = state.r.topRows(system_->nodes());
  system_->contact().find({state.time, r, state.time, r}, -deep, inside_);
  if (inside_.empty()) return;
  const NodeContact& worst = *std::ranges::min_element(inside_, {}, &NodeContact::gap);
  log::warn(
      fmt::format("step {}: node {} is {:.3g} m inside of /colliders/{}: it has nowhere to go "
                  "between bodies that close on it",
                  step, worst.node, -worst.gap, worst.body));
  has_warned_ = true;
}

/// Says once where the normal is about to be no function of positions.
bool StepAdvice::is_folded(long step, const State& state) {
  const NodeVectors r = state.r.topRows(system_->nodes());
  for (const Named<EnergyTerm>& energy : system_->energies()) {
    const auto* const term = dynamic_cast<const JetTerm*>(energy.object.get());
    if (term == nullptr || term->tangent_shape(Tangent::projected) != TangentShape::normal)
      continue;
    const SampleSet& samples = system_->surface().samples(term->role());
    const auto now = system_->terms().geometry(r, samples);
    const ConstValues area = now->all().area_element(),
                      rest = system_->terms().rest_geometry(samples).all().area_element();
    for (std::size_t s = 0; s < area.size(); ++s) {
      if (!(area[s] < kFolded * rest[s])) continue;
      if (said_.insert(kFold).second)
        log::info(fmt::format(
            "step {} was hard: at sample {} of '{}' the surface is folded more sharply than its "
            "grid resolves (|r_1 × r_2| is {:.2g} of the rest surface's), where the normal, and "
            "the force of bending with it, jumps. What helps: \"bending\": \"isometric\" of "
            "koiter, "
            "or a finer grid",
            step, s, energy.name, area[s] / rest[s]));
      return true;
    }
  }
  return false;
}

void StepAdvice::look_at_iterations(long step, const State& state) {
  const StepReport& report = system_->step_report();
  const long parts = std::max(report.substeps + report.rejected, 1L);
  // Parts that error control gives up take few iterations each.
  const long many = report.rejected > 0 ? kMany / 2 : kMany;
  if (report.iterations <= many * parts || is_folded(step, state)) return;
  const Cause causes[] = {
      {system_->contact().bodies() > 0 ? report.contact_changes : 0, "contact that changes",
       "a shorter 'step', less 'friction', or bodies with rounder edges"},
      {report.projected, "buckling: the exact tangent is not positive definite",
       "a shorter 'step', in motion a method that damps (backward_euler, bdf2), or a coarser grid "
       "where the sheet is much thinner than its spacing"},
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
