#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace loopstone {

/// Numbers that fill many pages and are read in no order. Where the system has large pages it is asked for them: with
/// small ones every look-up would first have to find its page, which takes as long as the look-up. Not initialised.
template <typename T>
class LargeArray {
 public:
  LargeArray() = default;
  explicit LargeArray(std::size_t size) : size_(size) {
    if (size == 0) return;
    constexpr std::size_t kLargePage = std::size_t{1} << 21;
    const std::size_t bytes = (size * sizeof(T) + kLargePage - 1) / kLargePage * kLargePage;
    data_.reset(static_cast<T*>(std::aligned_alloc(kLargePage, bytes)));
    if (data_ == nullptr) throw std::bad_alloc();
#if defined(__linux__) && defined(MADV_HUGEPAGE)
    static_cast<void>(madvise(data_.get(), bytes, MADV_HUGEPAGE));  // advice: no harm when refused
#endif
  }

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] T& operator[](std::size_t i) { return data_[i]; }
  [[nodiscard]] const T& operator[](std::size_t i) const { return data_[i]; }

 private:
  struct Free {
    void operator()(T* data) const { std::free(data); }
  };
  std::size_t size_ = 0;
  std::unique_ptr<T[], Free> data_{};
};

}  // namespace loopstone
