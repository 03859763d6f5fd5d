/// How deep a surface is inside of the scene's colliders.
#include <algorithm>
#include <cmath>
#include <vector>

#include <deform/geometry/characteristic_length.h>
#include <deform/record/probe.h>

namespace {
using namespace deform;

class Contact final : public Probe {
 public:
  Contact(const NoParameters& /*parameters*/, const Setup& /*setup*/) {}

  [[nodiscard]] std::vector<ProbeColumn> columns() const override {
    return {{"contact.nodes", ""}, {"contact.node_depth", "m"}, {"contact.face_depth", "m"}};
  }

  void measure(const Frame& frame, Values figures) override {
    std::ranges::fill(figures, kNoFigure);
    const NodeValues at_nodes =
        frame.system.contact().clearance(frame.state.time, frame.positions());
    if (!std::isfinite(at_nodes.minCoeff())) return;  // there is no collider
    const NodeValues at_faces =
        frame.system.contact().clearance(frame.state.time, face_centres(frame));
    const double size = characteristic_length(frame.system.rest());
    figures[0] = static_cast<double>(touching(frame, at_nodes, kTouching * size));
    figures[1] = std::max(0.0, -at_nodes.minCoeff());
    figures[2] = std::max(0.0, -at_faces.minCoeff());
  }

 private:
  /// Nodes that are nearer than this to a body, in characteristic lengths, touch it.
  static constexpr double kTouching = 1e-6;

  /// How many nodes are nearer to a body, or to the distance that nodes keep from it, than `within`
  /// [m].
  static Index touching(const Frame& frame, const NodeValues& clearance, double within) {
    std::vector<NodeContact> contacts;
    const NodeVectors r = frame.positions();
    frame.system.contact().find({frame.state.time, r, frame.state.time, r}, within, contacts);
    std::vector<bool> touches(static_cast<std::size_t>(clearance.size()));
    for (Index a = 0; a < clearance.size(); ++a)
      touches[static_cast<std::size_t>(a)] = clearance[a] < within;
    for (const NodeContact& contact : contacts)
      if (contact.gap < within) touches[static_cast<std::size_t>(contact.node)] = true;
    return std::ranges::count(touches, true);
  }

  static NodeVectors face_centres(const Frame& frame) {
    const Faces& faces = frame.system.surface().faces();
    NodeVectors centres = NodeVectors::Zero(faces.size(), 3);
    for (Index f = 0; f < faces.size(); ++f) {
      const auto begin = faces.begin[static_cast<std::size_t>(f)];
      const auto end = faces.begin[static_cast<std::size_t>(f) + 1];
      for (auto k = begin; k < end; ++k)
        centres.row(f) += frame.positions().row(faces.nodes[static_cast<std::size_t>(k)]);
      centres.row(f) /= static_cast<double>(end - begin);
    }
    return centres;
  }
};

}  // namespace

DEFORM_PLUGIN(Contact, NoParameters, .name = "contact", .version = "1.0",
              .summary =
                  "nodes that touch a collider (or keep its thickness), and how deep the deepest "
                  "node and the deepest centre of a face are inside of one, whose surface is that "
                  "without thickness; empty without colliders",
              .formula = "max(0, −min φ)")
