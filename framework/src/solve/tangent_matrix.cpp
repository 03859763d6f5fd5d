#include "solve/tangent_matrix.h"

#include <algorithm>

#include <tbb/task_arena.h>

#include "deform/parallel.h"

namespace deform {
namespace {

constexpr Index kRowsAtOnce = 8;

}  // namespace

void TangentMatrix::gather(const TangentSchedule::Group& group, const double* h, double* rows,
                           BlockMatrix& k, bool adds) const {
  const Index width = group.size == 1 ? 1 : kRowLanes;
  const std::int32_t* const begin = k.row_begin.data() + group.row;
  const Index numbers = 9 * Index{begin[1] - begin[0]};
  std::fill_n(rows, numbers * width, 0.0);
  const std::uint32_t* places = schedule_->places(group.place);
  for (std::size_t set = 0; set < sets_.size(); ++set) {
    const TangentPlan& plan = schedule_->plan(group.plan + set);
    (width == 1 ? add_to_row : add_to_rows)(plan, h, places, rows);
    places += plan.samples.size();
  }
  // A few rows at a time: the lines of cache that are read and those that are written stay there.
  for (Index first = 0; first < group.size; first += kRowsAtOnce) {
    const Index end = std::min(first + kRowsAtOnce, group.size);
    for (Index i = 0; i < numbers; ++i)
      for (Index q = first; q < end; ++q) {
        double& to = k.value[static_cast<std::size_t>(9 * Index{begin[q]} + i)];
        to = (adds ? to : 0) + rows[i * width + q];
      }
  }
}

void TangentMatrix::assemble_segment(const TangentSchedule::Segment& segment,
                                     std::span<const Geometries> geometries, Tangent kind,
                                     const std::vector<double>& factors, BlockMatrix& k,
                                     bool adds) const {
  const TangentSchedule& schedule = *schedule_;
  // Kept by each thread from call to call: no allocation once they are large enough.
  thread_local std::vector<double> h, rows;
  h.resize(std::max(h.size(), schedule.buffer()));
  rows.resize(std::max(rows.size(), schedule.row_buffer()));
  for (std::size_t p = segment.piece; p < segment.piece_end; ++p) {
    const TangentSchedule::Piece& at = schedule.pieces()[p];
    for (std::size_t s = at.span; s < at.span_end; ++s) {
      const TangentSchedule::Span& span = schedule.spans()[s];
      sets_[span.set].evaluate(geometries[span.set], kind, factors, span.first, span.size,
                               h.data() + span.place, kSampleLanes);
    }
    for (std::size_t g = at.group; g < at.group_end; ++g)
      gather(schedule.groups()[g], h.data(), rows.data(), k, adds);
  }
}

void TangentMatrix::assemble(std::span<const Geometries> geometries, Tangent kind,
                             const std::vector<double>& factors, BlockMatrix& k, bool adds) const {
  const std::vector<TangentSchedule::Segment>& segments = schedule_->segments();
  parallel_blocks(static_cast<Index>(segments.size()), 1, [&](Index i, Index /*one*/) {
    // A plugin that waits for tasks of its own must not take another segment meanwhile: both would
    // use the thread's buffers.
    tbb::this_task_arena::isolate([&] {
      assemble_segment(segments[static_cast<std::size_t>(i)], geometries, kind, factors, k, adds);
    });
  });
}

}  // namespace deform
