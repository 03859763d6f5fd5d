#include "deform/record/frame.h"
#include "deform/record/output.h"
#include "deform/record/probe.h"

namespace deform {

CompanionRun::~CompanionRun() = default;
Output::~Output() = default;

std::string Output::place() const { return ""; }

std::function<void()> Output::take(const Frame& frame) {
  write(frame);
  return {};
}
Probe::~Probe() = default;

void Probe::begin(const RunContext& /*context*/) {}
void Probe::follow(const Frame& /*frame*/) {}
void Probe::follow_break(const Frame& /*frame*/) {}

}  // namespace deform
