#include "galerkin.h"

#include <algorithm>

namespace multigrid {
namespace {

/// Coarse rows a strip: enough that few rows of AP are made twice.
constexpr Index kStrip = 1024;

void sort_unique(std::vector<std::int32_t>& values) {
  std::ranges::sort(values);
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

std::uint16_t slot_of(const std::vector<std::int32_t>& columns, std::int32_t begin,
                      std::int32_t end, std::int32_t column) {
  const auto first = columns.begin() + begin;
  return static_cast<std::uint16_t>(std::lower_bound(first, columns.begin() + end, column) - first);
}

}  // namespace

Galerkin::Galerkin(const Pattern& fine, const deform::Prolongation& p)
    : begin_(p.begin), node_(p.node), weight_(p.weight.begin(), p.weight.end()) {
  transpose(p.coarse);
  make_product(fine);
  make_coarse();
  make_strips();
}

void Galerkin::transpose(Index coarse) {
  t_begin_.assign(static_cast<std::size_t>(coarse) + 1, 0);
  for (const std::int32_t c : node_) ++t_begin_[static_cast<std::size_t>(c) + 1];
  for (std::size_t c = 0; c < static_cast<std::size_t>(coarse); ++c) t_begin_[c + 1] += t_begin_[c];
  t_node_.resize(node_.size());
  t_weight_.resize(node_.size());
  std::vector<std::int32_t> next(t_begin_.begin(), t_begin_.end() - 1);
  for (std::size_t a = 0; a + 1 < begin_.size(); ++a)
    for (auto q = static_cast<std::size_t>(begin_[a]); q < static_cast<std::size_t>(begin_[a + 1]);
         ++q) {
      const auto at = static_cast<std::size_t>(next[static_cast<std::size_t>(node_[q])]++);
      t_node_[at] = static_cast<std::int32_t>(a);
      t_weight_[at] = weight_[q];
    }
}

void Galerkin::make_product(const Pattern& fine) {
  product_begin_ = {0};
  slot_begin_ = {0};
  std::vector<std::int32_t> columns;
  for (std::size_t a = 0; a < static_cast<std::size_t>(fine.nodes); ++a) {
    columns.clear();
    const auto visit = [&](const auto& take) {
      for (auto p = fine.begin[a]; p < fine.begin[a + 1]; ++p) {
        const auto b = static_cast<std::size_t>(fine.column[static_cast<std::size_t>(p)]);
        for (auto q = begin_[b]; q < begin_[b + 1]; ++q) take(node_[static_cast<std::size_t>(q)]);
      }
    };
    visit([&](std::int32_t c) { columns.push_back(c); });
    sort_unique(columns);
    const auto begin = product_begin_.back();
    product_column_.insert(product_column_.end(), columns.begin(), columns.end());
    const auto end = static_cast<std::int32_t>(product_column_.size());
    visit([&](std::int32_t c) { slot_.push_back(slot_of(product_column_, begin, end, c)); });
    product_begin_.push_back(end);
    slot_begin_.push_back(slot_.size());
  }
}

void Galerkin::make_coarse() {
  coarse_.nodes = static_cast<Index>(t_begin_.size()) - 1;
  coarse_slot_begin_ = {0};
  std::vector<std::int32_t> columns;
  for (std::size_t c = 0; c < static_cast<std::size_t>(coarse_.nodes); ++c) {
    columns.clear();
    const auto visit = [&](const auto& take) {
      for (auto t = t_begin_[c]; t < t_begin_[c + 1]; ++t) {
        const auto a = static_cast<std::size_t>(t_node_[static_cast<std::size_t>(t)]);
        for (auto k = product_begin_[a]; k < product_begin_[a + 1]; ++k)
          take(product_column_[static_cast<std::size_t>(k)]);
      }
    };
    visit([&](std::int32_t d) { columns.push_back(d); });
    sort_unique(columns);
    const auto begin = coarse_.begin.back();
    coarse_.column.insert(coarse_.column.end(), columns.begin(), columns.end());
    const auto end = static_cast<std::int32_t>(coarse_.column.size());
    visit([&](std::int32_t d) { coarse_slot_.push_back(slot_of(coarse_.column, begin, end, d)); });
    coarse_.begin.push_back(end);
    coarse_slot_begin_.push_back(coarse_slot_.size());
  }
}

void Galerkin::make_strips() {
  local_.resize(t_node_.size());
  for (Index first = 0; first < coarse_.nodes; first += kStrip) {
    Strip strip{first, std::min(kStrip, coarse_.nodes - first), {}};
    const auto begin = t_begin_[static_cast<std::size_t>(first)],
               end = t_begin_[static_cast<std::size_t>(first + strip.size)];
    strip.rows.assign(t_node_.begin() + begin, t_node_.begin() + end);
    sort_unique(strip.rows);
    for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t)
      local_[t] = static_cast<std::int32_t>(std::ranges::lower_bound(strip.rows, t_node_[t]) -
                                            strip.rows.begin());
    strips_.push_back(std::move(strip));
  }
}

std::int32_t Galerkin::same(Index fine) const {
  const auto a = static_cast<std::size_t>(fine);
  return begin_[a + 1] - begin_[a] == 1 ? node_[static_cast<std::size_t>(begin_[a])] : -1;
}

void Galerkin::restrict_to(const LaneVector& r, LaneVector& f) const {
  deform::parallel_blocks(coarse_.nodes, kRows, [&](Index first, Index size) {
    for (Index c = first; c < first + size; ++c) {
      Lanes sum;
      for (auto t = static_cast<std::size_t>(t_begin_[static_cast<std::size_t>(c)]);
           t < static_cast<std::size_t>(t_begin_[static_cast<std::size_t>(c) + 1]); ++t)
        sum += t_weight_[t] * r.node(t_node_[t]);
      f.set(c, sum);
    }
  });
}

/// Row a of AP.
template <class Entry>
void Galerkin::make_row(const Level<Entry>& fine, std::size_t a, Sum<Entry>* blocks) const {
  std::fill_n(blocks, product_begin_[a + 1] - product_begin_[a], Sum<Entry>{});
  const std::uint16_t* slot = slot_.data() + slot_begin_[a];
  for (auto p = fine.pattern.begin[a]; p < fine.pattern.begin[a + 1]; ++p) {
    const float* value =
        fine.value.data() + Entry::start(fine.quads.place(static_cast<Index>(a), p));
    const auto b = static_cast<std::size_t>(fine.pattern.column[static_cast<std::size_t>(p)]);
    for (auto q = begin_[b]; q < begin_[b + 1]; ++q, ++slot)
      add<Entry>(blocks[*slot], weight_[static_cast<std::size_t>(q)], value);
  }
}

template <class Entry>
void Galerkin::multiply(const Level<Entry>& fine, Level<Entry>& coarse) const {
  deform::parallel_blocks(static_cast<Index>(strips_.size()), 1, [&](Index number, Index /*one*/) {
    const Strip& strip = strips_[static_cast<std::size_t>(number)];
    // Kept by each thread from call to call: no allocation once it is large enough.
    thread_local std::vector<Sum<Entry>> products, row;
    thread_local std::vector<std::size_t> begin;
    begin.assign(1, 0);
    for (const std::int32_t a : strip.rows)
      begin.push_back(begin.back() +
                      static_cast<std::size_t>(product_begin_[static_cast<std::size_t>(a) + 1] -
                                               product_begin_[static_cast<std::size_t>(a)]));
    products.resize(begin.back());
    for (std::size_t i = 0; i < strip.rows.size(); ++i)
      make_row(fine, static_cast<std::size_t>(strip.rows[i]), products.data() + begin[i]);
    for (Index c = strip.first; c < strip.first + strip.size; ++c) {
      const auto i = static_cast<std::size_t>(c);
      row.assign(static_cast<std::size_t>(coarse_.begin[i + 1] - coarse_.begin[i]), {});
      const std::uint16_t* slot = coarse_slot_.data() + coarse_slot_begin_[i];
      for (auto t = static_cast<std::size_t>(t_begin_[i]);
           t < static_cast<std::size_t>(t_begin_[i + 1]); ++t) {
        const auto local = static_cast<std::size_t>(local_[t]);
        for (std::size_t k = begin[local]; k < begin[local + 1]; ++k, ++slot)
          add<Entry>(row[*slot], t_weight_[t], products[k]);
      }
      for (std::size_t k = 0; k < row.size(); ++k)
        store(row[k],
              coarse.value.data() + Entry::start(coarse.quads.place(
                                        c, coarse_.begin[i] + static_cast<std::int32_t>(k))));
    }
  });
}

template void Galerkin::multiply(const Level<Block>&, Level<Block>&) const;
template void Galerkin::multiply(const Level<Scalar>&, Level<Scalar>&) const;

}  // namespace multigrid
