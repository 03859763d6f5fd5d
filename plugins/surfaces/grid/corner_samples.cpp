#include "corner_samples.h"

namespace grid {
namespace {

using namespace deform;

/// Corner (p, q), each 0 or 1, of cell (i, j).
SampleStencil sample(const Lattice& lattice, Index i, Index j, int p, int q) {
  const std::array<Index, 2> across{i, (i + 1) % lattice.n[0]}, up{j, (j + 1) % lattice.n[1]};
  const auto coefficient = [](int end) { return end == 0 ? -1.0 : 1.0; };
  SampleStencil s;
  s.weight = lattice.h[0] * lattice.h[1] / 4;
  s.parameter =
      lattice.parameter(across[static_cast<std::size_t>(p)], up[static_cast<std::size_t>(q)]);
  for (const int b : {0, 1})
    for (const int a : {0, 1}) {
      const double along_1 = coefficient(a) / lattice.h[0], along_2 = coefficient(b) / lattice.h[1];
      SampleStencil::Entry entry;
      entry.node =
          lattice.node(across[static_cast<std::size_t>(a)], up[static_cast<std::size_t>(b)]);
      const auto put = [&entry](Derivative d, double c) {
        entry.d[static_cast<std::size_t>(slot(d))] = c;
      };
      if (a == p && b == q) put(Derivative::d0, 1.0);
      if (b == q) put(Derivative::d1, along_1);
      if (a == p) put(Derivative::d2, along_2);
      put(Derivative::d12, along_1 * along_2);
      s.entries.push_back(entry);
    }
  for (const Derivative d : {Derivative::d0, Derivative::d1, Derivative::d2, Derivative::d12})
    s.computable.set(static_cast<std::size_t>(slot(d)));
  return s;
}

}  // namespace

SampleSet corner_samples(const Lattice& lattice) {
  SampleSet::Builder builder(lattice.nodes());
  for (Index j = 0; j < lattice.cells(1); ++j)
    for (const int q : {0, 1})
      for (const int p : {0, 1})
        for (Index i = 0; i < lattice.cells(0); ++i) builder.add(sample(lattice, i, j, p, q));
  return builder.build();
}

}  // namespace grid
