#include "deform/solve/block_matrix.h"

namespace deform {

void BlockMatrix::multiply(const NodeVectors& x, NodeVectors& y) const {
  y.setZero(nodes, 3);
  for (Index a = 0; a < nodes; ++a)
    for (std::int32_t p = row_begin[static_cast<std::size_t>(a)];
         p < row_begin[static_cast<std::size_t>(a) + 1]; ++p) {
      const Index b = column[static_cast<std::size_t>(p)];
      const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> block(
          value.data() + 9 * static_cast<std::size_t>(p));
      y.row(a) += (block * x.row(b).transpose()).transpose();
      if (b != a) y.row(b) += (block.transpose() * x.row(a).transpose()).transpose();
    }
}

}  // namespace deform
