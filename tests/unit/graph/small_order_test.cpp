#include "graph/small_order.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <set>
#include <utility>
#include <vector>

#include "loopstone/base/rng.hpp"

namespace loopstone {
namespace {

using Neighbours = std::vector<std::set<int>>;

void join(Neighbours& neighbours, int a, int b) {
  if (a == b) return;
  neighbours[static_cast<std::size_t>(a)].insert(b);
  neighbours[static_cast<std::size_t>(b)].insert(a);
}

/// The same by sets, one pair after the other; `joined` as far as it is known before.
std::vector<int> naive_order(Neighbours neighbours, std::vector<std::int64_t> joined) {
  std::vector<int> place(neighbours.size(), -1);
  const auto fill = [&](std::size_t i) {
    const auto degree = static_cast<std::int64_t>(neighbours[i].size());
    return degree * (degree - 1) - joined[i] * (joined[i] - 1);
  };
  for (int next = 0; next < static_cast<int>(place.size()); ++next) {
    std::size_t least = place.size();
    for (std::size_t i = 0; i < place.size(); ++i) {
      if (place[i] >= 0) continue;
      if (least == place.size() || fill(i) < fill(least)) least = i;
    }
    place[least] = next;
    const std::set<int> around = neighbours[least];
    for (const int a : around) {
      neighbours[static_cast<std::size_t>(a)].erase(static_cast<int>(least));
      for (const int b : around) join(neighbours, a, b);
    }
    for (const int a : around) {
      const auto n = static_cast<std::size_t>(a);
      joined[n] = std::max(joined[n] - 1, static_cast<std::int64_t>(around.size()) - 1);
    }
  }
  return place;
}

TEST(SmallGraph, OrdersAsSetsDo) {
  for (const int size : {1, 2, 63, 64, 65, 130, 200}) {
    for (std::uint64_t seed = 0; seed < 4; ++seed) {
      Rng rng = Rng(seed).fork(static_cast<std::uint64_t>(size));
      const auto node = [&] {
        return static_cast<int>(rng.below(static_cast<std::uint64_t>(size)));
      };
      SmallGraph graph(size);
      Neighbours neighbours(static_cast<std::size_t>(size));
      std::vector<std::int64_t> joined(static_cast<std::size_t>(size), 0);
      for (int i = 0; i < 2 * size; ++i) {
        const std::pair<int, int> pair{node(), node()};
        graph.join(pair.first, pair.second);
        join(neighbours, pair.first, pair.second);
      }
      for (int i = 0; i < size / 20; ++i) {
        const std::set<int> set{node(), node(), node(), node(), node()};
        const std::vector<int> all(set.begin(), set.end());
        graph.join_all(all);
        for (const int a : all) {
          std::int64_t& known = joined[static_cast<std::size_t>(a)];
          known = std::max(known, static_cast<std::int64_t>(all.size()) - 1);
        }
        for (const int a : all) {
          for (const int b : all) join(neighbours, a, b);
        }
      }
      for (std::size_t i = 0; i < joined.size(); ++i) {
        if (!neighbours[i].empty()) joined[i] = std::max<std::int64_t>(joined[i], 1);
      }
      EXPECT_EQ(std::move(graph).minimum_fill_order(), naive_order(neighbours, joined)) << size;
    }
  }
}

TEST(SmallGraph, EliminatesAChainFromItsEnds) {
  SmallGraph graph(4);
  graph.join(0, 1);
  graph.join(1, 2);
  graph.join(2, 3);
  EXPECT_EQ(std::move(graph).minimum_fill_order(), (std::vector<int>{0, 1, 2, 3}));
  EXPECT_TRUE(SmallGraph(0).minimum_fill_order().empty());
}

}  // namespace
}  // namespace loopstone
