/// Counts allocations of the whole process. For programs that link allocations.cpp.
#pragma once

namespace deform::bench {

struct Allocations {
  long own = 0;    ///< called for by code of deform: framework, plugins, the program itself
  long total = 0;  ///< these and those of libraries
};

/// Learns where the code of deform lies in memory; call it once all plugins are loaded.
void find_own_code();
/// Allocations since the program began; `own` since find_own_code(). Zero in a build with a
/// sanitizer, which has an allocator of its own.
[[nodiscard]] Allocations allocations();

}  // namespace deform::bench
