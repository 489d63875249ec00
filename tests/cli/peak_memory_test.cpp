// What the program says of its memory is its own, whoever started it.

#include <gtest/gtest.h>

#include <cstddef>
#include <nlohmann/json.hpp>
#include <vector>

#include "run_program.hpp"
#include "support/temp_dir.hpp"

namespace loopstone::test {
namespace {

TEST(MapCommandPeakMemory, IsNotThatOfAParentWithMuch) {
  constexpr std::size_t kParentBytes = 400'000'000;
  const TempDir dir;
  ASSERT_EQ(run_program({"simulate", "rooms", "-o", dir / "log", "--duration", "3", "--beams", "91",
                         "--quiet"})
                .exit_code,
            0);
  const std::vector<char> block(kParentBytes, 'x');
  const ProgramResult result =
      run_program({"map", dir / "log", "-o", dir / "out", "--quiet", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(block.back(), 'x') << "it is held until the program has ended";
  const auto told = [](const std::string& summary) {
    return nlohmann::json::parse(summary).at("peak_memory_bytes").get<double>();
  };
  EXPECT_LT(told(result.out), 0.5 * kParentBytes);
  EXPECT_GT(told(result.out), 1e6);
  // The file is written before all is. The kernel counts pages in batches.
  EXPECT_LE(told(dir.read("out/summary.json")), told(result.out) + 1e6);
}

}  // namespace
}  // namespace loopstone::test
