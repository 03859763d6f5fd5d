/// Tangents of terms that give none: central differences of their stress or force.
#include <array>
#include <vector>

#include "deform/model/energy_term.h"

#include "model/moved_block.h"
#include "model/semidefinite.h"

namespace deform {
namespace {

using JetMatrix = Eigen::Matrix<double, kJetComponents, kJetComponents>;

/// The stress of a term on jets, whichever way it gives it.
class StressOf {
 public:
  StressOf(const JetTerm& term, Index size)
      : term_(term),
        size_(size),
        is_affine_(term.traits().lagged != Lagged::none),
        numbers_(static_cast<std::size_t>(3 * kChannels * size)) {
    for (std::size_t m = 0; m < channels_.size(); ++m) {
      double* const x = numbers_.data() + 3 * static_cast<Index>(m) * size;
      channels_[m] = {x, x + size, x + 2 * size};
    }
    if (!is_affine_) return;
    couplings_ = term.couplings();
    k_.resize(couplings_.size() * static_cast<std::size_t>(size));
    for (std::size_t c = 0; c < couplings_.size(); ++c)
      table_[static_cast<std::size_t>(slot(couplings_[c].first))]
            [static_cast<std::size_t>(slot(couplings_[c].second))] = k_of(c);
  }

  /// σ at block.now, lagged there too.
  void compute(SampleBlock block) {
    std::ranges::fill(numbers_, 0.0);
    if (!is_affine_) return term_.stress(block, Stress{channels_});
    std::ranges::fill(k_, 0.0);
    block.lagged = block.now;
    term_.affine_stress(block, AffineStress(table_, channels_, size_));
    for (std::size_t c = 0; c < couplings_.size(); ++c) {
      const ConstVectors r = block.now.r(couplings_[c].second);
      const Vectors& sigma = channels_[static_cast<std::size_t>(slot(couplings_[c].first))];
      for (Index s = 0; s < size_; ++s) sigma.add(s, k_of(c)[s] * r[s]);
    }
  }
  /// (15) σ_1, σ_2, σ_11, σ_12, σ_22 of a sample.
  [[nodiscard]] Eigen::Matrix<double, kJetComponents, 1> at(Index s) const {
    Eigen::Matrix<double, kJetComponents, 1> all;
    for (int m = 0; m < kJet; ++m)
      all.segment<3>(3 * m) = channels_[static_cast<std::size_t>(m + 1)][s];
    return all;
  }

 private:
  [[nodiscard]] double* k_of(std::size_t c) { return k_.data() + static_cast<Index>(c) * size_; }

  const JetTerm& term_;
  Index size_;
  bool is_affine_;
  std::vector<double> numbers_, k_;
  std::vector<Coupling> couplings_;
  AffineStress::ConstantTable channels_;
  AffineStress::CouplingTable table_{};
};

}  // namespace

void JetTerm::tangent(const SampleBlock& block, Tangent kind, const JetTangent& h) const {
  const Index size = block.size();
  std::vector<JetMatrix> hessian(static_cast<std::size_t>(size), JetMatrix::Zero());
  MovedBlock moved(block.now);
  SampleBlock there = block;
  StressOf stress(*this, size);
  for (std::size_t k = 0; k < kJetComponents; ++k) {
    const auto column = static_cast<Index>(k);
    for (const double side : {1.0, -1.0}) {
      moved.move(k / 3, static_cast<int>(k % 3), side * kRelativeStep);
      there.now = moved.view();
      stress.compute(there);
      for (Index s = 0; s < size; ++s)
        hessian[static_cast<std::size_t>(s)].col(column) +=
            side / (2 * kRelativeStep * moved.scale(k / 3, s)) * stress.at(s);
    }
  }
  for (Index s = 0; s < size; ++s) {
    JetMatrix& m = hessian[static_cast<std::size_t>(s)];
    m = (0.5 * (m + m.transpose())).eval();
    if (is_semidefinite(kind)) m = positive_part(m);
    for (int i = 0; i < kJet; ++i)
      for (int j = i; j < kJet; ++j)
        h.add(s, static_cast<Derivative>(i + 1), static_cast<Derivative>(j + 1),
              m.block<3, 3>(3 * i, 3 * j));
  }
}

void TupleTerm::tangent(const TupleBlock& block, Tangent kind, Values h) const {
  const int w = width();
  const Index n = 3 * w;
  std::vector<double> k(static_cast<std::size_t>(w * w));
  std::vector<Vec3> c(static_cast<std::size_t>(w));
  const auto force = [&](const TupleBlock& one) {
    std::ranges::fill(k, 0.0);
    std::ranges::fill(c, Vec3::Zero());
    affine_force(one, k, c);
    Eigen::VectorXd f(n);
    for (int a = 0; a < w; ++a) {
      Vec3 sum = -c[static_cast<std::size_t>(a)];
      for (int b = 0; b < w; ++b) sum -= k[static_cast<std::size_t>(a * w + b)] * one.r(0, b);
      f.segment<3>(Index{3} * a) = sum;
    }
    return f;
  };
  NodeVectors moved = *block.now;
  for (Index t = 0; t < block.size; ++t) {
    const TupleBlock one{.first = block.first + t,
                         .size = 1,
                         .width = w,
                         .nodes = block.nodes + t * w,
                         .now = &moved,
                         .lagged = &moved};
    double scale = 0;
    for (int a = 1; a < w; ++a) scale = std::max(scale, (one.r(0, a) - one.r(0, 0)).norm());
    const double step = kRelativeStep * (scale > 0 ? scale : 1.0);
    Eigen::MatrixXd m(n, n);
    for (Index j = 0; j < n; ++j) {
      double& x = moved(one.node(0, static_cast<int>(j / 3)), j % 3);
      const double known = x;
      x = known + step;
      const Eigen::VectorXd above = force(one);
      x = known - step;
      m.col(j) = (force(one) - above) / (2 * step);
      x = known;
    }
    m = (0.5 * (m + m.transpose())).eval();
    if (is_semidefinite(kind)) m = positive_part(m);
    for (Index i = 0; i < n; ++i)
      for (Index j = 0; j < n; ++j) h[static_cast<std::size_t>((t * n + i) * n + j)] += m(i, j);
  }
}

}  // namespace deform
