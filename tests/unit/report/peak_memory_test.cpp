#include "loopstone/report/peak_memory.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

namespace loopstone {
namespace {

TEST(PeakMemory, GrowsWithWhatIsTouchedAndStays) {
  constexpr std::size_t kBytes = 64 << 20;
  constexpr std::int64_t kBatches = 1 << 20;  // that the kernel counts pages in
  const std::int64_t before = peak_memory_bytes();
  ASSERT_GT(before, 1 << 20) << "a process that runs has pages";
  std::int64_t within = 0;
  {
    const std::vector<char> block(before + kBytes, 'x');
    within = peak_memory_bytes();
    EXPECT_GE(within + kBatches, static_cast<std::int64_t>(block.size()));
  }
  EXPECT_LT(within, 2 * before + 2 * static_cast<std::int64_t>(kBytes)) << "bytes, not kibibytes";
  EXPECT_GE(peak_memory_bytes() + kBatches, within);
}

}  // namespace
}  // namespace loopstone
