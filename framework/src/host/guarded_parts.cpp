#include "host/guarded_parts.h"

#include <optional>
#include <utility>

#include "deform/error.h"

#include "plugin/guard.h"

namespace deform {

GuardedShape::GuardedShape(std::string origin, std::shared_ptr<const Shape> shape)
    : origin_(std::move(origin)), shape_(std::move(shape)) {}

NodeVectors GuardedShape::positions(const Eigen::MatrixX2d& parameters, const Vec2& size) const {
  std::optional<InputError> rejected;
  NodeVectors r = guarded(origin_, "giving positions", [&]() -> NodeVectors {
    try {
      return shape_->positions(parameters, size);
    } catch (const InputError& error) {
      rejected.emplace(error.problems());
      return {};
    }
  });
  if (rejected) throw InputError(rejected->problems());
  if (r.rows() != parameters.rows()) {
    throw PluginFailure("plugin " + origin_ + " gave " + std::to_string(r.rows()) +
                        " positions, expected " + std::to_string(parameters.rows()) +
                        ", one for each node");
  }
  for (Index a = 0; a < r.rows(); ++a) {
    if (r.row(a).allFinite()) continue;
    throw PluginFailure("plugin " + origin_ + " gave node " + std::to_string(a) +
                        " a position that is not finite");
  }
  return r;
}

GuardedNormal::GuardedNormal(std::string origin, std::shared_ptr<NormalEstimator> normal)
    : origin_(std::move(origin)),
      normal_(std::move(normal)),
      dependence_(guarded(origin_, "saying what it depends on",
                          [this] { return normal_->dependence(); })) {}

void GuardedNormal::estimate(const GeometryBlock& lagged, Pair ij, AffineNormal& normal) const {
  guarded(origin_, "estimating the normal", [&] { normal_->estimate(lagged, ij, normal); });
}

std::vector<std::string> GuardedNormal::branches() const {
  return guarded(origin_, "naming its branches", [&] { return normal_->branches(); });
}

void GuardedNormal::branch(const GeometryBlock& lagged, Pair ij,
                           std::span<std::uint8_t> out) const {
  guarded(origin_, "saying which branch it takes", [&] { normal_->branch(lagged, ij, out); });
}

void GuardedNormal::save(Memory& memory) const {
  guarded(origin_, "saving its memory", [&] { normal_->save(memory); });
}

void GuardedNormal::load(const Memory& memory) {
  guarded(origin_, "loading its memory", [&] { normal_->load(memory); });
}

}  // namespace deform
