#include "loopstone/base/union_find.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <vector>

#include "loopstone/base/rng.hpp"

namespace loopstone {
namespace {

TEST(UnionFind, TheLowestElementIsTheRoot) {
  std::vector<int> parents{0, 1, 2, 3, 4};
  join(parents, 4, 3);
  join(parents, 3, 1);
  EXPECT_EQ(root_of(parents, 4), 1);
  EXPECT_EQ(root_of(parents, 1), 1);
  EXPECT_EQ(root_of(parents, 0), 0);
  EXPECT_EQ(root_of(parents, 2), 2);
}

/// Beside labels that are painted over.
TEST(UnionFind, SetsAreThoseOfTheNaiveTwin) {
  constexpr std::size_t kElements = 60;
  Rng rng(3);
  std::vector<std::size_t> parents(kElements);
  std::iota(parents.begin(), parents.end(), std::size_t{0});
  std::vector<std::size_t> labels = parents;
  for (int step = 0; step < 45; ++step) {
    const std::size_t a = rng.below(kElements);
    const std::size_t b = rng.below(kElements);
    join(parents, a, b);
    const auto [low, high] = std::minmax(labels[a], labels[b]);
    const std::size_t kept = low;
    const std::size_t gone = high;
    for (std::size_t& label : labels) label = label == gone ? kept : label;
    for (std::size_t i = 0; i < kElements; ++i) ASSERT_EQ(root_of(parents, i), labels[i]);
  }
}

}  // namespace
}  // namespace loopstone
