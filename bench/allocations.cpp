#include "allocations.h"

#include <array>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <link.h>
#include <new>
#include <string_view>

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define DEFORM_COUNTS_ALLOCATIONS
#endif

namespace {

struct Range {
  std::uintptr_t begin = 0, end = 0;
};

// Fixed arrays: whoever counts allocations must not make any.
std::array<Range, 256> own_code;
std::atomic<std::size_t> own_ranges{0};
std::atomic<long> own{0}, total{0};

/// The program has no name; the framework and its plugins have "deform" in theirs.
int add_object(dl_phdr_info* object, std::size_t /*size*/, void* count) {
  const std::string_view path(object->dlpi_name);
  const std::string_view name = path.substr(path.rfind('/') + 1);
  if (!path.empty() && name.find("deform") == std::string_view::npos &&
      path.find("/deform/") == std::string_view::npos)
    return 0;
  for (int i = 0; i < object->dlpi_phnum; ++i) {
    const auto& part = object->dlpi_phdr[i];
    auto& n = *static_cast<std::size_t*>(count);
    if (part.p_type != PT_LOAD || (part.p_flags & PF_X) == 0 || n == own_code.size()) continue;
    const std::uintptr_t begin = object->dlpi_addr + part.p_vaddr;
    own_code[n++] = {begin, begin + part.p_memsz};
  }
  return 0;
}

#ifdef DEFORM_COUNTS_ALLOCATIONS
void count(const void* caller) {
  total.fetch_add(1, std::memory_order_relaxed);
  const auto address = reinterpret_cast<std::uintptr_t>(caller);
  for (std::size_t i = 0; i < own_ranges.load(std::memory_order_relaxed); ++i)
    if (address >= own_code[i].begin && address < own_code[i].end) {
      own.fetch_add(1, std::memory_order_relaxed);
      return;
    }
}
#endif

}  // namespace

namespace deform::bench {

void find_own_code() {
  std::size_t count = 0;
  dl_iterate_phdr(add_object, &count);
  own_ranges = count;
}

Allocations allocations() { return {own.load(), total.load()}; }

}  // namespace deform::bench

#ifdef DEFORM_COUNTS_ALLOCATIONS
// operator new is replaced beside malloc because it would else be libstdc++ that calls malloc.
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* block, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) {
  count(__builtin_return_address(0));
  return __libc_malloc(size);
}
void* calloc(std::size_t n, std::size_t size) {
  count(__builtin_return_address(0));
  return __libc_calloc(n, size);
}
void* realloc(void* block, std::size_t size) {
  count(__builtin_return_address(0));
  return __libc_realloc(block, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  count(__builtin_return_address(0));
  return __libc_memalign(alignment, size);
}
}

void* operator new(std::size_t size) {
  count(__builtin_return_address(0));
  if (void* block = __libc_malloc(size == 0 ? 1 : size)) return block;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  count(__builtin_return_address(0));
  if (void* block = __libc_memalign(static_cast<std::size_t>(alignment), size)) return block;
  throw std::bad_alloc();
}
void operator delete(void* block) noexcept { std::free(block); }
void operator delete(void* block, std::size_t /*size*/) noexcept { std::free(block); }
void operator delete(void* block, std::align_val_t /*alignment*/) noexcept { std::free(block); }
void operator delete(void* block, std::size_t /*size*/, std::align_val_t /*alignment*/) noexcept {
  std::free(block);
}
#endif
