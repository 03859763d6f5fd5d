/// Reports of steps in checkpoints: whoever resumes records the last step once more.
#pragma once

#include "deform/plugin/plugin.h"
#include "deform/solve/system.h"

namespace deform {

void save_report(const StepReport& report, Memory& memory);
/// Of a system with so many rows. Throws InputError when it is none.
void load_report(StepReport& report, const Memory& memory, Index rows);

}  // namespace deform
