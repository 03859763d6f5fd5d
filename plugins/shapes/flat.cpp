#include <deform/surface/shape.h>

namespace {
using namespace deform;

struct Parameters {
  Vec3 origin = Vec3::Zero();
  static void declare(Declaration<Parameters>& d) {
    d("origin", &Parameters::origin, "m", "where a1 = a2 = 0 is");
  }
};

class Flat final : public Shape {
 public:
  Flat(const Parameters& p, const Setup& /*setup*/) : origin_(p.origin) {}

  [[nodiscard]] NodeVectors positions(const Eigen::MatrixX2d& parameters,
                                      const Vec2& /*size*/) const override {
    NodeVectors r(parameters.rows(), 3);
    r << parameters, NodeValues::Zero(parameters.rows());
    r.rowwise() += origin_.transpose();
    return r;
  }

 private:
  Vec3 origin_;
};

}  // namespace

DEFORM_PLUGIN(Flat, Parameters, .name = "flat", .version = "1.0",
              .summary = "flat, in the plane of x and y", .formula = "r = origin + (a1, a2, 0)",
              .source = "")
