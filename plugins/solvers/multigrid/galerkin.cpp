#include "galerkin.h"

#include <algorithm>
#include <map>

namespace multigrid {
namespace {

/// A coarse node has more than half of what it gives in the row of the fine node at its place.
constexpr float kSame = 0.5F;

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

void sort_unique(std::vector<std::int32_t>& values) {
  std::ranges::sort(values);
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

std::uint16_t place_in(const std::vector<std::int32_t>& values, std::int32_t value) {
  return static_cast<std::uint16_t>(std::ranges::lower_bound(values, value) - values.begin());
}

std::span<const std::int32_t> columns_of(const Pattern& a, std::int32_t row) {
  const auto r = static_cast<std::size_t>(row);
  return std::span(a.column).subspan(static_cast<std::size_t>(a.begin[r]),
                                     static_cast<std::size_t>(a.begin[r + 1] - a.begin[r]));
}

}  // namespace

/// Makes the plans of coarse rows in ascending order.
class Galerkin::Planner {
 public:
  Planner(const Pattern& fine, const AlikeRows& p, const AlikeRows& transposed)
      : fine_(fine), p_(p), transposed_(transposed) {}

  [[nodiscard]] const std::vector<std::int32_t>& fine_columns() const { return fine_columns_; }
  [[nodiscard]] const std::vector<std::int32_t>& coarse_columns() const { return coarse_columns_; }

  /// Whether row c has the plan of the row before, by as much further; goes on to it if so.
  [[nodiscard]] bool goes_on(Index c) {
    if (c == 0 || !transposed_.are_alike(c, c - 1)) return false;
    const std::int32_t step = transposed_.entry(c, 0).column - transposed_.entry(c - 1, 0).column;
    for (std::size_t t = 0; t < transposed_.size(c); ++t) {
      const std::int32_t a = transposed_.entry(c, t).column;
      if (!std::ranges::equal(columns_of(fine_, a), columns_of(fine_, a - step), {}, {},
                              [&](std::int32_t column) { return column + step; }))
        return false;
    }
    const auto first_of = [&](std::int32_t a) { return p_.entry(a, 0).column; };
    for (const std::int32_t b : fine_columns_)
      if (!p_.are_alike(b, b + step) || first_of(b + step) != first_of(b) + 1) return false;
    for (std::int32_t& b : fine_columns_) b += step;
    for (std::int32_t& d : coarse_columns_) ++d;
    return true;
  }

  [[nodiscard]] Plan plan(Index c) {
    Plan plan;
    fine_columns_.clear();
    coarse_columns_.clear();
    const auto each_row = [&](const auto& visit) {
      for (std::size_t t = 0; t < transposed_.size(c); ++t)
        visit(columns_of(fine_, transposed_.entry(c, t).column));
    };
    each_row([&](std::span<const std::int32_t> columns) {
      fine_columns_.insert(fine_columns_.end(), columns.begin(), columns.end());
    });
    sort_unique(fine_columns_);
    each_row([&](std::span<const std::int32_t> columns) {
      plan.size.push_back(static_cast<std::uint16_t>(columns.size()));
      for (const std::int32_t b : columns) plan.slot.push_back(place_in(fine_columns_, b));
    });
    for (const std::int32_t b : fine_columns_)
      for (std::size_t q = 0; q < p_.size(b); ++q) coarse_columns_.push_back(p_.entry(b, q).column);
    sort_unique(coarse_columns_);
    std::vector<std::vector<Share>> shares(coarse_columns_.size());
    for (std::size_t i = 0; i < fine_columns_.size(); ++i)
      for (std::size_t q = 0; q < p_.size(fine_columns_[i]); ++q) {
        const AlikeRows::Entry e = p_.entry(fine_columns_[i], q);
        shares[place_in(coarse_columns_, e.column)].push_back(
            {static_cast<std::uint16_t>(i), e.weight});
      }
    for (const std::vector<Share>& of_entry : shares) {
      plan.shares.insert(plan.shares.end(), of_entry.begin(), of_entry.end());
      plan.end.push_back(static_cast<std::uint16_t>(plan.shares.size()));
    }
    for (std::size_t t = 0; t < transposed_.size(c); ++t)
      plan.weight.push_back(transposed_.entry(c, t).weight);
    plan.slots = static_cast<std::uint16_t>(fine_columns_.size());
    return plan;
  }

