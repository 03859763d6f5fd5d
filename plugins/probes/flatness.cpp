/// How far the surface is from being plane.
#include <deform/geometry/best_fit_plane.h>
#include <deform/geometry/characteristic_length.h>
#include <deform/record/probe.h>

namespace {

using namespace deform;

class Flatness final : public Probe {
 public:
  Flatness(const NoParameters& /*parameters*/, const Setup& /*setup*/) {}

  void begin(const RunContext& context) override {
    size_ = characteristic_length(context.system.rest());
  }

  [[nodiscard]] std::vector<ProbeColumn> columns() const override { return {{"flatness", "1"}}; }

  void measure(const Frame& frame, Values figures) override {
    figures[0] = best_fit_plane(frame.positions()).rms_distance / size_;
  }

 private:
  double size_ = 1;  // largest side of the rest state's bounding box [m]
};

}  // namespace

DEFORM_PLUGIN(Flatness, NoParameters, .name = "flatness", .version = "1.0",
              .summary =
                  "Root mean square distance of the nodes to their best-fit plane, over the "
                  "largest side of the rest state's bounding box",
              .formula =
                  "sqrt(mean of ((r - c).m)^2) / size; m: normal of the plane through the "
                  "centroid c",
              .source = "")
