#include "solve/stopwatch.h"

namespace deform {

constinit thread_local Stopwatch* Stopwatch::innermost_ = nullptr;

}  // namespace deform
