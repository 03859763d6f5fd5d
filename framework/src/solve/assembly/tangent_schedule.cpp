#include "solve/assembly/tangent_schedule.h"

#include <algorithm>
#include <map>

namespace deform {
namespace {

/// Rows of a piece at most: its samples must find room in a span.
constexpr Index kMostRows = kRowLanes + 4;
/// A few rows that are alike are gathered one by one.
constexpr Index kFewest = 4;
/// Pieces of a segment: enough that little is evaluated twice, and segments for a few threads.
constexpr std::size_t kMostPieces = 32, kFewestPieces = 8, kSegments = 8;

/// Rows a … a+size−1, made of groups.
struct Rows {
  Index first, size;
  std::size_t group, group_end;
};

/// Whether row a + 1 has the columns of row a, counted on by one.
bool columns_go_on(const BlockMatrix& k, Index a) {
  return std::ranges::equal(k.columns(a), k.columns(a + 1), {},
                            [](std::int32_t b) { return b + 1; });
}

}  // namespace

class TangentSchedule::Builder {
 public:
  Builder(TangentSchedule& schedule, const std::vector<TangentAssembler>& sets,
          const BlockMatrix& pattern)
      : to_(schedule), sets_(sets), pattern_(pattern), free_(sets.size()) {}

  void build() {
    cut_rows();
    const std::size_t most = std::clamp(rows_.size() / kSegments, kFewestPieces, kMostPieces);
    std::vector<bool> is_taken(rows_.size());
    for (std::size_t p = 0; p < rows_.size(); ++p) {
      if (is_taken[p]) continue;
      to_.segments_.push_back({to_.pieces_.size(), 0});
      std::size_t length = 0;
      for (std::size_t next = p; next != rows_.size() && length < most; ++length) {
        is_taken[next] = true;
        add_piece(rows_[next]);
        next = nearest(next, is_taken);
      }
      to_.segments_.back().piece_end = to_.pieces_.size();
      begin_segment();
    }
    // Lanes that are not used read beyond the last span.
    to_.buffer_ += kRowLanes;
  }

 private:
  [[nodiscard]] bool goes_on(Index a) const {
    return columns_go_on(pattern_, a) &&
           std::ranges::all_of(sets_, [&](const TangentAssembler& t) { return t.goes_on(a); });
  }
  /// The end of the rows that are made alike from a on, at most kRowLanes.
  [[nodiscard]] Index group_end(Index a) const {
    Index end = a + 1;
    while (end < pattern_.nodes && end - a < kRowLanes && goes_on(end - 1)) ++end;
    return end - a < kFewest ? a + 1 : end;
  }

  /// Groups, and pieces of such that follow each other and touch.
  void cut_rows() {
    for (Index a = 0; a < pattern_.nodes;) {
      const Index end = group_end(a);
      to_.row_buffer_ = std::max(to_.row_buffer_, 9 * pattern_.columns(a).size() * kRowLanes);
      to_.groups_.push_back({a, end - a, 0, 0});
      const bool touches = a > 0 && std::ranges::binary_search(pattern_.columns(a - 1),
                                                               static_cast<std::int32_t>(a));
      if (rows_.empty() || !touches || rows_.back().size + end - a > kMostRows)
        rows_.push_back({a, 0, to_.groups_.size() - 1, 0});
      rows_.back().size += end - a;
      rows_.back().group_end = to_.groups_.size();
      for (; a < end; ++a) piece_of_.push_back(static_cast<std::uint32_t>(rows_.size() - 1));
    }
    tally_.resize(rows_.size());
  }

  /// The piece not taken yet that a piece has most blocks in common with; the number of pieces
  /// where there is none.
  [[nodiscard]] std::size_t nearest(std::size_t p, const std::vector<bool>& is_taken) {
    std::vector<std::size_t> found;
    for (Index a = rows_[p].first; a < rows_[p].first + rows_[p].size; ++a)
      for (const std::int32_t b : pattern_.columns(a)) {
        const std::size_t q = piece_of_[static_cast<std::size_t>(b)];
        if (!is_taken[q] && tally_[q]++ == 0) found.push_back(q);
      }
    std::size_t best = rows_.size();
    for (const std::size_t q : found)
      if (best == rows_.size() || tally_[q] > tally_[best] ||
          (tally_[q] == tally_[best] && q < best))
        best = q;
    for (const std::size_t q : found) tally_[q] = 0;
    return best;
  }

  void begin_segment() {
    live_.clear();
    for (auto& places : free_) places.clear();
    used_ = 0;
  }

