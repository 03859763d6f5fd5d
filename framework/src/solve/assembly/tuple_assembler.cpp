#include "solve/assembly/tuple_assembler.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "deform/parallel.h"

#include "plugin/guard.h"

namespace deform {
namespace {

/// What of the work of a tuple's forces may be rounding, relative to its energies: over a short
/// step the force that it would take to do it is far larger than the work.
constexpr double kRoundingOfWork = 64 * std::numeric_limits<double>::epsilon();

}  // namespace

TupleAssembler::TupleAssembler(std::size_t number, std::string origin,
                               std::shared_ptr<const TupleTerm> term, const TermTraits& traits,
                               const Rows& rows)
    : number_(number), origin_(std::move(origin)), term_(std::move(term)), traits_(traits) {
  guarded(origin_, "naming its tuples", [this] {
    width_ = term_->width(), tuples_ = term_->tuples();
    scalars_ = std::ssize(term_->scalars());
  });
  check_tuples(rows.shared + scalars_);
  names_scalars_ = std::ranges::any_of(tuples_, [&](std::int32_t n) { return n >= rows.nodes; });
  number_scalars(rows);
  k_.resize(tuples_.size() * static_cast<std::size_t>(width_));
  force_.resize(tuples_.size());
  begin_.assign(static_cast<std::size_t>(rows.all) + 1, 0);
  for (const std::int32_t n : tuples_) ++begin_[static_cast<std::size_t>(n) + 1];
  for (std::size_t n = 1; n < begin_.size(); ++n) begin_[n] += begin_[n - 1];
  std::vector<Index> next(begin_.begin(), begin_.end() - 1);
  places_.resize(tuples_.size());
  for (std::size_t p = 0; p < tuples_.size(); ++p)
    places_[static_cast<std::size_t>(next[static_cast<std::size_t>(tuples_[p])]++)] =
        static_cast<Index>(p);
}

/// The term counts its own; the model all.
void TupleAssembler::number_scalars(const Rows& rows) {
  for (std::int32_t& n : tuples_)
    if (n >= rows.shared) n += static_cast<std::int32_t>(rows.before);
}

void TupleAssembler::check_tuples(Index nodes) const {
  const std::string plugin = "plugin " + origin_ + ": ";
  if (width_ < 1)
    throw PluginFailure(plugin + "width() is " + std::to_string(width_) + ", expected 1 at least");
  if (tuples_.size() % static_cast<std::size_t>(width_) != 0)
    throw PluginFailure(plugin + "tuples() has " + std::to_string(tuples_.size()) +
                        " node numbers, expected a multiple of width(), " + std::to_string(width_));
  const auto bad = std::ranges::find_if(
      tuples_, [nodes](std::int32_t node) { return node < 0 || node >= nodes; });
  if (bad != tuples_.end())
    throw PluginFailure(plugin + "tuple " + std::to_string((bad - tuples_.begin()) / width_) +
                        " has node " + std::to_string(*bad) + ", expected 0 to " +
                        std::to_string(nodes - 1));
}

TupleBlock TupleAssembler::block(const NodeVectors& now, const NodeVectors& lagged, Index first,
                                 Index size) const {
  return {.first = first,
          .size = size,
          .width = width_,
          .nodes = tuples_.data() + first * width_,
          .now = &now,
          .lagged = &lagged};
}

void TupleAssembler::evaluate(const NodeVectors& now, const NodeVectors& lagged, Part part) {
  // The whole of an explicit term's force is constant.
  evaluate_affine(now, lagged, part == Part::stress || is_explicit());
}

void TupleAssembler::evaluate_affine(const NodeVectors& now, const NodeVectors& lagged,
                                     bool with_k) {
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
        for (int b = 0; b < width_ && with_k; ++b)
          f -= k[static_cast<std::size_t>((t * w + a) * w + b)] * tuples.r(t, b);
      }
  });
}

void TupleAssembler::evaluate_over_step(const NodeVectors& from, const NodeVectors& middle,
                                        const NodeVectors& to,
                                        const std::vector<double>& energies_from) {
  if (is_explicit()) {
    evaluate_affine(middle, middle, true);
  } else {
    evaluate_affine(middle, to, true);
    force_at_end_ = force_;
    evaluate_affine(middle, from, true);
    for (std::size_t p = 0; p < force_.size(); ++p)
      force_[p] = 0.5 * (force_[p] + force_at_end_[p]);
  }
  add_missing_work(from, to, energies_from, energies(to));
}

