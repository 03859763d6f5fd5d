#include "galerkin.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>

#include <deform/error.h>
#include <deform/parallel.h>

#include "entries.h"

namespace multigrid {
namespace {

/// A coarse node has more than half of what it gives in the row of the fine node at its place.
constexpr float kSame = 0.5F;
/// Groups of coarse rows that one task makes.
constexpr Index kGroups = 16;

AlikeRows rows_of(const deform::Prolongation& p) {
  AlikeRows rows;
  std::vector<AlikeRows::Entry> row;
  for (std::size_t a = 0; a + 1 < p.begin.size(); ++a) {
    row.clear();
    for (auto q = static_cast<std::size_t>(p.begin[a]);
         q < static_cast<std::size_t>(p.begin[a + 1]); ++q)
      row.push_back({p.node[q], static_cast<float>(p.weight[q])});
    rows.add(row);
  }
  return rows;
}

AlikeRows transposed_rows_of(const deform::Prolongation& p) {
  std::vector<std::size_t> begin(static_cast<std::size_t>(p.coarse) + 1, 0);
  for (const std::int32_t c : p.node) ++begin[static_cast<std::size_t>(c) + 1];
  for (std::size_t c = 0; c + 1 < begin.size(); ++c) begin[c + 1] += begin[c];
  std::vector<AlikeRows::Entry> all(p.node.size());
  std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
  for (std::size_t a = 0; a + 1 < p.begin.size(); ++a)
    for (auto q = static_cast<std::size_t>(p.begin[a]);
         q < static_cast<std::size_t>(p.begin[a + 1]); ++q)
      all[next[static_cast<std::size_t>(p.node[q])]++] = {static_cast<std::int32_t>(a),
                                                          static_cast<float>(p.weight[q])};
  AlikeRows rows;
  for (std::size_t c = 0; c + 1 < begin.size(); ++c)
    rows.add(std::span(all).subspan(begin[c], begin[c + 1] - begin[c]));
  return rows;
}

/// Both triangles of a symmetric pattern.
Pattern both_triangles(const Pattern& half) {
  std::vector<std::int32_t> size(static_cast<std::size_t>(half.nodes), 0);
  for (Index a = 0; a < half.nodes; ++a)
    for (const std::int32_t b : half.columns(a)) {
      ++size[static_cast<std::size_t>(a)];
      if (b != a) ++size[static_cast<std::size_t>(b)];
    }
  Pattern full;
  full.nodes = half.nodes;
  for (const std::int32_t s : size) full.begin.push_back(full.begin.back() + s);
  full.column.resize(static_cast<std::size_t>(full.begin.back()));
  std::vector<std::int32_t> next(full.begin.begin(), full.begin.end() - 1);
  // Rows come in ascending order, so the columns below the diagonal do, and come first.
  const auto add = [&](Index row, Index column) {
    full.column[static_cast<std::size_t>(next[static_cast<std::size_t>(row)]++)] =
        static_cast<std::int32_t>(column);
  };
  for (Index a = 0; a < half.nodes; ++a)
    for (const std::int32_t b : half.columns(a).subspan(1)) add(b, a);
  for (Index a = 0; a < half.nodes; ++a)
    for (const std::int32_t b : half.columns(a)) add(a, b);
  return full;
}

template <class Value>
void sort_unique(std::vector<Value>& values) {
  std::ranges::sort(values);
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

template <class Value>
std::size_t place_in(const std::vector<Value>& values, const Value& value) {
  return static_cast<std::size_t>(std::ranges::lower_bound(values, value) - values.begin());
}

}  // namespace

/// Makes the plans of coarse rows in ascending order.
class Galerkin::Planner {
 public:
  Planner(const Pattern& fine, const AlikeRows& p, const AlikeRows& transposed)
      : fine_(both_triangles(fine)), p_(p), transposed_(transposed) {}

  /// Of the last row, at or behind it.
  [[nodiscard]] const std::vector<std::int32_t>& coarse_columns() const { return coarse_columns_; }

