/// The part of a System that keeps geometry: of the state that is evaluated, of one before it, and
/// of the step's start.
#include "solve/stopwatch.h"
#include "solve/system_impl.h"

namespace deform {

bool System::Impl::is_of(std::size_t place, const NodeVectors& r) const {
  return is_known[place] && known[place].rows() == r.rows() && known[place] == r;
}

/// Whether either geometry is that of r; it is the current one then.
bool System::Impl::knows_geometry(const NodeVectors& r) {
  if (is_of(current, r)) return true;
  if (!is_of(1 - current, r)) return false;
  set_current_geometry(1 - current);
  return true;
}

/// Never over the geometry of the step's start, which lagged probes read.
std::size_t System::Impl::place_for_geometry() {
  const std::size_t place = held ? 1 - *held : current;
  is_known[place] = false;  // until it is that of another state
  return place;
}

/// The geometry at a place is that of r, and the current one.
void System::Impl::set_geometry(std::size_t place, const NodeVectors& r) {
  known[place] = r;
  is_known[place] = true;
  set_current_geometry(place);
}

void System::Impl::set_current_geometry(std::size_t place) {
  current = place;
  if (!held && is_of(place, start)) held = place;
  if (external.needs_normals()) update_normals();
}

void System::Impl::update_geometry(const NodeVectors& r) {
  if (knows_geometry(r)) return update_mean_geometry(r);
  const Stopwatch watch(times.geometry, "geometry");
  const std::size_t place = place_for_geometry();
  for (SetPart& set : sets) set.compute(set.geometry[place], r);
  set_geometry(place, r);
  update_mean_geometry(r);
}

/// Where strains are averaged over a step, of which r is the middle: its end, and the means.
void System::Impl::update_mean_geometry(const NodeVectors& r) {
  if (!averages_strains || (mean_at.rows() == r.rows() && mean_at == r)) return;
  const Stopwatch watch(times.geometry, "geometry of a step");
  step_to = 2 * r - step_from;
  for (SetPart& set : sets) {
    set.compute(set.to, step_to);
    set.mean.make_mean(set.geometry[current], set.from, set.to);
  }
  mean_at = r;
}

const Geometry& System::Impl::complete_geometry(const SampleSet& samples, std::size_t place) {
  if (!is_known[place])
    throw Error(ExitCode::internal_error, "geometry is asked for, but of no state yet");
  Geometry& geometry = set_of(samples).geometry[place];
  geometry.complete(samples, known[place]);
  return geometry;
}

/// Stress of a block of samples follows their geometry while that is in cache.
void System::Impl::evaluate_geometry_and_stress(const NodeVectors& r, JetAssembler::Part part) {
  if (averages_strains || knows_geometry(r)) {
    update_geometry(r);
    for (SetPart& set : sets) set.assembler.evaluate(geometries(set), part);
    return;
  }
  const std::size_t place = place_for_geometry();
  for (SetPart& set : sets) {
    // One reference for all: what a std::function keeps without an allocation.
    const struct {
      Geometry& now;
      const SampleSet& samples;
      const NodeVectors& r;
    } of{set.geometry[place], set.assembler.samples(), r};
    Geometry& now = of.now;
    const Geometries all{now, now, set.rest};
    if (set.assembler.evaluates_by_blocks()) {
      now.begin(set.detail);
      set.assembler.evaluate(all, part, nullptr, [&of](Index first, Index size) {
        of.now.compute(of.samples, of.r, first, size);
      });
    } else {
      set.compute(now, r);
      set.assembler.evaluate(all, part);
    }
  }
  set_geometry(place, r);
}

/// Where the geometry of the step's start is; it is computed when somebody asks, as few do.
std::size_t System::Impl::place_of_start() {
  if (held || start.rows() == 0) return held.value_or(current);
  const Stopwatch watch(times.geometry, "geometry of the step's start");
  const std::size_t place = 1 - current;
  is_known[place] = false;
  for (SetPart& set : sets) set.compute(set.geometry[place], start);
  known[place] = start;
  is_known[place] = true;
  held = place;
  return place;
}

void System::begin_step(const State& state) {
  impl_->held.reset();
  impl_->start = state.r;
  for (std::size_t i = 0; i < impl_->known.size(); ++i)
    if (impl_->is_of(i, state.r)) impl_->held = i;
  std::vector<double> residuals = std::move(impl_->report.residuals);
  residuals.clear();  // its memory is kept
  impl_->report = {};
  impl_->report.residuals = std::move(residuals);
  impl_->renews = true;
}
void System::update_geometry(const State& state) { impl_->update_geometry(state.r); }
const Geometry& System::geometry(const SampleSet& samples) const {
  return impl_->complete_geometry(samples, impl_->current);
}
const Geometry& System::previous_geometry(const SampleSet& samples) const {
  return impl_->complete_geometry(samples, impl_->place_of_start());
}
const Geometry& System::rest_geometry(const SampleSet& samples) const {
  return impl_->set_of(samples).rest;
}

}  // namespace deform
