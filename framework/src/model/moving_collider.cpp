#include "model/moving_collider.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "deform/plugin/values.h"

namespace deform {
namespace {

/// x = offset + R X.
struct RigidMotion {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Vec3 offset = Vec3::Zero();

  [[nodiscard]] Vec3 operator()(const Vec3& place) const { return rotation * place + offset; }
  [[nodiscard]] Vec3 back(const Vec3& x) const { return rotation.transpose() * (x - offset); }
};

/// Linear between the times; zero where there are no values.
Vec3 value_at(const std::vector<double>& times, const std::vector<Vec3>& values, double time) {
  if (values.empty()) return Vec3::Zero();
  const auto after = std::ranges::upper_bound(times, time);
  if (after == times.begin()) return values.front();
  if (after == times.end()) return values.back();
  const auto k = static_cast<std::size_t>(after - times.begin());
  const double s = (time - times[k - 1]) / (times[k] - times[k - 1]);
  return (1 - s) * values[k - 1] + s * values[k];
}

RigidMotion motion_at(const RigidPath& path, double time) {
  RigidMotion motion;
  const Vec3 turn = value_at(path.times, path.rotations, time);
  const double angle = turn.norm();
  if (angle > 0) motion.rotation = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
  motion.offset =
      path.pivot + value_at(path.times, path.displacements, time) - motion.rotation * path.pivot;
  return motion;
}

/// Points (size × 3), as a collider's own arrays.
class Points {
 public:
  explicit Points(Index size) : points_(size, 3) {}
  template <class F>
  Points(Index size, ConstVectors from, const F& f) : Points(size) {
    for (Index i = 0; i < size; ++i) points_.row(i) = f(from[i]).transpose();
  }
  [[nodiscard]] ConstVectors view() const { return rows_from(points_, 0); }

 private:
  NodeVectors points_;
};

class MovingCollider final : public Collider {
 public:
  MovingCollider(std::shared_ptr<Collider> body, RigidPath path)
      : body_(std::move(body)), path_(std::move(path)) {}

  [[nodiscard]] bool is_convex() const override { return body_->is_convex(); }
  void measure(double time, ConstVectors points, Values distance, Vectors normal) const override {
    const RigidMotion motion = motion_at(path_, time);
    const auto size = static_cast<Index>(distance.size());
    const Points own(size, points, [&](const Vec3& x) { return motion.back(x); });
    body_->measure(time, own.view(), distance, normal);
    for (Index i = 0; i < size; ++i)
      normal.set(i, motion.rotation * Vec3(normal.x[i], normal.y[i], normal.z[i]));
  }
  [[nodiscard]] bool carry(double from, double to, Index size, ConstVectors points,
                           Vectors carried) const override {
    const RigidMotion before = motion_at(path_, from), after = motion_at(path_, to);
    const bool moves = before.rotation != after.rotation || before.offset != after.offset;
    const Points own(size, points, [&](const Vec3& x) { return before.back(x); });
    const bool moves_itself = body_->carry(from, to, size, own.view(), carried);
    if (!moves && !moves_itself) return false;
    for (Index i = 0; i < size; ++i)
      carried.set(i, after(moves_itself ? Vec3(carried.x[i], carried.y[i], carried.z[i])
                                        : Vec3(own.view()[i])));
    return true;
  }

  void save(Memory& memory) const override { body_->save(memory); }
  void load(const Memory& memory) override { body_->load(memory); }
  [[nodiscard]] double longest_step(double time) const override {
    return body_->longest_step(time);
  }
  [[nodiscard]] double next_break(double after) const override {
    return std::min(body_->next_break(after), first_after(path_.times, after));
  }

 private:
  std::shared_ptr<Collider> body_;
  RigidPath path_;
};

}  // namespace

std::string problem_of(const RigidPath& path) {
  const std::size_t times = path.times.size();
  for (const auto& [name, values] :
       {std::pair{"displacements", &path.displacements}, std::pair{"rotations", &path.rotations}})
    if (!values->empty() && values->size() != times)
      return fmt::format("'times' has {} entries, '{}' {}: they must be as many", times, name,
                         values->size());
  const auto later = std::ranges::adjacent_find(path.times, std::greater_equal<>());
  if (later != path.times.end())
    return fmt::format("'times' must ascend, but {:g} is followed by {:g}", *later,
                       *std::next(later));
  if (times > 0 && path.displacements.empty() && path.rotations.empty())
    return "'times' has neither 'displacements' nor 'rotations' to be the times of";
  return "";
}

std::shared_ptr<Collider> moving(std::shared_ptr<Collider> collider, RigidPath path) {
  return std::make_shared<MovingCollider>(std::move(collider), std::move(path));
}

}  // namespace deform
