/// Kernels: loops over raw arrays, compiled for several instruction sets of which the processor's
/// is taken when the library is loaded.
#pragma once

/// Before a function without calls into Eigen, whose code depends on the flags of its file. All
/// give the same bits: multiplications and additions are never fused (-ffp-contract=off), and a
/// loop over samples or nodes does not reorder what it does for one of them.
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define DEFORM_KERNEL [[gnu::target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")]]
#else
#define DEFORM_KERNEL
#endif
