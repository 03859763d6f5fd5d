#include "scalar_system.h"

namespace multigrid {
namespace {

/// The pattern among all nodes; those without an unknown have no entry but their diagonal's.
Pattern pattern_of(const deform::SparseMatrix& a, std::span<const std::int32_t> nodes,
                   Index total) {
  std::vector<std::int32_t> unknown(static_cast<std::size_t>(total), -1);
  for (std::size_t q = 0; q < nodes.size(); ++q)
    unknown[static_cast<std::size_t>(nodes[q])] = static_cast<std::int32_t>(q);
  Pattern pattern;
  pattern.nodes = total;
  for (std::size_t node = 0; node < unknown.size(); ++node) {
    if (const std::int32_t q = unknown[node]; q < 0) {
      pattern.column.push_back(static_cast<std::int32_t>(node));
    } else {
      for (auto p = a.row_begin[static_cast<std::size_t>(q)];
           p < a.row_begin[static_cast<std::size_t>(q) + 1]; ++p)
        pattern.column.push_back(
            nodes[static_cast<std::size_t>(a.column[static_cast<std::size_t>(p)])]);
    }
    pattern.begin.push_back(static_cast<std::int32_t>(pattern.column.size()));
  }
  return pattern;
}

std::vector<Mask> masks_of(std::span<const std::int32_t> nodes, Index total) {
  std::vector<bool> is_free(static_cast<std::size_t>(total), false);
  for (const std::int32_t node : nodes) is_free[static_cast<std::size_t>(node)] = true;
  std::vector<Mask> masks;
  for (std::size_t a = 0; a < is_free.size(); ++a)
    if (!is_free[a]) masks.push_back({static_cast<std::int32_t>(a), {}});
  return masks;
}

}  // namespace

ScalarSystem::ScalarSystem(const deform::SparseMatrix& pattern, std::span<const std::int32_t> nodes,
                           Index total, const std::vector<deform::Prolongation>& coarsening)
    : a_(pattern), node_(nodes.begin(), nodes.end()) {
  cycle_.emplace(pattern_of(pattern, nodes, total), masks_of(nodes, total), coarsening,
                 Finest::smoothed);
  b_.resize(node_.size());
  x_.resize(node_.size());
}

void ScalarSystem::factor(const deform::SparseMatrix& a) {
  a_.value = a.value;
  Level<Scalar>& level = cycle_->finest();
  // Unknowns are numbered as their nodes are, so that rows keep the order of their entries.
  deform::parallel_blocks(a.size, kRows, [&](Index first, Index size) {
    for (auto q = static_cast<std::size_t>(first); q < static_cast<std::size_t>(first + size);
         ++q) {
      float* to = level.value.data() + level.pattern.begin[static_cast<std::size_t>(node_[q])];
      for (auto p = a.row_begin[q]; p < a.row_begin[q + 1]; ++p)
        *to++ = static_cast<float>(a.value[static_cast<std::size_t>(p)]);
    }
  });
  cycle_->renew(true);
}

std::string ScalarSystem::improve(const Eigen::Ref<const Eigen::MatrixXd>& b, double tolerance,
                                  int most, Eigen::Ref<Eigen::MatrixXd> x) {
  iterations_ = 0;
  const double largest = b.size() == 0 ? 0 : b.cwiseAbs().maxCoeff();
  if (largest == 0) {
    x.setZero();
    return "";
  }
  for (std::size_t q = 0; q < b_.size(); ++q)
    for (Index c = 0; c < b.cols(); ++c) {
      b_[q].v[static_cast<std::size_t>(c)] = b(static_cast<Index>(q), c) / largest;
      x_[q].v[static_cast<std::size_t>(c)] = x(static_cast<Index>(q), c) / largest;
    }
  Level<Scalar>& level = cycle_->finest();
  const Ending end = gradients_.solve(
      [&](Index q, const std::vector<Triple>& y) {
        Triple sum;
        for (auto p = static_cast<std::size_t>(a_.row_begin[static_cast<std::size_t>(q)]);
             p < static_cast<std::size_t>(a_.row_begin[static_cast<std::size_t>(q) + 1]); ++p)
          sum += a_.value[p] * y[static_cast<std::size_t>(a_.column[p])];
        return sum;
      },
      [&](const std::vector<Triple>& r, std::vector<Triple>& z) {
        z.resize(r.size());
        deform::parallel_blocks(static_cast<Index>(r.size()), kRows, [&](Index first, Index size) {
          for (auto q = static_cast<std::size_t>(first); q < static_cast<std::size_t>(first + size);
               ++q)
            for (int c = 0; c < 3; ++c)
              level.f[static_cast<std::size_t>(node_[q])].set(
                  c, static_cast<float>(r[q].v[static_cast<std::size_t>(c)]));
        });
        cycle_->run();
        deform::parallel_blocks(static_cast<Index>(r.size()), kRows, [&](Index first, Index size) {
          for (auto q = static_cast<std::size_t>(first); q < static_cast<std::size_t>(first + size);
               ++q)
            for (int c = 0; c < 3; ++c)
              z[q].v[static_cast<std::size_t>(c)] =
                  static_cast<double>(level.x[static_cast<std::size_t>(node_[q])][c]);
        });
      },
      b_, x_, tolerance, most, x.isZero(0) ? From::zero : From::guess);
  iterations_ = end.iterations;
  if (end.is_indefinite) return "not positive definite";
  if (!end.has_converged)
    return std::to_string(end.iterations) + " iterations do not reduce the residual enough";
  for (std::size_t q = 0; q < x_.size(); ++q)
    for (Index c = 0; c < b.cols(); ++c)
      x(static_cast<Index>(q), c) = largest * x_[q].v[static_cast<std::size_t>(c)];
  return "";
}

}  // namespace multigrid
