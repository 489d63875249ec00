#include "loopstone/base/parallel_for.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "loopstone/base/rng.hpp"

namespace loopstone {
namespace {

TEST(ParallelFor, ThreadsResolveToAtLeastOne) {
  EXPECT_GE(Threads{}.resolved(), 1);
  EXPECT_GE(Threads{-3}.resolved(), 1);
  EXPECT_EQ(Threads{5}.resolved(), 5);
}

TEST(ParallelFor, VisitsEachIndexOnce) {
  for (const int threads : {1, 2, 4, 16}) {
    for (const std::size_t count : {0U, 1U, 2U, 3U, 1000U}) {
      std::vector<std::atomic<int>> visits(count);
      parallel_for(count, {threads}, [&](std::size_t i) { ++visits[i]; });
      for (const auto& n : visits) EXPECT_EQ(n, 1);
    }
  }
}

TEST(ParallelFor, OneAndManyThreadsGiveTheSameBytes) {
  const auto run = [](int threads) {
    std::vector<double> result(500);
    parallel_for(result.size(), {threads}, [&](std::size_t i) {
      Rng rng = Rng(9).fork(i);
      for (int k = 0; k < 100; ++k) result[i] += rng.normal();
    });
    return result;
  };
  const auto one = run(1);
  EXPECT_EQ(one, run(2));
  EXPECT_EQ(one, run(7));
}

TEST(ParallelFor, RethrowsTheExceptionOfTheLowestIndexAmongThoseThrown) {
  for (const int threads : {1, 4}) {
    std::atomic<int> thrown{0};
    try {
      // Nobody stops early: index 3 is reached whoever throws first.
      parallel_for(64, {threads}, [&](std::size_t i) {
        if (i >= 3) {
          ++thrown;
          throw std::runtime_error("index " + std::to_string(i));
        }
      });
      FAIL() << "nothing was thrown";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "index 3") << threads << " threads";
    }
    EXPECT_GE(thrown, 1);
  }
}

TEST(ParallelFor, WorksAfterAFailure) {
  EXPECT_THROW(parallel_for(8, {4}, [](std::size_t) { throw 1; }), int);
  std::atomic<int> sum{0};
  parallel_for(8, {4}, [&](std::size_t i) { sum += static_cast<int>(i); });
  EXPECT_EQ(sum, 28);
}

TEST(ParallelFor, MayBeNested) {
  std::vector<int> sums(6);
  parallel_for(sums.size(), {3}, [&](std::size_t i) {
    std::vector<int> inner(10);
    parallel_for(inner.size(), {3}, [&](std::size_t k) { inner[k] = static_cast<int>(i * k); });
    sums[i] = std::accumulate(inner.begin(), inner.end(), 0);
  });
  EXPECT_EQ(sums, (std::vector<int>{0, 45, 90, 135, 180, 225}));
}

}  // namespace
}  // namespace loopstone
