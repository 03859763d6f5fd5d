#include "solve/assembly/tangent_builder.h"

#include <algorithm>
#include <array>
#include <atomic>

#include <tbb/task_arena.h>

#include "deform/parallel.h"

#include "solve/assembly/block_pattern.h"

namespace deform {

namespace {

/// Kept by each thread from call to call: no allocation once they are large enough.
struct Buffers {
  std::vector<double> h, room, rows;
  void fit(const TangentSchedule& schedule) {
    h.resize(std::max(h.size(), schedule.buffer()));
    room.resize(std::max(room.size(), schedule.room()));
    rows.resize(std::max(rows.size(), schedule.row_buffer()));
  }
};
thread_local Buffers buffers;

}  // namespace

void TangentBuilder::prepare() {
  if (schedule_) return;
  for (const SetTerms& set : terms_->sets()) sets_.emplace_back(set.assembler);
  BlockPatternBuilder pattern(terms_->rows());
  const auto add = [&](Index a, Index b) { pattern.add(a, b); };
  for (const TangentAssembler& t : sets_) t.visit_pattern(add);
  for (const TupleAssembler& t : terms_->tuples()) t.visit_pattern(add);
  terms_->external().visit_pattern(add);
  pattern_ = pattern.build();
  schedule_.emplace(sets_, pattern_);
}

const BlockMatrix& TangentBuilder::pattern() {
  prepare();
  return pattern_;
}

bool TangentBuilder::make_group(const TangentSchedule::Group& group, const TakeRows& take) const {
  const std::uint32_t* places = schedule_->places(group.place);
  double *const rows = buffers.rows.data(), *const room = buffers.room.data();
  bool is_finite = true;
  for (std::size_t set = 0; set < sets_.size(); ++set) {
    const TangentPlan& plan = schedule_->plan(group.plan + set);
    const SampleNumbers numbers{buffers.h.data(), places, shapes_[set], sets_[set].blocks()};
    // Of the last set, to whose rows those before are added.
    is_finite = group.size == 1 ? make_row(plan, numbers, set > 0, room, rows)
                                : deform::make_rows(plan, numbers, set > 0, group.size, room, rows);
    places += plan.samples;
  }
  return take({group.row, group.size, rows, group.size == 1 ? 1 : kRowLanes}) && is_finite;
}

bool TangentBuilder::make_segment(const TangentSchedule::Segment& segment, const Wanted& wanted,
                                  const TakeRows& take) const {
  const TangentSchedule& schedule = *schedule_;
  buffers.fit(schedule);
  bool is_finite = true;
  for (std::size_t p = segment.piece; p < segment.piece_end; ++p) {
    const TangentSchedule::Piece& at = schedule.pieces()[p];
    for (std::size_t s = at.span; s < at.span_end; ++s) {
      const TangentSchedule::Span& span = schedule.spans()[s];
      sets_[span.set].evaluate(wanted.geometries[span.set], wanted.kind, wanted.factors, span.first,
                               span.size, shapes_[span.set], buffers.h.data() + span.place,
                               kSampleLanes);
    }
    for (std::size_t g = at.group; g < at.group_end; ++g)
      is_finite &= make_group(schedule.groups()[g], take);
  }
  return is_finite;
}

bool TangentBuilder::make_rows(const Wanted& wanted, const TakeRows& take) {
  prepare();
  shapes_.clear();
  for (const TangentAssembler& set : sets_) shapes_.push_back(set.shape(wanted.kind));
  const std::vector<TangentSchedule::Segment>& segments = schedule_->segments();
  std::atomic<bool> is_finite = true;
  parallel_blocks(static_cast<Index>(segments.size()), 1, [&](Index i, Index /*one*/) {
    // A plugin that waits for tasks of its own must not take another segment meanwhile: both would
    // use the thread's buffers.
    tbb::this_task_arena::isolate([&] {
      if (!make_segment(segments[static_cast<std::size_t>(i)], wanted, take)) is_finite = false;
    });
  });
  return is_finite;
}

bool TangentBuilder::assemble(const Wanted& wanted, BlockMatrix& k, bool adds) {
  return make_rows(wanted, [&](const BlockRows& rows) {
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
