#include <deform/model/constraint.h>
#include <deform/surface/surface.h>

namespace {
using namespace deform;

struct Parameters {
  NodeSelection where;
  std::vector<std::string> components{"x", "y", "z"};
  static void declare(Declaration<Parameters>& d) {
    d("where", &Parameters::where, "", "nodes that are held").required();
    d("components", &Parameters::components, "", "what is held of them").one_of({"x", "y", "z"});
  }
};

/// Holds nodes, or some of their components, where they are at first.
class Pin final : public Constraint {
 public:
  Pin(const Parameters& p, const Setup& setup)
      : nodes_(setup.select(p.where)), initial_(setup.surface().initial()) {
    for (const std::string& name : p.components) components_.push_back(name[0] - 'x');
    if (components_.empty()) throw InputError("'components' is empty: name some of x, y, z");
  }

  void reduce(Reduction& reduction) const override {
    for (const Index node : nodes_)
      for (const int c : components_) reduction.prescribe(node, c);
  }
  void prescribe(double /*time*/, NodeVectors& r) const override {
    for (const Index node : nodes_)
      for (const int c : components_) r(node, c) = initial_(node, c);
  }

 private:
  std::vector<Index> nodes_;
  std::vector<int> components_;  // 0: x, 1: y, 2: z
  NodeVectors initial_;          // (N × 3) [m]
};

}  // namespace

DEFORM_PLUGIN(Pin, Parameters, .name = "pin", .version = "1.0",
              .summary = "holds nodes, or single components of them, at their initial positions",
              .formula = "r_a(t) = r_a(0)", .source = "Wu & Melo, section 3 (fixed boundary)")
