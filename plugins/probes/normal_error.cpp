/// How far the estimated normal points away from the exact one: coefficients of the previous state
/// on the present jets, which is what a linearly implicit step has just used.
#include <algorithm>

#include <deform/record/jet_terms.h>
#include <deform/record/probe.h>

namespace {

using namespace deform;

class NormalError final : public Probe {
 public:
  NormalError(const NoParameters& /*parameters*/, const Setup& /*setup*/) {}

  void begin(const RunContext& context) override { terms_ = terms_with_normal(context.system); }

  [[nodiscard]] std::vector<ProbeColumn> columns() const override {
    if (terms_.empty()) return {{"normal_error", "rad"}};
    std::vector<ProbeColumn> columns;
    for (const JetTermUse& use : terms_)
      for (const char* figure : {".mean", ".max"})
        columns.push_back({"normal_error." + use.name + figure, "rad"});
    return columns;
  }

  void measure(const Frame& frame, Values figures) override {
    std::fill(figures.begin(), figures.end(), kNoFigure);
    if (frame.step == 0) return;  // there is no previous state
    for (std::size_t t = 0; t < terms_.size(); ++t) {
      const Angles angles = angles_of(terms_[t], frame);
      if (angles.none()) continue;
      figures[2 * t] = angles.mean();
      figures[2 * t + 1] = angles.max();
    }
  }

 private:
  Angles angles_of(const JetTermUse& use, const Frame& frame) {
    const auto geometry = frame.geometry(*use.samples),
               previous = frame.previous_geometry(*use.samples);
    const Geometry &now = *geometry, &lagged = *previous;
    const ConstVectors n = now.all().n();
    const ConstValues area = use.samples->weights();
    Angles angles;
    for (const Pair ij : kPairs) {
      estimate_normals(use, lagged, now, ij, estimates_);
      for (Index s = 0; s < now.size(); ++s) {
        angles.add(angle_between(estimates_.row(s), n[s]),
                   area[static_cast<std::size_t>(s)] * multiplicity(ij));
      }
    }
    return angles;
  }

  std::vector<JetTermUse> terms_;
  NodeVectors estimates_;
};

}  // namespace

DEFORM_PLUGIN(NormalError, NoParameters, .name = "normal_error", .version = "1.0",
              .summary =
                  "Directed angle, 0 to pi, between a term's estimated normal (previous "
                  "coefficients, present jet) and the exact one; empty at the first frame. Under "
                  "integrators other than semi_implicit no force is made of such an estimate",
              .formula =
                  "atan2(|n_ij x n|, n_ij.n) over samples and all four ij where r_ij exists "
                  "and n_ij has a direction (|n_ij| >= 1e-9)",
              .source = "Wu and Melo, section 4")