  struct Interval {
    std::int32_t begin, end;
  };
  /// Few intervals of at most kSampleLanes that hold all of others, each whole.
  static std::vector<Interval> joined(std::vector<Interval> all) {
    std::ranges::sort(all, {}, &Interval::begin);
    std::vector<Interval> few;
    for (const Interval& i : all) {
      const bool fits = !few.empty() && i.begin <= few.back().end &&
                        std::max(few.back().end, i.end) - few.back().begin <= kSampleLanes;
      if (fits)
        few.back().end = std::max(few.back().end, i.end);
      else
        few.push_back(i);
    }
    return few;
  }

  void add_piece(const Rows& rows) {
    const std::size_t first_span = to_.spans_.size();
    std::vector<std::vector<std::int32_t>> samples;  // of each group and set
    for (std::size_t g = rows.group; g < rows.group_end; ++g)
      for (std::size_t set = 0; set < sets_.size(); ++set) {
        sets_[set].make_plan(pattern_, to_.groups_[g].row, plan_, samples.emplace_back());
        if (set == 0) to_.groups_[g].plan = to_.plan_of_.size();
        to_.plan_of_.push_back(number_of_plan());
      }
    for (std::size_t set = 0; set < sets_.size(); ++set) {
      std::vector<Interval> needed;
      for (std::size_t i = set; i < samples.size(); i += sets_.size()) {
        const Index size = to_.groups_[rows.group + i / sets_.size()].size;
        for (const std::int32_t s : samples[i])
          needed.push_back({s, s + static_cast<std::int32_t>(size)});
      }
      provide(set, joined(std::move(needed)));
    }
    for (std::size_t i = 0; i < samples.size(); ++i) {
      Group& group = to_.groups_[rows.group + i / sets_.size()];
      if (i % sets_.size() == 0) group.place = to_.places_.size();
      for (const std::int32_t s : samples[i])
        to_.places_.push_back(place_of(i % sets_.size(), s, group.size));
    }
    to_.pieces_.push_back({first_span, to_.spans_.size(), rows.group, rows.group_end});
  }

  std::uint32_t number_of_plan() {
    const auto [place, is_new] =
        plans_.try_emplace(plan_, static_cast<std::uint32_t>(to_.plans_.size()));
    if (is_new) {
      to_.plans_.push_back(plan_);
      to_.room_ = std::max(to_.room_, room_for(plan_));
    }
    return place->second;
  }

  /// Makes spans that hold all intervals live, evaluating those that are not yet; what the piece
  /// does not need leaves its place to others.
  void provide(std::size_t set, const std::vector<Interval>& needed) {
    std::vector<Span> kept, missing;
    for (const Interval& i : needed) {
      const auto holds = [&](const Span& s) {
        return s.set == set && s.first <= i.begin && i.end <= s.first + s.size;
      };
      const auto span = std::ranges::find_if(live_, holds);
      if (span == live_.end())
        missing.push_back({set, i.begin, i.end - i.begin, 0});
      else if (std::ranges::find(kept, *span) == kept.end())
        kept.push_back(*span);
    }
    for (const Span& s : live_)
      if (s.set == set && std::ranges::find(kept, s) == kept.end()) free_[set].push_back(s.place);
    std::erase_if(live_, [&](const Span& s) { return s.set == set; });
    for (Span& s : missing) {
      s.place = take_place(set);
      to_.spans_.push_back(s);
      kept.push_back(s);
    }
    live_.insert(live_.end(), kept.begin(), kept.end());
  }

  std::size_t take_place(std::size_t set) {
    if (free_[set].empty()) {
      free_[set].push_back(used_);
      used_ += static_cast<std::size_t>(sets_[set].numbers() * kSampleLanes);
      to_.buffer_ = std::max(to_.buffer_, used_);
    }
    const std::size_t place = free_[set].back();
    free_[set].pop_back();
    return place;
  }

  [[nodiscard]] std::uint32_t place_of(std::size_t set, std::int32_t s, Index size) const {
    const auto span = std::ranges::find_if(live_, [&](const Span& l) {
      return l.set == set && l.first <= s && s + size <= l.first + l.size;
    });
    return static_cast<std::uint32_t>(span->place + static_cast<std::size_t>(s - span->first));
  }

  TangentSchedule& to_;
  const std::vector<TangentAssembler>& sets_;
  const BlockMatrix& pattern_;
  std::vector<Rows> rows_;
  std::vector<std::uint32_t> piece_of_;  // each row's
  std::vector<std::size_t> tally_;
  TangentPlan plan_;
  std::map<TangentPlan, std::uint32_t> plans_;
  std::vector<Span> live_;                      // of the segment, after its last piece
  std::vector<std::vector<std::size_t>> free_;  // places, of each set
  std::size_t used_ = 0;                        // numbers of the segment's buffer
};

TangentSchedule::TangentSchedule(const std::vector<TangentAssembler>& sets,
                                 const BlockMatrix& pattern) {
  Builder(*this, sets, pattern).build();
}

}  // namespace deform
