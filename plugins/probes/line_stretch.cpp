/// How much a line of nodes is longer than at rest.
#include <deform/record/probe.h>
#include <deform/surface/surface.h>

#include "node_line.h"

namespace {

using namespace deform;

struct Parameters {
  NodeSelection where;
  std::string label;
  static void declare(Declaration<Parameters>& d) {
    d("where", &Parameters::where, "", "the nodes: one line along a1 or a2").required();
    d("label", &Parameters::label, "",
      "what the column is called by: \"left\" in line_stretch.left");
  }
};

class LineStretch final : public Probe {
 public:
  LineStretch(const Parameters& p, const Setup& setup)
      : label_(p.label),
        line_(in_order(setup.select(p.where), setup.surface().parameters())),
        rest_(length_of(line_, setup.rest())) {
    if (!(rest_ > 0))
      throw InputError({{"/where", "found " + std::to_string(line_.size()) +
                                       " nodes of no length, expected a line"}});
  }

  [[nodiscard]] std::vector<ProbeColumn> columns() const override {
    return {{label_.empty() ? "line_stretch" : "line_stretch." + label_, "1"}};
  }
  void measure(const Frame& frame, Values figures) override {
    figures[0] = length_of(line_, frame.positions()) / rest_ - 1;
  }

 private:
  std::string label_;
  std::vector<Index> line_;
  double rest_;  // [m]
};

}  // namespace

DEFORM_PLUGIN(LineStretch, Parameters, .name = "line_stretch", .version = "1.0",
              .summary = "how much longer a line of nodes is than at rest",
              .formula = "length/rest length - 1, of the polygon through the nodes", .source = "")
