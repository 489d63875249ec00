#include "loopstone/base/memory_budget.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <initializer_list>

namespace loopstone {
namespace {

using testing::HasSubstr;

std::string refusal(const MemoryBudget& budget, std::uint64_t needed, std::uint64_t file,
                    Growth growth) {
  try {
    budget.require(needed, file, growth, {"map.png"});
  } catch (const DataError& error) {
    return error.what();
  }
  return "";
}

TEST(MemoryBudget, SmallFilesMayTakeLittleAndNoneMoreThanTheCeiling) {
  const MemoryBudget budget;
  EXPECT_EQ(refusal(budget, MemoryBudget::kSmall, 0, Growth::kNumbers), "");
  EXPECT_NE(refusal(budget, MemoryBudget::kSmall + 1, 0, Growth::kNumbers), "");
  EXPECT_EQ(refusal(budget, MemoryBudget::kSmall + 256'000, 1000, Growth::kNumbers), "");
  EXPECT_NE(refusal(budget, MemoryBudget::kSmall + 256'001, 1000, Growth::kNumbers), "");
  EXPECT_EQ(budget.allowed_bytes(~std::uint64_t{0}, Growth::kMap), budget.ceiling_bytes);
}

TEST(MemoryBudget, RefusalNamesTheFileWhatItNeedsAndWhatToDo) {
  const std::string bomb = refusal({}, 7'700'000'000, 34'000, Growth::kMap);
  EXPECT_THAT(bomb, HasSubstr("map.png: "));
  EXPECT_THAT(bomb, HasSubstr("7.7 GB"));
  EXPECT_THAT(bomb, HasSubstr("a file of 34 kB"));
  EXPECT_THAT(bomb, HasSubstr("--max-memory 7.2G"));
  const MemoryBudget given{.ceiling_bytes = parse_bytes("7.2G"), .by_file_size = false};
  EXPECT_EQ(refusal(given, 7'700'000'000, 34'000, Growth::kMap), "") << "what it says to do helps";
  EXPECT_THAT(refusal(given, 7'800'000'000, 34'000, Growth::kMap),
              HasSubstr("the limit is 7.7 GB"));
}

TEST(MemoryBudget, AmountsAreReadAsTheyAreWritten) {
  EXPECT_EQ(parse_bytes("2G"), std::uint64_t{2} << 30);
  EXPECT_EQ(parse_bytes("2GiB"), std::uint64_t{2} << 30);
  EXPECT_EQ(parse_bytes("0.5gb"), std::uint64_t{1} << 29);
  EXPECT_EQ(parse_bytes("16M"), std::uint64_t{1} << 24);
  EXPECT_EQ(parse_bytes("20000000"), 20'000'000u);
  for (const char* const wrong :
       {"", "G", "2X", "2GG", "-2G", "nan", "inf", "15M", "1e30", "2 G"}) {
    EXPECT_THROW((void)parse_bytes(wrong), UsageError) << wrong;
  }
  EXPECT_EQ(bytes_text(999), "999 bytes");
  EXPECT_EQ(bytes_text(34'000), "34 kB");
  EXPECT_EQ(bytes_text(1'500'000), "1.5 MB");
  EXPECT_EQ(bytes_text(~std::uint64_t{0}), "18 EB");
}

}  // namespace
}  // namespace loopstone
