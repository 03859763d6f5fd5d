/// What colliders push and rub a surface with.
#include <algorithm>
#include <array>

#include <deform/record/probe.h>

namespace {
using namespace deform;

class ContactForce final : public Probe {
 public:
  ContactForce(const NoParameters& /*parameters*/, const Setup& /*setup*/) {}

  [[nodiscard]] std::vector<ProbeColumn> columns() const override {
    return {{"contact_force.x", "N"},        {"contact_force.y", "N"},
            {"contact_force.z", "N"},        {"contact_force.normal", "N"},
            {"contact_force.friction", "N"}, {"contact_force.largest_pressure", "Pa"}};
  }

  void measure(const Frame& frame, Values figures) override {
    std::ranges::fill(figures, kNoFigure);
    const ContactReport& contact = frame.system.step_report().contact;
    if (frame.system.contact().bodies() == 0 || !(contact.time() > 0)) return;
    const Index nodes = frame.system.nodes();
    const NodeVectors normal = contact.normal_force(nodes),
                      friction = contact.friction_force(nodes);
    const Vec3 sum = (normal + friction).colwise().sum().transpose();
    const NodeValues sizes = normal.rowwise().norm();
    const std::array all{sum.x(),
                         sum.y(),
                         sum.z(),
                         sizes.sum(),
                         friction.rowwise().norm().sum(),
                         sizes.cwiseQuotient(frame.system.areas()).maxCoeff()};
    std::ranges::copy(all, figures.begin());
  }
};

}  // namespace

DEFORM_PLUGIN(ContactForce, NoParameters, .name = "contact_force", .version = "1.0",
              .summary =
                  "forces of colliders on the surface, mean values of the last step: their sum, "
                  "the sums of the sizes of nodes' normal forces and of friction, and the largest "
                  "normal force by area; empty without colliders, and where error control ended no "
                  "step of its own in the scene's",
              .formula = "(M (v⁺ − v) − impulse of all other forces)/dt")