 private:
  const Pattern& fine_;
  const AlikeRows &p_, &transposed_;
  std::vector<std::int32_t> fine_columns_, coarse_columns_;  // of the last row
};

Galerkin::Galerkin(const Pattern& fine, const Quads& quads, const deform::Prolongation& p)
    : p_(rows_of(p)), transposed_(transposed_rows_of(p)) {
  for (Index a = 0; a < fine.nodes; ++a) start_.push_back(quads.first_place(fine, a));
  coarse_.nodes = transposed_.rows();
  Planner planner(fine, p_, transposed_);
  std::map<Plan, std::int32_t> known;
  for (Index c = 0; c < coarse_.nodes; ++c) {
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

std::int32_t Galerkin::same(Index fine) const {
  for (std::size_t q = 0; q < p_.size(fine); ++q)
    if (const AlikeRows::Entry e = p_.entry(fine, q); e.weight > kSame) return e.column;
  return -1;
}

void Galerkin::restrict_to(const LaneVector& r, LaneVector& f) const {
  deform::parallel_blocks(coarse_.nodes, kRows, [&](Index first, Index size) {
    for (Index c = first; c < first + size; ++c) f.set(c, transposed_.product(c, r));
  });
}

template <class Entry>
void Galerkin::multiply(const Level<Entry>& fine, Level<Entry>& coarse) const {
  deform::parallel_blocks(coarse_.nodes, kRows, [&](Index first, Index size) {
    for (Index c = first, next = c; c < first + size; c = next) {
      while (next < first + size && next < c + kQuad &&
             plan_[static_cast<std::size_t>(next)] == plan_[static_cast<std::size_t>(c)])
        ++next;
      const Index last = next - 1;
      make_rows(fine, {c, std::min(c + 1, last), std::min(c + 2, last), last}, coarse);
    }
  });
}

/// Four rows of one plan at once; where there are less of it, the last comes again.
template <class Entry>
void Galerkin::make_rows(const Level<Entry>& fine, const std::array<Index, kQuad>& c,
                         Level<Entry>& coarse) const {
  constexpr std::size_t kNumbers = kQuad * Entry::kSize;  // of an entry of four rows
  // Kept by each thread from call to call: no allocation once they are large enough.
  thread_local std::vector<float> t, sums;
  const Plan& plan = plan_of(c[0]);
  t.assign(kNumbers * plan.slots, 0);
  const std::uint16_t* slot = plan.slot.data();
  for (std::size_t i = 0; i < plan.size.size(); ++i) {
    const std::int32_t size = plan.size[i];
    std::array<std::int32_t, kQuad> a{}, place{};
    FourRows from{};
    const auto add = [&](std::int32_t first, std::int32_t entries) {
      for (std::size_t row = 0; row < kQuad; ++row)
        from[row] = fine.value.data() + Entry::start(place[row]);
      Entry::add_rows(plan.weight[i], from, slot + first, entries, t.data());
    };
    for (std::size_t row = 0; row < kQuad; ++row) {
      a[row] = transposed_.entry(c[row], i).column;
      place[row] = start_[static_cast<std::size_t>(a[row])];
    }
    if (std::ranges::min(place) >= 0) {
      add(0, size);
    } else {
      for (std::int32_t k = 0; k < size; ++k) {
        for (std::size_t row = 0; row < kQuad; ++row)
          place[row] =
              fine.quads.place(a[row], fine.pattern.begin[static_cast<std::size_t>(a[row])] + k);
        add(k, 1);
      }
    }
    slot += size;
  }
  sums.resize(kNumbers * plan.end.size());
  Entry::combine(plan.shares.data(), plan.end.data(), static_cast<Index>(plan.end.size()), t.data(),
                 sums.data());
  for (std::size_t row = 0; row < kQuad; ++row) {
    std::int32_t p = coarse_.begin[static_cast<std::size_t>(c[row])];
    for (std::size_t k = 0; k < plan.end.size(); ++k)
      Entry::store_row(sums.data() + kNumbers * k, row,
                       coarse.value.data() + Entry::start(coarse.quads.place(c[row], p++)));
  }
}

template void Galerkin::multiply(const Level<Block>& fine, Level<Block>& coarse) const;
template void Galerkin::multiply(const Level<Scalar>& fine, Level<Scalar>& coarse) const;

}  // namespace multigrid
