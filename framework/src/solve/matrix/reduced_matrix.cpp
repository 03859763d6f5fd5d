#include "solve/matrix/reduced_matrix.h"

#include <algorithm>

#include "solve/assembly/pattern.h"

namespace deform {
namespace {

/// A degree of freedom that is one unknown and nothing else.
bool is_free(const std::vector<ReducedMatrix::Part>& row) {
  return row.size() == 1 && row.front().coefficient == 1;
}

}  // namespace

ReducedMatrix::ReducedMatrix(Index unknowns, const Rows& rows, Index components,
                             const VisitEntries& visit_entries) {
  make_pattern(unknowns, rows, visit_entries);
  source_.assign(matrix_.column.size(), -1);
  visit_entries([&](Index i, Index j, Index place) {
    for (const Part& p : rows[static_cast<std::size_t>(i)])
      for (const Part& q : rows[static_cast<std::size_t>(j)]) {
        const std::int32_t target = place_of(p.unknown, q.unknown);
        std::int32_t& source = source_[static_cast<std::size_t>(target)];
        const double coefficient = p.coefficient * q.coefficient;
        if (source < 0 && coefficient == 1) {
          source = static_cast<std::int32_t>(place);
        } else {
          tied_.push_back({target, static_cast<std::int32_t>(place), coefficient});
        }
      }
  });
  diagonal_.assign(static_cast<std::size_t>(unknowns), -1);
  node_.assign(static_cast<std::size_t>(unknowns), -1);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto node = static_cast<std::int32_t>(static_cast<Index>(i) / components);
    if (is_free(rows[i])) {
      const auto unknown = rows[i].front().unknown;
      std::int32_t& known = node_[static_cast<std::size_t>(unknown)];
      if (known < 0) {
        known = node;
        diagonal_[static_cast<std::size_t>(unknown)] = place_of(unknown, unknown);
        continue;
      }
    }
    for (const Part& p : rows[i])
      for (const Part& q : rows[i])
        tied_diagonal_.push_back(
            {place_of(p.unknown, q.unknown), node, p.coefficient * q.coefficient});
  }
}

void ReducedMatrix::make_pattern(Index unknowns, const Rows& rows,
                                 const VisitEntries& visit_entries) {
  PatternBuilder pattern(unknowns);
  visit_entries([&](Index i, Index j, Index /*place*/) {
    for (const Part& p : rows[static_cast<std::size_t>(i)])
      for (const Part& q : rows[static_cast<std::size_t>(j)]) pattern.add(p.unknown, q.unknown);
  });
  for (const auto& row : rows)
    for (const Part& p : row)
      for (const Part& q : row) pattern.add(p.unknown, q.unknown);
  matrix_ = pattern.build();
}

std::int32_t ReducedMatrix::place_of(Index row, Index column) const {
  const auto begin = matrix_.column.begin() + matrix_.row_begin[static_cast<std::size_t>(row)];
  const auto end = matrix_.column.begin() + matrix_.row_begin[static_cast<std::size_t>(row) + 1];
  return static_cast<std::int32_t>(std::lower_bound(begin, end, static_cast<std::int32_t>(column)) -
                                   matrix_.column.begin());
}

void ReducedMatrix::fill(const std::vector<double>& values, const NodeValues& d) {
  for (std::size_t p = 0; p < matrix_.value.size(); ++p)
    matrix_.value[p] = source_[p] < 0 ? 0 : values[static_cast<std::size_t>(source_[p])];
  for (const Extra& e : tied_)
    matrix_.value[static_cast<std::size_t>(e.target)] +=
        e.coefficient * values[static_cast<std::size_t>(e.source)];
  for (std::size_t q = 0; q < diagonal_.size(); ++q)
    matrix_.value[static_cast<std::size_t>(diagonal_[q])] += d[node_[q]];
  for (const Extra& e : tied_diagonal_)
    matrix_.value[static_cast<std::size_t>(e.target)] += e.coefficient * d[e.source];
}

}  // namespace deform
