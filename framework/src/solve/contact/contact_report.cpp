#include "deform/solve/contact_report.h"

#include <cmath>
#include <limits>
#include <string>

#include "deform/error.h"

namespace deform {
namespace {

constexpr const char *kFigures = "report/contact", *kNormal = "report/contact.normal",
                     *kFriction = "report/contact.friction";

}  // namespace

void ContactReport::add(const NodeValues& mass, const std::vector<ContactImpulse>& impulses,
                        const NodeVectors& v_begin, const NodeVectors& v_end, double length) {
  time_ += length;
  if (impulses.empty()) return;
  if (!any_) {
    normal_.setZero(mass.size(), 3);
    friction_.setZero(mass.size(), 3);
    any_ = true;
  }
  for (const ContactImpulse& i : impulses) {
    const Vec3 normal = mass[i.node] * i.normal_impulse * i.normal;
    const Vec3 friction = mass[i.node] * i.friction_impulse;
    const Vec3 mean = 0.5 * (v_begin.row(i.node) + v_end.row(i.node)).transpose();
    normal_.row(i.node) += normal.transpose();
    friction_.row(i.node) += friction.transpose();
    normal_work_ += normal.dot(mean);
    friction_work_ += friction.dot(mean);
  }
}

void ContactReport::clear() {
  time_ = normal_work_ = friction_work_ = 0;
  any_ = false;
}

NodeVectors ContactReport::mean(const NodeVectors& impulse, Index nodes) const {
  if (!(time_ > 0))
    return NodeVectors::Constant(nodes, 3, std::numeric_limits<double>::quiet_NaN());
  if (!any_) return NodeVectors::Zero(nodes, 3);
  return impulse.topRows(nodes) / time_;
}

void ContactReport::save(Memory& memory) const {
  memory.put(kFigures, {time_, normal_work_, friction_work_});
  const auto put = [&](const char* name, const NodeVectors& v) {
    if (any_) memory.put(name, {v.data(), v.data() + v.size()});
  };
  put(kNormal, normal_);
  put(kFriction, friction_);
}

void ContactReport::load(const Memory& memory, Index rows) {
  const std::vector<double>& figures = memory.get(kFigures, 3);
  const auto get = [&](const char* name, NodeVectors& v) {
    const std::vector<double>& numbers = memory.get(name, static_cast<std::size_t>(3 * rows));
    v = Eigen::Map<const NodeVectors>(numbers.data(), rows, 3);
    if (!v.allFinite()) throw InputError(std::string("\"") + name + "\" is not finite");
  };
  any_ = memory.entries().contains(kNormal);
  if (any_) {
    get(kNormal, normal_);
    get(kFriction, friction_);
  }
  time_ = figures[0], normal_work_ = figures[1], friction_work_ = figures[2];
  if (!std::isfinite(time_ + normal_work_ + friction_work_) || time_ < 0)
    throw InputError(std::string("\"") + kFigures + "\" has numbers that are not finite");
}

}  // namespace deform
