/// The positive semidefinite part of a symmetric matrix.
#pragma once

#include <Eigen/Eigenvalues>

namespace deform {

template <class Matrix>
[[nodiscard]] Matrix positive_part(const Matrix& m) {
  const Eigen::SelfAdjointEigenSolver<Matrix> spectrum(m);
  return spectrum.eigenvectors() * spectrum.eigenvalues().cwiseMax(0).asDiagonal() *
         spectrum.eigenvectors().transpose();
}

}  // namespace deform
