/// Keeps the BLAS below a direct solver on one thread.
#pragma once

#include <dlfcn.h>

namespace {

/// Dense kernels on several threads sum in an order that depends on their number, and results must
/// not. Only OpenBLAS is known to make threads of its own; with another BLAS this does nothing.
inline void keep_blas_on_one_thread() {
  using SetThreads = void (*)(int);
  if (void* set_threads = dlsym(RTLD_DEFAULT, "openblas_set_num_threads"))
    reinterpret_cast<SetThreads>(set_threads)(1);
}

}  // namespace
