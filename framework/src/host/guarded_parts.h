/// Plugins that other plugins use directly: an energy term asks its normal estimator, a surface its
/// shapes. These stand between the two, so that who is asked is checked, and blamed by its name.
#pragma once

#include <memory>
#include <string>

#include "deform/model/normal_estimator.h"
#include "deform/surface/shape.h"

namespace deform {

/// Lets InputError pass; checks that the positions are finite, and as many as were asked for.
class GuardedShape final : public Shape {
 public:
  GuardedShape(std::string origin, std::shared_ptr<const Shape> shape);
  [[nodiscard]] NodeVectors positions(const Eigen::MatrixX2d& parameters,
                                      const Vec2& size) const override;

 private:
  std::string origin_;
  std::shared_ptr<const Shape> shape_;
};

class GuardedNormal final : public NormalEstimator {
 public:
  GuardedNormal(std::string origin, std::shared_ptr<NormalEstimator> normal);
  void estimate(const GeometryBlock& lagged, Pair ij, AffineNormal& normal) const override;
  [[nodiscard]] Dependence dependence() const override { return dependence_; }
  [[nodiscard]] std::vector<std::string> branches() const override;
  void branch(const GeometryBlock& lagged, Pair ij, std::span<std::uint8_t> out) const override;
  void save(Memory& memory) const override;
  void load(const Memory& memory) override;

  [[nodiscard]] const std::string& origin() const { return origin_; }

 private:
  std::string origin_;
  std::shared_ptr<NormalEstimator> normal_;
  Dependence dependence_;  // a promise: the same for the object's life
};

}  // namespace deform
