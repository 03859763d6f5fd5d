/// Basic types that every public header shares.
#pragma once

#include <cstdint>
#include <span>

#include <Eigen/Core>
#include <Eigen/Geometry>  // cross products

namespace deform {

using Index = Eigen::Index;
using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;

/// (N × 3) one vector a node, column-major: all x, then all y, then all z.
using NodeVectors = Eigen::Matrix<double, Eigen::Dynamic, 3>;
/// (N) one number a node.
using NodeValues = Eigen::VectorXd;

/// Consecutive numbers that belong to a block (of samples or nodes); index 0 is the block's first.
using Values = std::span<double>;
using ConstValues = std::span<const double>;

/// Samples and nodes are handed to plugins in blocks of at most this many.
inline constexpr Index kBlock = 128;

/// Vectors of a block as three separate component arrays (structure of arrays); a view, owns
/// nothing.
template <class T>
struct VectorArray {
  T* x = nullptr;
  T* y = nullptr;
  T* z = nullptr;

  [[nodiscard]] Vec3 operator[](Index i) const { return {x[i], y[i], z[i]}; }
  [[nodiscard]] VectorArray from(Index first) const { return {x + first, y + first, z + first}; }
  [[nodiscard]] explicit operator bool() const { return x != nullptr; }

  void set(Index i, const Vec3& value) const requires(!std::is_const_v<T>) {
    x[i] = value.x(), y[i] = value.y(), z[i] = value.z();
  }
  void add(Index i, const Vec3& value) const requires(!std::is_const_v<T>) {
    x[i] += value.x(), y[i] += value.y(), z[i] += value.z();
  }
};

using Vectors = VectorArray<double>;
using ConstVectors = VectorArray<const double>;

/// View of the rows first, first+1, … of an (N × 3) array.
[[nodiscard]] inline ConstVectors rows_from(const NodeVectors& v, Index first) {
  return {v.col(0).data() + first, v.col(1).data() + first, v.col(2).data() + first};
}
[[nodiscard]] inline Vectors rows_from(NodeVectors& v, Index first) {
  return {v.col(0).data() + first, v.col(1).data() + first, v.col(2).data() + first};
}

}  // namespace deform
