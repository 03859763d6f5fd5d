#include "lattice.h"

namespace grid {

Eigen::MatrixX2d parameters(const Lattice& lattice) {
  Eigen::MatrixX2d result(lattice.nodes(), 2);
  for (Index j = 0; j < lattice.n[1]; ++j)
    for (Index i = 0; i < lattice.n[0]; ++i)
      result.row(lattice.node(i, j)) = lattice.parameter(i, j);
  return result;
}

deform::NodeValues areas(const Lattice& lattice, Weights weights) {
  deform::NodeValues result(lattice.nodes());
  result.setConstant(lattice.h[0] * lattice.h[1]);
  if (weights == Weights::equal) return result;
  for (Index j = 0; j < lattice.n[1]; ++j)
    for (Index i = 0; i < lattice.n[0]; ++i)
      result[lattice.node(i, j)] *= lattice.share(0, i) * lattice.share(1, j);
  return result;
}

deform::Faces faces(const Lattice& lattice) {
  deform::Faces result;
  for (Index j = 0; j < lattice.cells(1); ++j)
    for (Index i = 0; i < lattice.cells(0); ++i) {
      const Index right = (i + 1) % lattice.n[0], above = (j + 1) % lattice.n[1];
      for (const Index corner : {lattice.node(i, j), lattice.node(right, j),
                                 lattice.node(right, above), lattice.node(i, above)})
        result.nodes.push_back(static_cast<std::int32_t>(corner));
      result.begin.push_back(static_cast<std::int32_t>(result.nodes.size()));
    }
  return result;
}

std::vector<Index> side(const Lattice& lattice, const std::string& name) {
  std::vector<Index> result;
  for (Index j = 0; j < lattice.n[1]; ++j)
    for (Index i = 0; i < lattice.n[0]; ++i) {
      const bool on_1 = !lattice.periodic[0] &&
                        ((name == "left" && i == 0) || (name == "right" && i == lattice.n[0] - 1));
      const bool on_2 = !lattice.periodic[1] &&
                        ((name == "bottom" && j == 0) || (name == "top" && j == lattice.n[1] - 1));
      if (on_1 || on_2) result.push_back(lattice.node(i, j));
    }
  return result;
}

}  // namespace grid
