/// Kernels: loops over raw arrays, compiled for several instruction sets of which the processor's
/// is taken when the library is loaded.
#pragma once

#include "deform/export.h"

/// Before a function without calls into Eigen, whose code depends on the flags of its file. All
/// give the same bits: multiplications and additions are never fused (-ffp-contract=off), and a
/// loop over samples or nodes does not reorder what it does for one of them.
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define DEFORM_KERNEL [[gnu::target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")]]
#else
#define DEFORM_KERNEL
#endif

namespace deform {

/// Bytes of the processor's vectors: 64 (x86-64-v4), 32 (v3) or 16.
DEFORM_API int vector_bytes();

}  // namespace deform

/// Defines `result name parameters`, a kernel with vectors by name, from the template
/// `name_by<Bytes>`, which is [[gnu::always_inline]] and takes vectors of so many bytes:
/// wider ones than the processor has would go through memory. `arguments`: the parameters' names.
/// The same bits by any width: templates do the same for each number, in the same order.
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define DEFORM_VECTOR_KERNEL(result, name, parameters, arguments)        \
  namespace {                                                            \
  [[gnu::target("arch=x86-64-v4")]] inline result name##_v4 parameters { \
    return name##_by<64> arguments;                                      \
  }                                                                      \
  [[gnu::target("arch=x86-64-v3")]] inline result name##_v3 parameters { \
    return name##_by<32> arguments;                                      \
  }                                                                      \
  }                                                                      \
  result name parameters {                                               \
    static const int bytes = ::deform::vector_bytes();                   \
    if (bytes == 64) return name##_v4 arguments;                         \
    if (bytes == 32) return name##_v3 arguments;                         \
    return name##_by<16> arguments;                                      \
  }
#else
// `arguments` come in parentheses of their own. NOLINTBEGIN(bugprone-macro-parentheses)
#define DEFORM_VECTOR_KERNEL(result, name, parameters, arguments) \
  result name parameters { return name##_by<16> arguments; }
// NOLINTEND(bugprone-macro-parentheses)
#endif
