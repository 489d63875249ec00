#pragma once

#include <cstdint>

namespace loopstone {

/// The most physical memory that this process has held at once since its program began [bytes],
/// files mapped into it included. From /proc/self/status; where there is none from getrusage, whose
/// figure is at least that of the process that started this one. 0 where neither knows. To a
/// megabyte: the kernel counts pages in batches, so it may even fall by some.
[[nodiscard]] std::int64_t peak_memory_bytes();

/// What it holds now [bytes], to a megabyte; 0 where there is no /proc/self/status.
[[nodiscard]] std::int64_t memory_bytes();

}  // namespace loopstone
