#include "solve/tuple_assembler.h"

#include <algorithm>

#include "parallel/parallel.h"
#include "plugin/guard.h"

namespace deform {

TupleAssembler::TupleAssembler(std::size_t number, std::string origin,
                               std::shared_ptr<const TupleTerm> term, Index nodes)
    : number_(number), origin_(std::move(origin)), term_(std::move(term)), width_(term_->width()) {
  const auto& tuples = term_->tuples();
  if (width_ < 1 || tuples.size() % static_cast<std::size_t>(width_) != 0 ||
      std::ranges::any_of(tuples, [&](std::int32_t n) { return n < 0 || n >= nodes; }))
    throw PluginFailure("plugin " + origin_ + ": its tuples are not rows of `width` node numbers");
  k_.resize(tuples.size() * static_cast<std::size_t>(width_));
  force_.resize(tuples.size());
  begin_.assign(static_cast<std::size_t>(nodes) + 1, 0);
  for (const std::int32_t n : tuples) ++begin_[static_cast<std::size_t>(n) + 1];
  for (std::size_t n = 1; n < begin_.size(); ++n) begin_[n] += begin_[n - 1];
  std::vector<Index> next(begin_.begin(), begin_.end() - 1);
  places_.resize(tuples.size());
  for (std::size_t p = 0; p < tuples.size(); ++p)
    places_[static_cast<std::size_t>(next[static_cast<std::size_t>(tuples[p])]++)] =
        static_cast<Index>(p);
}

TupleBlock TupleAssembler::block(const NodeVectors& now, const NodeVectors& lagged, Index first,
                                 Index size) const {
  return {.first = first,
          .size = size,
          .width = width_,
          .nodes = term_->tuples().data() + first * width_,
          .now = &now,
          .lagged = &lagged};
}

void TupleAssembler::evaluate(const NodeVectors& now, const NodeVectors& lagged, Part part) {
  const Index w = width_;
  parallel_blocks(static_cast<Index>(count()), kBlock, [&](Index first, Index size) {
    const Values k{k_.data() + first * w * w, static_cast<std::size_t>(size * w * w)};
    const std::span<Vec3> c{force_.data() + first * w, static_cast<std::size_t>(size * w)};
    std::ranges::fill(k, 0.0);
    std::ranges::fill(c, Vec3::Zero());
    const TupleBlock tuples = block(now, lagged, first, size);
    guarded(origin_, "computing its force", [&] { term_->affine_force(tuples, k, c); });
    // c becomes the force −Σ_b k_ab r_b − c_a.
    for (Index t = 0; t < size; ++t)
      for (int a = 0; a < width_; ++a) {
        Vec3& f = c[static_cast<std::size_t>(t * w + a)];
        f = -f;
        for (int b = 0; b < width_ && part == Part::stress; ++b)
          f -= k[static_cast<std::size_t>((t * w + a) * w + b)] * tuples.r(t, b);
      }
  });
}

void TupleAssembler::add_force(NodeVectors& f) const {
  parallel_blocks(f.rows(), kBlock, [&](Index first, Index size) {
    for (Index a = first; a < first + size; ++a)
      for (Index p = begin_[static_cast<std::size_t>(a)];
           p < begin_[static_cast<std::size_t>(a) + 1]; ++p)
        f.row(a) +=
            force_[static_cast<std::size_t>(places_[static_cast<std::size_t>(p)])].transpose();
  });
}

void TupleAssembler::bind(const SparseMatrix& pattern) {
  slot_.clear();
  for (std::size_t t = 0; t < count(); ++t)
    for (int a = 0; a < width_; ++a) {
      const auto row = static_cast<std::size_t>(node(t, a));
      const auto begin = pattern.column.begin() + pattern.row_begin[row];
      const auto end = pattern.column.begin() + pattern.row_begin[row + 1];
      for (int b = 0; b < width_; ++b)
        slot_.push_back(std::lower_bound(begin, end, node(t, b)) - pattern.column.begin());
    }
}

void TupleAssembler::add_operator(SparseMatrix& k) const {
  parallel_blocks(k.size, kBlock, [&](Index first, Index size) {
    for (Index a = first; a < first + size; ++a)
      for (Index p = begin_[static_cast<std::size_t>(a)];
           p < begin_[static_cast<std::size_t>(a) + 1]; ++p) {
        const Index place = places_[static_cast<std::size_t>(p)] * width_;
        for (Index b = 0; b < width_; ++b)
          k.value[static_cast<std::size_t>(slot_[static_cast<std::size_t>(place + b)])] +=
              k_[static_cast<std::size_t>(place + b)];
      }
  });
}

double TupleAssembler::energy(const NodeVectors& r) const {
  std::vector<double> energies(count(), 0.0);
  parallel_blocks(static_cast<Index>(count()), kBlock, [&](Index first, Index size) {
    guarded(origin_, "computing its energy", [&] {
      term_->energy(block(r, r, first, size),
                    {energies.data() + first, static_cast<std::size_t>(size)});
    });
  });
  double sum = 0;
  for (const double e : energies) sum += e;
  return sum;
}

}  // namespace deform
