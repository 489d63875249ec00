#include "loopstone/base/parallel_for.hpp"

#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>

namespace loopstone {

int Threads::resolved() const {
  if (count > 0) return count;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

void parallel_for(std::size_t count, Threads threads,
                  const std::function<void(std::size_t)>& body) {
  const int workers = threads.resolved();
  if (workers == 1 || count <= 1) {
    for (std::size_t i = 0; i < count; ++i) body(i);
    return;
  }
  std::mutex failure_mutex;
  std::size_t failed_index = count;
  std::exception_ptr failure;
  // TBB orders the caller before every body and every body before the return. The two atomics say
  // the same in terms that the thread sanitizer understands (it cannot see into libtbb), so that it
  // reports races between bodies and no others.
  std::atomic<bool> started{false};
  std::atomic<std::size_t> finished{0};
  started.store(true, std::memory_order_release);
  // More threads than processors gain nothing, and TBB would complain on stderr.
  oneapi::tbb::task_arena arena(std::min(workers, oneapi::tbb::info::default_concurrency()));
  arena.execute([&] {
    oneapi::tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
      (void)started.load(std::memory_order_acquire);
      try {
        body(i);
      } catch (...) {
        const std::scoped_lock lock(failure_mutex);
        if (i < failed_index) {
          failed_index = i;
          failure = std::current_exception();
        }
      }
      finished.fetch_add(1, std::memory_order_release);
    });
  });
  (void)finished.load(std::memory_order_acquire);
  if (failure) std::rethrow_exception(failure);
}

}  // namespace loopstone
