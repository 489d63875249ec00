#include "loopstone/base/thinned.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <vector>

namespace loopstone {
namespace {

TEST(Thinned, KeepsAllOfAFewAndSpreadsTheRestEvenly) {
  std::vector<int> values(100);
  std::iota(values.begin(), values.end(), 0);
  EXPECT_EQ(thinned(values, 200), values);
  EXPECT_EQ(thinned(values, 100), values);
  EXPECT_EQ(thinned(values, 4), (std::vector<int>{0, 25, 50, 75}));
  EXPECT_TRUE(thinned(values, 0).empty());
  EXPECT_TRUE(thinned(std::vector<int>{}, 5).empty());
  const auto some = thinned(values, 33);
  ASSERT_EQ(some.size(), 33U);
  for (std::size_t i = 1; i < some.size(); ++i) {
    EXPECT_GE(some[i] - some[i - 1], 3);
    EXPECT_LE(some[i] - some[i - 1], 4);
  }
}

}  // namespace
}  // namespace loopstone
