/// The run against its mirror image, which runs beside it. A flat sheet's physics does not know up
/// from down: whatever this probe reports beyond rounding was put there by the discretisation or
/// the normal estimator.
#include <deform/log.h>
#include <deform/record/probe.h>

namespace {

using namespace deform;

class MirrorAsymmetry final : public Probe {
 public:
  MirrorAsymmetry(const NoParameters& /*parameters*/, const Setup& /*setup*/) {}

  void begin(const RunContext& context) override {
    companion_ = context.mirrored();
    restore();
  }

  [[nodiscard]] std::vector<ProbeColumn> columns() const override {
    return {{"mirror_asymmetry", "m"}};
  }

  void follow(const Frame& frame) override {
    try {
      while (!diverged_ && companion_->steps() < frame.step) companion_->step();
    } catch (const Diverged& e) {
      diverged_ = true;
      log::warn(
          std::string("mirror_asymmetry: the mirror image diverged, no figures from here on: ") +
          e.what());
    }
  }

  void measure(const Frame& frame, Values figures) override {
    figures[0] = kNoFigure;
    if (diverged_ || companion_->steps() != frame.step) return;
    NodeVectors difference = companion_->state().r.topRows(frame.system.nodes());
    difference.col(2) *= -1;
    difference -= frame.positions();
    figures[0] = difference.rowwise().norm().maxCoeff();
  }

  void save(Memory& memory) const override {
    memory.put("diverged", {diverged_ ? 1.0 : 0.0});
    if (!companion_) return;
    Memory companion;
    companion_->save(companion);
    for (const auto& [name, values] : companion.entries()) memory.put(kPrefix + name, values);
  }

  void load(const Memory& memory) override {
    diverged_ = memory.get("diverged", 1).front() != 0;
    saved_ = Memory();
    for (const auto& [name, values] : memory.entries())
      if (name.starts_with(kPrefix)) saved_.put(name.substr(kPrefix.size()), values);
    restore();
  }

 private:
  // Whichever of begin and load comes last has both the companion and what it remembers.
  void restore() {
    if (companion_ && !saved_.entries().empty()) companion_->load(saved_);
  }

  inline static const std::string kPrefix = "companion.";
  std::unique_ptr<CompanionRun> companion_;
  Memory saved_;
  bool diverged_ = false;
};

}  // namespace

DEFORM_PLUGIN(MirrorAsymmetry, NoParameters, .name = "mirror_asymmetry", .version = "1.0",
              .summary =
                  "Largest distance between a node and its mirror image's: runs the scene "
                  "reflected at z = 0 beside (twice the cost); empty once that diverges",
              .formula =
                  "max over nodes of |r - S r'|, S = diag(1, 1, -1), r' the run of the "
                  "reflected scene",
              .source = "")
