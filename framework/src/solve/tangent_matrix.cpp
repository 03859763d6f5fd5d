#include "solve/tangent_matrix.h"

#include <algorithm>
#include <array>
#include <atomic>

#include <tbb/task_arena.h>

#include "deform/parallel.h"

namespace deform {

BlockRows TangentMatrix::gather(const TangentSchedule::Group& group, const double* h,
                                double* rows) const {
  const Index width = group.size == 1 ? 1 : kRowLanes;
  const std::int32_t* const begin = pattern_->row_begin.data() + group.row;
  std::fill_n(rows, 9 * Index{begin[1] - begin[0]} * width, 0.0);
  const std::uint32_t* places = schedule_->places(group.place);
  for (std::size_t set = 0; set < sets_.size(); ++set) {
    const TangentPlan& plan = schedule_->plan(group.plan + set);
    (width == 1 ? add_to_row : add_to_rows)(plan, h, places, rows);
    places += plan.samples.size();
  }
  return {group.row, group.size, rows, width};
}

bool TangentMatrix::make_segment(const TangentSchedule::Segment& segment,
                                 std::span<const Geometries> geometries, Tangent kind,
                                 const std::vector<double>& factors, const TakeRows& take) const {
  const TangentSchedule& schedule = *schedule_;
  // Kept by each thread from call to call: no allocation once they are large enough.
  thread_local std::vector<double> h, rows;
  h.resize(std::max(h.size(), schedule.buffer()));
  rows.resize(std::max(rows.size(), schedule.row_buffer()));
  bool is_finite = true;
  for (std::size_t p = segment.piece; p < segment.piece_end; ++p) {
    const TangentSchedule::Piece& at = schedule.pieces()[p];
    for (std::size_t s = at.span; s < at.span_end; ++s) {
      const TangentSchedule::Span& span = schedule.spans()[s];
      sets_[span.set].evaluate(geometries[span.set], kind, factors, span.first, span.size,
                               h.data() + span.place, kSampleLanes);
    }
    for (std::size_t g = at.group; g < at.group_end; ++g)
      is_finite &= take(gather(schedule.groups()[g], h.data(), rows.data()));
  }
  return is_finite;
}

bool TangentMatrix::make_rows(std::span<const Geometries> geometries, Tangent kind,
                              const std::vector<double>& factors, const TakeRows& take) const {
  const std::vector<TangentSchedule::Segment>& segments = schedule_->segments();
  std::atomic<bool> is_finite = true;
  parallel_blocks(static_cast<Index>(segments.size()), 1, [&](Index i, Index /*one*/) {
    // A plugin that waits for tasks of its own must not take another segment meanwhile: both would
    // use the thread's buffers.
    tbb::this_task_arena::isolate([&] {
      if (!make_segment(segments[static_cast<std::size_t>(i)], geometries, kind, factors, take))
        is_finite = false;
    });
  });
  return is_finite;
}

bool TangentMatrix::assemble(std::span<const Geometries> geometries, Tangent kind,
                             const std::vector<double>& factors, BlockMatrix& k, bool adds) const {
  return make_rows(geometries, kind, factors, [&](const BlockRows& rows) {
    const std::int32_t* const begin = k.row_begin.data() + rows.row;
    const Index numbers = 9 * Index{begin[1] - begin[0]};
    std::array<double*, kRowLanes> to{};
    for (Index q = 0; q < rows.size; ++q)
      to[static_cast<std::size_t>(q)] = k.value.data() + 9 * Index{begin[q]};
    return rows.lanes == 1 ? store_row(rows.value, numbers, to[0], adds)
                           : store_rows(rows.value, rows.size, numbers, to.data(), adds);
  });
}

}  // namespace deform