  /// Whether row c has the plan of the row before, by as much further; goes on to it if so.
  [[nodiscard]] bool goes_on(Index c) {
    if (c == 0 || !transposed_.are_alike(c, c - 1)) return false;
    const std::int32_t step = transposed_.first(c) - transposed_.first(c - 1);
    for (std::size_t t = 0; t < transposed_.size(c); ++t) {
      const std::int32_t a = transposed_.entry(c, t).column;
      if (!std::ranges::equal(fine_.columns(a), fine_.columns(a - step), {}, {},
                              [&](std::int32_t column) { return column + step; }))
        return false;
    }
    for (const std::int32_t b : fine_columns_)
      if (!p_.are_alike(b, b + step) || p_.first(b + step) != p_.first(b) + 1) return false;
    for (std::int32_t& b : fine_columns_) b += step;
    for (std::int32_t& d : coarse_columns_) ++d;
    return true;
  }

  /// Σ over all a of column c of P, all b of row a of A, all d ≥ c of row b of P.
  [[nodiscard]] Plan plan(Index c) {
    Plan plan;
    const auto row = static_cast<std::int32_t>(c);
    find_columns(row, plan.sources);
    for (const std::int32_t d : coarse_columns_) plan.distance.push_back(d - row);
    // Of each entry, those as they are and those mirrored.
    std::vector<std::array<std::vector<Term>, 2>> terms(coarse_columns_.size());
    each_entry(row, [&](std::int32_t a, std::int32_t b, float weight, const Source& source) {
      const auto from = static_cast<std::uint16_t>(place_in(plan.sources, source));
      for (std::size_t q = 0; q < p_.size(b); ++q)
        if (const auto [d, share] = p_.entry(b, q); d >= row)
          terms[place_in(coarse_columns_, d)][b < a ? 1 : 0].push_back({from, weight * share});
    });
    for (const auto& of_entry : terms)
      for (const std::vector<Term>& some : of_entry) {
        plan.terms.insert(plan.terms.end(), some.begin(), some.end());
        plan.end.push_back(static_cast<std::uint32_t>(plan.terms.size()));
      }
    return plan;
  }

 private:
  /// Calls visit(a, b, weight of a, where (a, b) is kept) for the entries of A that row c needs.
  template <class Visit>
  void each_entry(std::int32_t c, const Visit& visit) const {
    const std::int32_t first = transposed_.first(c);
    for (std::size_t t = 0; t < transposed_.size(c); ++t) {
      const auto [a, weight] = transposed_.entry(c, t);
      for (const std::int32_t b : fine_.columns(a))
        visit(a, b, weight, Source{std::min(a, b) - first, std::abs(b - a)});
    }
  }

  void find_columns(std::int32_t c, std::vector<Source>& sources) {
    fine_columns_.clear();
    coarse_columns_.clear();
    each_entry(c, [&](std::int32_t /*a*/, std::int32_t b, float /*weight*/, const Source& source) {
      fine_columns_.push_back(b);
      sources.push_back(source);
    });
    sort_unique(fine_columns_);
    sort_unique(sources);
    if (sources.size() > std::numeric_limits<std::uint16_t>::max())
      throw deform::Error(deform::ExitCode::internal_error,
                          "multigrid: a coarse row is made of too many entries");
    for (const std::int32_t b : fine_columns_)
      for (std::size_t q = 0; q < p_.size(b); ++q)
        if (const std::int32_t d = p_.entry(b, q).column; d >= c) coarse_columns_.push_back(d);
    sort_unique(coarse_columns_);
  }

