#include "deform/surface/sample_set.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <utility>

#include "deform/error.h"

namespace deform {

FieldDifferences::FieldDifferences(const Rows& rows) {
  for (std::size_t d = 0; d < rows.size(); ++d) {
    Operator& op = operators_[d];
    op.begin.push_back(0);
    for (const std::vector<Term>& row : rows[d]) {
      op.terms.insert(op.terms.end(), row.begin(), row.end());
      op.begin.push_back(static_cast<Index>(op.terms.size()));
    }
  }
}

std::span<const FieldDifferences::Term> FieldDifferences::row(Derivative op, Index s) const {
  const Operator& o = operators_[static_cast<std::size_t>(slot(op))];
  const auto begin = static_cast<std::size_t>(o.begin[static_cast<std::size_t>(s)]);
  const auto end = static_cast<std::size_t>(o.begin[static_cast<std::size_t>(s) + 1]);
  return {o.terms.data() + begin, end - begin};
}

bool FieldDifferences::fits(Index m) const {
  const auto fits = [m](const Operator& op) {
    return static_cast<Index>(op.begin.size()) == m + 1 &&
           std::ranges::all_of(op.terms,
                               [m](const Term& t) { return t.sample >= 0 && t.sample < m; });
  };
  return std::all_of(operators_.begin() + slot(Derivative::d1), operators_.end(), fits);
}

void FieldDifferences::apply(Derivative op, ConstValues field, Index first, Values out) const {
  for (std::size_t i = 0; i < out.size(); ++i) {
    double sum = 0;
    for (const Term& t : row(op, first + static_cast<Index>(i)))
      sum += t.coefficient * field[static_cast<std::size_t>(t.sample)];
    out[i] = sum;
  }
}

NodeVectors SampleSet::apply(Derivative d, const NodeVectors& v) const {
  NodeVectors result = NodeVectors::Zero(size(), 3);
  for (Index s = 0; s < size(); ++s) {
    const Stencil at = stencil(s);
    for (std::size_t k = 0; k < at.nodes.size(); ++k)
      result.row(s) += at.d[k][static_cast<std::size_t>(slot(d))] * v.row(at.nodes[k]);
  }
  return result;
}

/// Coefficients are shared when all their bits agree, which on a regular grid leaves one set an
/// interior and a few a border: they stay in cache whatever the number of samples.
struct SampleSet::Builder::Impl {
  using Coefficients = std::vector<std::array<double, kDerivatives>>;
  SampleSet set;
  std::map<Coefficients, std::size_t> shared;

  [[nodiscard]] bool goes_on(Index s) const {
    const auto i = static_cast<std::size_t>(s);
    const Stencil at = set.stencil(s), next = set.stencil(s + 1);
    return set.pool_begin_[i] == set.pool_begin_[i + 1] &&
           std::ranges::equal(at.nodes, next.nodes, {}, [](std::int32_t a) { return a + 1; });
  }
  void find_runs() {
    set.run_end_.resize(static_cast<std::size_t>(set.size()));
    for (Index s = set.size() - 1; s >= 0; --s) {
      const bool is_last = s + 1 == set.size() || !goes_on(s);
      set.run_end_[static_cast<std::size_t>(s)] =
          is_last ? static_cast<std::int32_t>(s + 1)
                  : set.run_end_[static_cast<std::size_t>(s) + 1];
    }
  }
};

SampleSet::Builder::Builder(Index nodes) : impl_(std::make_unique<Impl>()) {
  impl_->set.nodes_ = nodes;
}
SampleSet::Builder::~Builder() = default;

void SampleSet::Builder::add(const SampleStencil& sample) {
  SampleSet& set = impl_->set;
  Impl::Coefficients coefficients;
  const auto check = [&set](const char* what, Index node) {
    if (node >= 0 && node < set.nodes_) return;
    throw Error(ExitCode::plugin_failed, std::string("the ") + what + " of sample " +
                                             std::to_string(set.size()) + " names node " +
                                             std::to_string(node) + ", expected 0 to " +
                                             std::to_string(set.nodes_ - 1));
  };
  for (const SampleStencil::FrameEntry& entry : sample.frame) check("frame", entry.node);
  for (const SampleStencil::Entry& entry : sample.entries) {
    check("stencil", entry.node);
    set.nodes_of_.push_back(static_cast<std::int32_t>(entry.node));
    coefficients.push_back(entry.d);
  }
  const auto [place, is_new] = impl_->shared.try_emplace(std::move(coefficients), set.pool_.size());
  if (is_new) set.pool_.insert(set.pool_.end(), place->first.begin(), place->first.end());
  set.pool_begin_.push_back(place->second);
  set.begin_.push_back(static_cast<Index>(set.nodes_of_.size()));
  if (!sample.frame.empty()) set.frames_.push_back({set.size(), sample.frame});
  set.weights_.push_back(sample.weight);
  set.parameters_.push_back(sample.parameter);
  set.computable_.push_back(sample.computable);
}

void SampleSet::Builder::set_field_differences(FieldDifferences differences) {
  impl_->set.field_differences_ = std::move(differences);
}

SampleSet SampleSet::Builder::build() {
  SampleSet& set = impl_->set;
  // D_0 is the identity when each sample's place is its own node's.
  set.samples_are_nodes_ = set.size() == set.nodes_;
  for (Index s = 0; set.samples_are_nodes_ && s < set.size(); ++s) {
    const Stencil at = set.stencil(s);
    for (std::size_t k = 0; k < at.nodes.size(); ++k) {
      const double expected = at.nodes[k] == s ? 1.0 : 0.0;
      if (at.d[k][0] != expected) set.samples_are_nodes_ = false;
    }
  }
  if (set.field_differences_ && !set.samples_are_nodes_)
    throw Error(ExitCode::plugin_failed,
                "a set whose samples are not the nodes cannot difference fields");
  if (set.field_differences_ && !set.field_differences_->fits(set.size()))
    throw Error(ExitCode::plugin_failed, "the differences of fields need a row for each of the " +
                                             std::to_string(set.size()) +
                                             " samples, and no other sample in any row");
  impl_->find_runs();
  return std::move(set);
}

}  // namespace deform
