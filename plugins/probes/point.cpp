/// Where some nodes are.
#include <deform/record/probe.h>
#include <deform/surface/surface.h>

namespace {

using namespace deform;

struct Parameters {
  NodeSelection where;
  std::string label = "point";
  static void declare(Declaration<Parameters>& d) {
    d("where", &Parameters::where, "", "nodes whose mean is taken").required();
    d("label", &Parameters::label, "", "what the columns are called by");
  }
};

class Point final : public Probe {
 public:
  Point(const Parameters& p, const Setup& setup)
      : nodes_(setup.select(p.where)), label_(p.label), initial_(mean(setup.surface().initial())) {}

  [[nodiscard]] std::vector<ProbeColumn> columns() const override {
    std::vector<ProbeColumn> columns;
    for (const char* part : {".x", ".y", ".z", ".dx", ".dy", ".dz"})
      columns.push_back({label_ + part, "m"});
    return columns;
  }

  void measure(const Frame& frame, Values figures) override {
    const Vec3 now = mean(frame.positions());
    for (int c = 0; c < 3; ++c) {
      figures[static_cast<std::size_t>(c)] = now[c];
      figures[static_cast<std::size_t>(c) + 3] = now[c] - initial_[c];
    }
  }

 private:
  [[nodiscard]] Vec3 mean(const NodeVectors& r) const {
    Vec3 sum = Vec3::Zero();
    for (const Index node : nodes_) sum += r.row(node).transpose();
    return sum / static_cast<double>(nodes_.size());
  }

  std::vector<Index> nodes_;
  std::string label_;
  Vec3 initial_;
};

}  // namespace

DEFORM_PLUGIN(Point, Parameters, .name = "point", .version = "1.0",
              .summary = "mean position of some nodes, and how far it is from the initial one",
              .formula = "", .source = "")
