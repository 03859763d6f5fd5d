#include "solve/stopwatch.h"

#include <utility>

namespace deform {

constinit thread_local Stopwatch* Stopwatch::innermost_ = nullptr;
constinit thread_local StepTimes* Stopwatch::active_ = nullptr;

TimesAddedTo::TimesAddedTo(StepTimes* times) : before_(std::exchange(Stopwatch::active_, times)) {}
TimesAddedTo::~TimesAddedTo() { Stopwatch::active_ = before_; }

}  // namespace deform
