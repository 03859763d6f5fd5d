/// How far nodes have moved within the plane in which the surface rests.
#include <deform/geometry/best_fit_plane.h>
#include <deform/record/probe.h>

namespace {

using namespace deform;

class InPlaneDisplacement final : public Probe {
 public:
  InPlaneDisplacement(const NoParameters& /*parameters*/, const Setup& /*setup*/) {}

  void begin(const RunContext& context) override {
    axes_ = best_fit_plane(context.system.rest()).axes;
  }

  [[nodiscard]] std::vector<ProbeColumn> columns() const override {
    return {{"in_plane_displacement", "m"}};
  }

  void measure(const Frame& frame, Values figures) override {
    const NodeVectors displacement = frame.positions() - frame.system.rest();
    figures[0] = (displacement * axes_).cwiseAbs().maxCoeff();
  }

 private:
  Eigen::Matrix<double, 3, 2> axes_ = Eigen::Matrix<double, 3, 2>::Identity();
};

}  // namespace

DEFORM_PLUGIN(InPlaneDisplacement, NoParameters, .name = "in_plane_displacement", .version = "1.0",
              .summary =
                  "Largest absolute component, within the best-fit plane of the rest state, "
                  "of a node's displacement from rest",
              .formula =
                  "max over nodes of max(|u.e_1|, |u.e_2|), u = r - r_rest; for a sheet that "
                  "rests parallel to xy: max(|dx|, |dy|)",
              .source = "")