  Pattern fine_;  // both triangles
  const AlikeRows &p_, &transposed_;
  std::vector<std::int32_t> fine_columns_, coarse_columns_;  // of the last row
};

Galerkin::Galerkin(const Pattern& fine, const deform::Prolongation& p)
    : p_(rows_of(p)), transposed_(transposed_rows_of(p)), up_(p_), down_(transposed_) {
  coarse_.nodes = transposed_.rows();
  Planner planner(fine, p_, transposed_);
  std::map<Plan, std::int32_t> known;
  for (Index c = 0; c < coarse_.nodes; ++c) {
    begin_.push_back(transposed_.first(c));
    if (planner.goes_on(c)) {
      plan_.push_back(plan_.back());
    } else {
      const auto next = static_cast<std::int32_t>(known.size());
      const auto [at, is_new] = known.try_emplace(planner.plan(c), next);
      if (is_new) plans_.push_back(at->first);
      plan_.push_back(at->second);
    }
    const std::vector<std::int32_t>& columns = planner.coarse_columns();
    coarse_.column.insert(coarse_.column.end(), columns.begin(), columns.end());
    coarse_.begin.push_back(static_cast<std::int32_t>(coarse_.column.size()));
  }
}

/// Whether what coarse row `last` is made of lies in the strips in which that of `first` does.
bool Galerkin::lies_in_strips(const Strips& fine, std::int32_t first, std::int32_t last) const {
  const auto at = [&](std::int32_t c) { return begin_[static_cast<std::size_t>(c)]; };
  const std::vector<Source>& sources =
      plans_[static_cast<std::size_t>(plan_[static_cast<std::size_t>(first)])].sources;
  return std::ranges::all_of(sources, [&](const Source& s) {
    const Strips::Strip& strip = fine.strip_of(at(first) + s.row);
    return at(last) + s.row < strip.row + strip.size;
  });
}

/// The end of the coarse rows from one on that are made together.
std::int32_t Galerkin::group_end(const Strips& fine, const Strips& coarse,
                                 std::int32_t first) const {
  const Strips::Strip& strip = coarse.strip_of(first);
  const auto most =
      static_cast<std::int32_t>(std::min<Index>(strip.row + strip.size, first + kCoarseRows));
  const auto step_to = [&](std::int32_t c) {
    return begin_[static_cast<std::size_t>(c)] - begin_[static_cast<std::size_t>(c - 1)];
  };
  std::int32_t end = first + 1;
  while (end < most &&
         plan_[static_cast<std::size_t>(end)] == plan_[static_cast<std::size_t>(first)] &&
         (step_to(end) == 1 || step_to(end) == 2) && step_to(end) == step_to(first + 1) &&
         lies_in_strips(fine, first, end))
    ++end;
  return end;
}

void Galerkin::bind(const Strips& fine, const Strips& coarse, Index numbers) {
  const auto nodes = static_cast<std::int32_t>(coarse_.nodes);
  for (std::int32_t c = 0, end = 0; c < nodes; c = end) {
    end = group_end(fine, coarse, c);
    const auto row = static_cast<std::size_t>(c), plan = static_cast<std::size_t>(plan_[row]);
    groups_.push_back(
        {end - c, end - c == 1 ? 1 : begin_[row + 1] - begin_[row], plan, places_.size()});
    for (const Source& s : plans_[plan].sources)
      places_.push_back(fine.place(begin_[row] + s.row, s.distance, numbers));
    for (const std::int32_t distance : plans_[plan].distance)
      places_.push_back(coarse.place(c, distance, numbers));
  }
  coarse_ = {};
  plan_ = begin_ = {};
  p_ = transposed_ = {};
}

std::int32_t Galerkin::same(Index fine) const {
  for (std::size_t q = 0; q < p_.size(fine); ++q)
    if (const AlikeRows::Entry e = p_.entry(fine, q); e.weight > kSame) return e.column;
  return -1;
}

void Galerkin::restrict_to(const Field<float>& r, Field<float>& f) const {
  deform::parallel_blocks(static_cast<Index>(down_.tasks().size()), 1, [&](Index t, Index) {
    down_.multiply(down_.tasks()[static_cast<std::size_t>(t)], r, f, false);
  });
}

template <class Entry>
void Galerkin::multiply(const std::vector<float>& fine, std::vector<float>& coarse) const {
  deform::parallel_blocks(
      static_cast<Index>(groups_.size()), kGroups, [&](Index first, Index size) {
        for (Index g = first; g < first + size; ++g) {
          const Group& group = groups_[static_cast<std::size_t>(g)];
          const Plan& plan = plans_[group.plan];
          const Place* const source = places_.data() + group.place;
          Entry::combine(CoarseRows{group.size, group.step, source, source + plan.sources.size(),
                                    static_cast<Index>(plan.distance.size()), plan.terms.data(),
                                    plan.end.data()},
                         fine.data(), coarse.data());
        }
      });
}

template void Galerkin::multiply<Block>(const std::vector<float>& fine,
                                        std::vector<float>& coarse) const;
template void Galerkin::multiply<Scalar>(const std::vector<float>& fine,
                                         std::vector<float>& coarse) const;

}  // namespace multigrid
