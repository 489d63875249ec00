#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdlib>
#include <memory_resource>
#include <new>

namespace loopstone::bench {

/// Memory in large pages, where the system has some to give.
class LargePages : public std::pmr::memory_resource {
  static constexpr std::size_t kPage = std::size_t{1} << 21;

  void* do_allocate(std::size_t bytes, std::size_t /*alignment*/) override {
    const std::size_t whole = (bytes + kPage - 1) / kPage * kPage;
    void* const memory = std::aligned_alloc(kPage, whole);
    if (memory == nullptr) throw std::bad_alloc();
#ifdef MADV_HUGEPAGE
    static_cast<void>(madvise(memory, whole, MADV_HUGEPAGE));  // advice: no harm when refused
#endif
    return memory;
  }
  void do_deallocate(void* memory, std::size_t, std::size_t) override { std::free(memory); }
  [[nodiscard]] bool do_is_equal(const std::pmr::memory_resource& that) const noexcept override {
    return this == &that;
  }
};

}  // namespace loopstone::bench