/// F_a −= λ Σ_b Δd_ab (r̄_a − r̄_b), d_ab = |r_a − r_b|²: as Δd_ab = 2 (r̄_a − r̄_b)·(Δr_a − Δr_b),
/// its work is −½ λ Σ_{a<b} Δd_ab².
void TupleAssembler::add_missing_work(const NodeVectors& from, const NodeVectors& to,
                                      const std::vector<double>& energies_from,
                                      const std::vector<double>& energies_to) {
  parallel_blocks(static_cast<Index>(count()), kBlock, [&](Index first, Index size) {
    for (Index i = first; i < first + size; ++i) {
      const auto t = static_cast<std::size_t>(i);
      Vec3* const force = force_.data() + i * width_;
      const auto middle = [&](int a) {
        return Vec3(0.5 * (from.row(node(t, a)) + to.row(node(t, a))));
      };
      const auto growth = [&](int a, int b) {
        const Index i_a = node(t, a), i_b = node(t, b);
        return (to.row(i_a) - to.row(i_b)).squaredNorm() -
               (from.row(i_a) - from.row(i_b)).squaredNorm();
      };
      double missing = energies_to[t] - energies_from[t], squares = 0;
      double sizes = std::abs(energies_to[t]) + std::abs(energies_from[t]);
      for (int a = 0; a < width_; ++a) {
        const double work = force[a].dot(Vec3(to.row(node(t, a)) - from.row(node(t, a))));
        missing += work;
        sizes += std::abs(work);
        for (int b = 0; b < a; ++b) squares += growth(a, b) * growth(a, b);
      }
      const bool is_rounding = std::abs(missing) <= kRoundingOfWork * sizes;
      const double lambda = squares > 0 && !is_rounding ? 2 * missing / squares : 0;
      for (int a = 0; a < width_ && std::isfinite(lambda); ++a)
        for (int b = 0; b < a; ++b) {
          const Vec3 along = lambda * growth(a, b) * (middle(a) - middle(b));
          force[a] -= along;
          force[b] += along;
        }
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
  if (is_explicit()) return;
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

void TupleAssembler::add_tangent(const NodeVectors& r, Tangent kind, BlockMatrix& k,
                                 double factor) {
  if (!traits_.potential || factor == 0) return;
  const Index n = Index{3} * width_;
  h_.assign(count() * static_cast<std::size_t>(n * n), 0.0);
  parallel_blocks(static_cast<Index>(count()), kBlock, [&](Index first, Index size) {
    guarded(origin_, "computing its tangent", [&] {
      term_->tangent(block(r, r, first, size), kind,
                     {h_.data() + first * n * n, static_cast<std::size_t>(size * n * n)});
    });
  });
  using Matrix =
      Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;
  parallel_blocks(k.nodes, kBlock, [&](Index first, Index size) {
    for (Index a = first; a < first + size; ++a)
      for (Index p = begin_[static_cast<std::size_t>(a)];
           p < begin_[static_cast<std::size_t>(a) + 1]; ++p) {
        const Index tuple = places_[static_cast<std::size_t>(p)] / width_;
        const Index i = places_[static_cast<std::size_t>(p)] % width_;
        const Matrix h(h_.data() + tuple * n * n, n, n);
        for (int j = 0; j < width_; ++j) {
          const Index b = node(static_cast<std::size_t>(tuple), j);
          if (b >= a) k.block(a, b) += factor * h.block<3, 3>(3 * i, Index{3} * j);
        }
      }
  });
}

std::vector<double> TupleAssembler::energies(const NodeVectors& r) const {
  std::vector<double> energies(count(), 0.0);
  parallel_blocks(static_cast<Index>(count()), kBlock, [&](Index first, Index size) {
    guarded(origin_, "computing its energy", [&] {
      term_->energy(block(r, r, first, size),
                    {energies.data() + first, static_cast<std::size_t>(size)});
    });
  });
  return energies;
}

}  // namespace deform
