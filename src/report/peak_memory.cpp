#include "loopstone/report/peak_memory.hpp"

#include <sys/resource.h>

#include <fstream>
#include <string>

namespace loopstone {

namespace {

constexpr std::int64_t kBytesPerKibibyte = 1024;

/// A line of /proc/self/status, "VmHWM:  1234 kB"; 0 when there is none.
std::int64_t bytes_of(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    std::int64_t kibibytes = 0;
    if (word == name && status >> kibibytes) return kibibytes * kBytesPerKibibyte;
  }
  return 0;
}

}  // namespace

std::int64_t memory_bytes() { return bytes_of("VmRSS:"); }

std::int64_t peak_memory_bytes() {
  if (const std::int64_t peak = bytes_of("VmHWM:"); peak > 0) return peak;
  // The kernel carries ru_maxrss across fork and exec, so a program started by a large one looks
  // large.
  rusage usage{};
  if (getrusage(RUSAGE_SELF, &usage) != 0) return 0;
#if defined(__APPLE__)
  return usage.ru_maxrss;
#else
  return static_cast<std::int64_t>(usage.ru_maxrss) * kBytesPerKibibyte;
#endif
}

}  // namespace loopstone
