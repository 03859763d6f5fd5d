#include "solve/matrix/rigid_modes.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>

namespace deform {
namespace {

/// What moves by less than this part of the largest motion is held.
constexpr double kHeld = 1e-9;

double size_about(const Vec3& centre, const NodeVectors& r) {
  return std::max((r.rowwise() - centre.transpose()).cwiseAbs().maxCoeff(), 1e-300);
}

/// (3N × 6) displacements, node by node: along and around x, y, z about the centre, of unit size.
Eigen::MatrixXd rigid_motions(const NodeVectors& r) {
  const Vec3 centre = r.colwise().mean();
  const double size = size_about(centre, r);
  Eigen::MatrixXd motions(3 * r.rows(), 6);
  for (Index a = 0; a < r.rows(); ++a)
    for (int k = 0; k < 3; ++k) {
      const Vec3 axis = Vec3::Unit(k);
      motions.block<3, 1>(3 * a, k) = axis;
      motions.block<3, 1>(3 * a, 3 + k) = axis.cross(Vec3(r.row(a).transpose() - centre)) / size;
    }
  return motions;
}

/// (N × 3) of one motion (3N).
NodeVectors by_nodes(const Eigen::VectorXd& motion) {
  return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>>(
      motion.data(), motion.size() / 3, 3);
}

/// (rows × 6) of the motions: what a motion must leave at 0 to be allowed. Prescribed components
/// stay; tied ones follow.
Eigen::MatrixXd violations(const ReductionMap& map, const Eigen::MatrixXd& motions) {
  std::vector<Eigen::RowVectorXd> rows;
  const Reduction& reduction = map.reduction();
  for (Index a = 0; a < motions.rows() / 3; ++a)
    for (int c = 0; c < 3; ++c)
      if (reduction.prescribed(a, c)) rows.emplace_back(motions.row(3 * a + c));
  for (const Tie& tie : map.ties()) {
    Eigen::RowVectorXd row = motions.row(3 * tie.freedom.node + tie.freedom.component);
    for (const Tie::Part& part : tie.parts)
      row -= part.coefficient * motions.row(3 * part.of.node + part.of.component);
    rows.push_back(row);
  }
  Eigen::MatrixXd all =
      Eigen::MatrixXd::Zero(std::max<Index>(6, static_cast<Index>(rows.size())), 6);
  for (std::size_t i = 0; i < rows.size(); ++i) all.row(static_cast<Index>(i)) = rows[i];
  return all;
}

/// (6 × k) basis of the motions that the constraints allow.
Eigen::MatrixXd allowed_motions(const ReductionMap& map, const Eigen::MatrixXd& motions) {
  const Eigen::MatrixXd forbidden = violations(map, motions);
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(forbidden.transpose() * forbidden,
                                              Eigen::ComputeFullV);
  const double largest = std::max(svd.singularValues()[0], 1.0);
  Index held = 0;
  while (held < 6 && svd.singularValues()[held] > kHeld * largest) ++held;
  return svd.matrixV().rightCols(6 - held);
}

/// Those of them along which the force fields' potential does not change.
Eigen::MatrixXd not_resisted(const Eigen::MatrixXd& allowed, const RigidStiffness& forces) {
  if (allowed.cols() == 0) return allowed;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(allowed.transpose() * forces.second *
                                                             allowed);
  std::vector<Index> free;
  for (Index k = 0; k < allowed.cols(); ++k)
    if (!(std::abs(eigen.eigenvalues()[k]) > forces.least)) free.push_back(k);
  return allowed * eigen.eigenvectors()(Eigen::all, free);
}

}  // namespace

RigidStiffness rigid_stiffness(const BlockMatrix& k, const NodeVectors& f, const NodeVectors& r) {
  const Eigen::MatrixXd motions = rigid_motions(r);
  const Vec3 centre = r.colwise().mean();
  const double size = size_about(centre, r);
  RigidStiffness result;
  NodeVectors resistance;
  for (Index i = 0; i < 6; ++i) {
    NodeVectors moved = NodeVectors::Zero(k.nodes, 3);
    moved.topRows(r.rows()) = by_nodes(motions.col(i));
    k.multiply(moved, resistance);
    for (Index j = 0; j < 6; ++j)
      result.second(j, i) =
          resistance.topRows(r.rows()).cwiseProduct(by_nodes(motions.col(j))).sum();
  }
  double of_forces = 0;
  for (Index a = 0; a < r.rows(); ++a) {
    const Vec3 x = r.row(a).transpose() - centre, force = f.row(a).transpose();
    of_forces += force.norm() * x.norm() / (size * size);
    // −f · (eᵢ × (eⱼ × x)), made symmetric.
    const Eigen::Matrix3d outer = x * force.transpose();
    result.second.bottomRightCorner<3, 3>() +=
        (Eigen::Matrix3d::Identity() * force.dot(x) - 0.5 * (outer + outer.transpose())) /
        (size * size);
  }
  result.second = 0.5 * (result.second + result.second.transpose()).eval();
  double of_stiffness = 0;
  for (const double entry : k.value) of_stiffness += std::abs(entry);
  result.least = kHeld * (of_stiffness + of_forces);
  return result;
}

std::vector<Freedom> components_to_hold(const ReductionMap& map, const NodeVectors& r,
                                        const RigidStiffness& forces) {
  const Eigen::MatrixXd motions = rigid_motions(r);
  const Eigen::MatrixXd free = not_resisted(allowed_motions(map, motions), forces);
  const Index count = free.cols();
  if (count == 0) return {};
  const Eigen::MatrixXd free_motions = motions * free;

  // The free components at which these motions are most independent: pivots of a QR factorisation.
  std::vector<Freedom> candidates;
  for (Index a = 0; a < r.rows(); ++a)
    for (int c = 0; c < 3; ++c)
      if (map.reduction().free(a, c)) candidates.push_back({a, c});
  Eigen::MatrixXd at(count, static_cast<Index>(candidates.size()));
  for (std::size_t i = 0; i < candidates.size(); ++i)
    at.col(static_cast<Index>(i)) =
        free_motions.row(3 * candidates[i].node + candidates[i].component).transpose();
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(at);
  std::vector<Freedom> chosen;
  for (Index k = 0; k < qr.rank(); ++k)
    chosen.push_back(candidates[static_cast<std::size_t>(qr.colsPermutation().indices()[k])]);
  return chosen;
}

}  // namespace deform
