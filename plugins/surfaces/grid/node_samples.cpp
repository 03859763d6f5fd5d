#include "node_samples.h"

#include <map>

namespace grid {
namespace {

using namespace deform;

class NodeSamples {
 public:
  NodeSamples(const Lattice& lattice, Scheme scheme, Border border)
      : lattice_(lattice),
        line_1_(make_line(lattice.n[0], lattice.h[0], lattice.periodic[0], scheme, border)),
        line_2_(make_line(lattice.n[1], lattice.h[1], lattice.periodic[1], scheme, border)) {}

  /// The six operators at node (i, j).
  [[nodiscard]] SampleStencil sample(Index i, Index j, double weight) const {
    SampleStencil s;
    s.weight = weight;
    s.parameter = lattice_.parameter(i, j);
    std::map<Index, std::array<double, kDerivatives>> entries;
    const auto put = [&](Derivative d, const Row& row_1, const Row& row_2) {
      for (const auto& [b, c_2] : row_2)
        for (const auto& [a, c_1] : row_1)
          entries[lattice_.node(a, b)][static_cast<std::size_t>(slot(d))] += c_1 * c_2;
      s.computable.set(static_cast<std::size_t>(slot(d)), !row_1.empty() && !row_2.empty());
    };
    const auto k = static_cast<std::size_t>(i), l = static_cast<std::size_t>(j);
    const Row here_1{{i, 1.0}}, here_2{{j, 1.0}};
    put(Derivative::d0, here_1, here_2);
    put(Derivative::d1, line_1_.d[k], here_2);
    put(Derivative::d2, here_1, line_2_.d[l]);
    put(Derivative::d11, line_1_.dd[k], here_2);
    put(Derivative::d12, line_1_.d[k], line_2_.d[l]);
    put(Derivative::d22, here_1, line_2_.dd[l]);
    for (const auto& [at, d] : entries) s.entries.push_back({at, d});
    if (line_1_.d[k].empty() || line_2_.d[l].empty()) s.frame = frame(i, j);
    return s;
  }

  [[nodiscard]] FieldDifferences field_differences() const {
    FieldDifferences::Rows rows;
    for (auto& operator_rows : rows)
      operator_rows.resize(static_cast<std::size_t>(lattice_.nodes()));
    for (Index j = 0; j < lattice_.n[1]; ++j)
      for (Index i = 0; i < lattice_.n[0]; ++i) {
        const auto put = [&](Derivative d, const Row& row_1, const Row& row_2) {
          auto& row = rows[static_cast<std::size_t>(slot(d))]
                          [static_cast<std::size_t>(lattice_.node(i, j))];
          for (const auto& [b, c_2] : row_2)
            for (const auto& [a, c_1] : row_1) row.push_back({lattice_.node(a, b), c_1 * c_2});
        };
        const auto k = static_cast<std::size_t>(i), l = static_cast<std::size_t>(j);
        const Row here_1{{i, 1.0}}, here_2{{j, 1.0}};
        put(Derivative::d1, line_1_.minus[k], here_2);
        put(Derivative::d2, here_1, line_2_.minus[l]);
        put(Derivative::d11, line_1_.dd[k], here_2);
        put(Derivative::d12, line_1_.minus[k], line_2_.minus[l]);
        put(Derivative::d22, here_1, line_2_.dd[l]);
      }
    return FieldDifferences(rows);
  }

 private:
  /// Where r_1 or r_2 does not exist the normal is taken from central (at the border one-sided)
  /// tangents.
  [[nodiscard]] std::vector<SampleStencil::FrameEntry> frame(Index i, Index j) const {
    std::map<Index, std::array<double, 2>> tangents;
    for (const auto& [a, c] : line_1_.frame[static_cast<std::size_t>(i)])
      tangents[lattice_.node(a, j)][0] += c;
    for (const auto& [b, c] : line_2_.frame[static_cast<std::size_t>(j)])
      tangents[lattice_.node(i, b)][1] += c;
    std::vector<SampleStencil::FrameEntry> entries;
    entries.reserve(tangents.size());
    for (const auto& [at, d] : tangents) entries.push_back({at, d});
    return entries;
  }

  const Lattice& lattice_;
  Line line_1_, line_2_;
};

}  // namespace

SampleSet node_samples(const Lattice& lattice, Scheme scheme, Border border,
                       const NodeValues& weights) {
  const NodeSamples make(lattice, scheme, border);
  SampleSet::Builder builder(lattice.nodes());
  for (Index j = 0; j < lattice.n[1]; ++j)
    for (Index i = 0; i < lattice.n[0]; ++i)
      builder.add(make.sample(i, j, weights[lattice.node(i, j)]));
  builder.set_field_differences(make.field_differences());
  return builder.build();
}

}  // namespace grid
