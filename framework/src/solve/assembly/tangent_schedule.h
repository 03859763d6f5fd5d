/// In which order second derivatives at samples are evaluated and gathered into rows of a tangent,
/// so that they stay in cache between both.
#pragma once

#include <vector>

#include "solve/assembly/tangent_assembler.h"

namespace deform {

/// Rows are taken in pieces of a few dozen that follow each other, pieces in segments: each piece
/// of a segment shares many samples with the one before (strips across a grid). What a segment's
/// pieces need is evaluated piece by piece, into a buffer with places for what the last piece and
/// the next one need; at a segment's border samples are evaluated once more by its neighbour.
/// Segments are independent of each other, and the same at any number of threads.
class TangentSchedule {
 public:
  TangentSchedule(const std::vector<TangentAssembler>& sets, const BlockMatrix& pattern);

  /// Samples that are evaluated together, at most kSampleLanes.
  struct Span {
    std::size_t set;
    Index first, size;
    std::size_t place;  ///< of their numbers in the buffer
    bool operator==(const Span&) const = default;
  };
  /// Rows that are made alike, at most kRowLanes; or one row.
  struct Group {
    Index row, size;
    std::size_t plan, place;  ///< the first set's in plans(), in places(); others follow
  };
  struct Piece {
    std::size_t span, span_end;    ///< to evaluate first, in spans()
    std::size_t group, group_end;  ///< then to gather, in groups()
  };
  struct Segment {
    std::size_t piece, piece_end;
  };

  [[nodiscard]] const std::vector<Segment>& segments() const { return segments_; }
  [[nodiscard]] const std::vector<Piece>& pieces() const { return pieces_; }
  [[nodiscard]] const std::vector<Span>& spans() const { return spans_; }
  [[nodiscard]] const std::vector<Group>& groups() const { return groups_; }
  [[nodiscard]] const TangentPlan& plan(std::size_t i) const { return plans_[plan_of_[i]]; }
  /// Where the samples of a plan are in the buffer.
  [[nodiscard]] const std::uint32_t* places(std::size_t i) const { return places_.data() + i; }
  /// Numbers that a segment's buffer holds, at most; with room to read beyond.
  [[nodiscard]] std::size_t buffer() const { return buffer_; }
  /// Numbers that making rows needs room for, at most.
  [[nodiscard]] std::size_t room() const { return room_; }
  /// Numbers of kRowLanes rows, at most.
  [[nodiscard]] std::size_t row_buffer() const { return row_buffer_; }

 private:
  class Builder;
  std::vector<Segment> segments_;
  std::vector<Piece> pieces_;
  std::vector<Span> spans_;
  std::vector<Group> groups_;
  std::vector<TangentPlan> plans_;      // each once
  std::vector<std::uint32_t> plan_of_;  // of each group and set
  std::vector<std::uint32_t> places_;
  std::size_t buffer_ = 0, row_buffer_ = 0, room_ = 0;
};

}  // namespace deform
