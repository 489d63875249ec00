#include "loopstone/formats/machine_memory.hpp"

#include <unistd.h>

#include <algorithm>
#include <fstream>

namespace loopstone {

MemoryBudget machine_memory_budget() {
  MemoryBudget budget;
  const auto limit_to = [&budget](std::uint64_t bytes) {
    // Groups without a limit say "max", or a number beyond any machine.
    budget.ceiling_bytes = std::min(budget.ceiling_bytes, bytes / 4 * 3);
  };
  const long pages = ::sysconf(_SC_PHYS_PAGES);
  const long page_bytes = ::sysconf(_SC_PAGESIZE);
  if (pages > 0 && page_bytes > 0) {
    limit_to(saturated_product(static_cast<std::uint64_t>(pages),
                               static_cast<std::uint64_t>(page_bytes)));
  }
  for (const char* const path :
       {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"}) {
    std::uint64_t bytes = 0;
    if (std::ifstream(path) >> bytes && bytes > 0) limit_to(bytes);
  }
  return budget;
}

}  // namespace loopstone
