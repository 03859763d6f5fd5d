/// Where the time of steps goes.
#pragma once

#include "deform/export.h"

namespace deform {

/// Seconds spent, by part of a step. Each moment is of one part: all of them together are no more
/// than the time that went by.
struct StepTimes {
  double geometry = 0, assembly = 0, factorisation = 0, solve = 0, output = 0;
  long steps = 0;
};

/// While it lives, what this thread evaluates and solves adds its time to `times`, of whatever
/// System it is; null: to none. The last one that was made counts.
class DEFORM_API TimesAddedTo {
 public:
  explicit TimesAddedTo(StepTimes* times);
  ~TimesAddedTo();
  TimesAddedTo(const TimesAddedTo&) = delete;
  TimesAddedTo& operator=(const TimesAddedTo&) = delete;

 private:
  StepTimes* before_;
};

}  // namespace deform
