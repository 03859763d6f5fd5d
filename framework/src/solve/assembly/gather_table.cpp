#include "solve/assembly/gather_table.h"

#include <algorithm>
#include <map>

namespace deform {
namespace {

using NodeRow = std::map<std::int32_t, GatherTable::Coefficients>;  // by sample

void add_transposes(const SampleSet& samples, std::vector<NodeRow>& rows) {
  for (Index s = 0; s < samples.size(); ++s) {
    const SampleSet::Stencil at = samples.stencil(s);
    const double weight = samples.weights()[static_cast<std::size_t>(s)];
    for (std::size_t k = 0; k < at.nodes.size(); ++k) {
      auto& l = rows[static_cast<std::size_t>(at.nodes[k])][static_cast<std::int32_t>(s)];
      for (std::size_t m = 0; m < kDerivatives; ++m) l[m] = at.d[k][m] * weight;
    }
  }
}

void add_strong_form(const SampleSet& samples, std::vector<NodeRow>& rows) {
  const FieldDifferences* differences = samples.field_differences();
  if (differences == nullptr) return;
  for (Index a = 0; a < samples.size(); ++a) {
    const double area = samples.weights()[static_cast<std::size_t>(a)];
    const auto add = [&](Derivative d, Channel m) {
      for (const FieldDifferences::Term& t : differences->row(d, a))
        rows[static_cast<std::size_t>(a)][static_cast<std::int32_t>(t.sample)]
            [static_cast<std::size_t>(slot(m))] = -area * t.coefficient;
    };
    add(Derivative::d1, Channel::minus1);
    add(Derivative::d2, Channel::minus2);
  }
}

}  // namespace

GatherTable::GatherTable(const SampleSet& samples) {
  std::vector<NodeRow> rows(static_cast<std::size_t>(samples.nodes()));
  add_transposes(samples, rows);
  add_strong_form(samples, rows);
  std::map<std::vector<Coefficients>, std::size_t> shared;
  for (const NodeRow& row : rows) {
    std::vector<Coefficients> coefficients;
    for (const auto& [sample, l] : row) {
      samples_.push_back(sample);
      coefficients.push_back(l);
    }
    begin_.push_back(static_cast<Index>(samples_.size()));
    const auto [place, is_new] = shared.try_emplace(std::move(coefficients), pool_.size());
    if (is_new) pool_.insert(pool_.end(), place->first.begin(), place->first.end());
    pool_begin_.push_back(place->second);
  }
  find_runs();
}

bool GatherTable::goes_on(Index a) const {
  const auto i = static_cast<std::size_t>(a);
  return pool_begin_[i] == pool_begin_[i + 1] &&
         std::ranges::equal(row(a).samples, row(a + 1).samples, {},
                            [](std::int32_t s) { return s + 1; });
}

void GatherTable::find_runs() {
  run_end_.resize(static_cast<std::size_t>(nodes()));
  for (Index a = nodes() - 1; a >= 0; --a) {
    const auto i = static_cast<std::size_t>(a);
    run_end_[i] =
        a + 1 == nodes() || !goes_on(a) ? static_cast<std::int32_t>(a + 1) : run_end_[i + 1];
  }
}

}  // namespace deform
