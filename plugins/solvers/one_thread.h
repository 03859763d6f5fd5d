/// Keeps what is below a direct solver (BLAS, OpenMP) on the thread that calls it.
#pragma once

#include <dlfcn.h>

namespace {

/// A function of a library that this process has, perhaps.
template <class Function>
Function* find_function(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_DEFAULT, name));
}

/// While it lives, BLAS makes no threads of its own (for good) and OpenMP none for this one. Dense
/// kernels on several threads sum in an order that depends on their number, and results must not;
/// and the loops of CHOLMOD, with a number of threads that is compiled in and heeds no call for
/// fewer, are so short that threads spend their time waiting for each other. A region that no level
/// of parallelism is allowed for runs on the thread that meets it (OpenMP 5.0, 3.2.16). Of BLAS
/// libraries OpenBLAS alone is known to make threads by itself; with another one, or without
/// OpenMP, that part does nothing.
class OneThread {
 public:
  OneThread() {
    static auto* const set_blas_threads = find_function<void(int)>("openblas_set_num_threads");
    if (set_blas_threads != nullptr) set_blas_threads(1);
    if (!is_known()) return;
    levels_ = functions().levels();
    functions().set_levels(0);
  }
  ~OneThread() {
    if (is_known()) functions().set_levels(levels_);
  }
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  struct OpenMp {
    int (*levels)() = find_function<int()>("omp_get_max_active_levels");
    void (*set_levels)(int) = find_function<void(int)>("omp_set_max_active_levels");
  };
  static const OpenMp& functions() {
    static const OpenMp found;
    return found;
  }
  static bool is_known() {
    return functions().levels != nullptr && functions().set_levels != nullptr;
  }

  int levels_ = 0;
};

}  // namespace
