#include "loopstone/base/byte_archive.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "loopstone/base/sound_state.hpp"
#include "loopstone/base/stamp.hpp"
#include "support/saved_state.hpp"

namespace loopstone {
namespace {

using test::restore;
using test::state_of;
using testing::HasSubstr;

enum class Colour { kRed, kGreen };
constexpr Colour last_of(Colour) { return Colour::kGreen; }

struct Inner {
  int number = 0;
  std::vector<float> values{};

  template <typename Archive>
  void archive(Archive& a) {
    a(number, values);
  }
  friend bool operator==(const Inner&, const Inner&) = default;
};

/// A field of each kind.
struct Everything {
  bool flag = false;
  std::int8_t small = 0;
  std::uint16_t middle = 0;
  std::int64_t large = 0;
  std::size_t size = 0;
  float single = 0.0F;
  double real = 0.0;
  Colour colour = Colour::kRed;
  Stamp stamp{};
  std::string text{};
  Eigen::Matrix<double, 2, 3> matrix = Eigen::Matrix<double, 2, 3>::Zero();
  std::array<Inner, 2> pair_of_inner{};
  std::optional<Inner> maybe{};
  std::vector<Inner> list{};
  std::deque<std::string> queue{};
  std::map<std::pair<std::size_t, std::size_t>, Inner> by_pair{};
  std::vector<bool> bits{};
  std::set<std::pair<int, int>> pairs{};

  template <typename Archive>
  void archive(Archive& a) {
    a(flag, small, middle, large, size, single, real, colour, stamp, text, matrix, pair_of_inner,
      maybe, list, queue, by_pair, bits, pairs);
  }
  friend bool operator==(const Everything&, const Everything&) = default;
};

Everything full() {
  Everything e{.flag = true,
               .small = -3,
               .middle = 60'000,
               .large = -1'234'567'890'123,
               .size = 17,
               .single = -0.0F,
               .real = 0.1,
               .colour = Colour::kGreen,
               .stamp = Stamp{99},
               .text = std::string("a\0b", 3),
               .pair_of_inner = {Inner{1, {1.5F}}, Inner{2, {}}},
               .maybe = Inner{3, {2.5F, 3.5F}},
               .list = {Inner{4, {}}, Inner{5, {4.5F}}},
               .queue = {"x", "", "yz"},
               .by_pair = {{{1, 2}, Inner{6, {}}}, {{0, 9}, Inner{7, {5.5F}}}},
               .bits = {true, false, true},
               .pairs = {{3, 1}, {1, 2}}};
  e.matrix << 1, 2, 3, 4, 5, 6;
  return e;
}

TEST(ByteArchive, WhatIsWrittenIsReadBack) {
  for (const Everything& before : {Everything{}, full()}) {
    Everything after = full();  // whatever it held must go
    restore(after, state_of(before));
    EXPECT_EQ(after, before);
    EXPECT_EQ(state_of(after), state_of(before));
  }
}

TEST(ByteArchive, KeepsNumbersToTheBit) {
  const std::vector<double> before{-0.0, std::numeric_limits<double>::denorm_min(),
                                   std::numeric_limits<double>::infinity(), std::nan("7")};
  std::vector<double> after;
  restore(after, state_of(before));
  ASSERT_EQ(after.size(), before.size());
  EXPECT_EQ(std::memcmp(after.data(), before.data(), before.size() * sizeof(double)), 0);
}

TEST(ByteArchive, TheLayoutIsLittleEndianWithCountsIn64Bits) {
  EXPECT_EQ(state_of(std::uint32_t{0x01020304}), "\x04\x03\x02\x01");
  EXPECT_EQ(state_of(true, 1.0F), std::string("\x01\0\0\x80\x3f", 5));
  EXPECT_EQ(state_of(std::string("ab")), std::string("\x02\0\0\0\0\0\0\0ab", 10));
  EXPECT_EQ(state_of(std::vector<std::uint16_t>{0x0102}),
            std::string("\x01\0\0\0\0\0\0\0\x02\x01", 10));
  EXPECT_EQ(state_of(std::optional<std::uint8_t>{}), std::string("\0", 1));
}

TEST(ByteArchive, BytesThatEndTooEarlyAreRefusedWhereverTheyEnd) {
  const std::string state = state_of(full());
  for (std::size_t size = 0; size < state.size(); ++size) {
    Everything after;
    EXPECT_THROW(restore(after, std::string_view(state).substr(0, size)), DataError) << size;
  }
}

TEST(ByteArchive, BytesThatAreLeftOverAreRefused) {
  Everything after;
  EXPECT_THROW(restore(after, state_of(full()) + '\0'), DataError);
}

TEST(ByteArchive, NoCountIsTrusted) {
  for (const std::uint64_t count :
       {std::uint64_t{3}, std::uint64_t{1} << 32, std::numeric_limits<std::uint64_t>::max(),
        std::numeric_limits<std::uint64_t>::max() / sizeof(double) + 1}) {
    const std::string state = state_of(count, std::uint16_t{7});
    std::string text;
    std::vector<double> plain;
    std::vector<Inner> list;
    std::deque<Inner> queue;
    std::map<int, Inner> map;
    std::vector<bool> bits;
    std::set<int> set;
    EXPECT_THROW(restore(text, state), DataError) << count;
    EXPECT_THROW(restore(plain, state), DataError) << count;
    EXPECT_THROW(restore(list, state), DataError) << count;
    EXPECT_THROW(restore(queue, state), DataError) << count;
    EXPECT_THROW(restore(map, state), DataError) << count;
    EXPECT_THROW(restore(bits, state), DataError) << count;
    EXPECT_THROW(restore(set, state), DataError) << count;
  }
}

TEST(ByteArchive, OnlyZeroAndOneAreBools) {
  bool flag = false;
  EXPECT_THROW(restore(flag, "\x02"), DataError);
  std::optional<std::uint8_t> maybe;
  EXPECT_THROW(restore(maybe, "\x03\x01"), DataError);
}

TEST(ByteArchive, AKeyThatComesTwiceIsRefused) {
  std::map<int, int> map;
  EXPECT_THROW(restore(map, state_of(std::vector<std::pair<int, int>>{{1, 2}, {1, 3}})), DataError);
  std::set<int> set;
  EXPECT_THROW(restore(set, state_of(std::vector<int>{4, 4})), DataError);
}

/// Has no default constructor, and a field that must not be negative.
struct Sized {
  explicit Sized(int size) : limit(size) {}
  int limit;
  int used = 0;

  template <typename Archive>
  void archive(Archive& a) {
    a(used);
    a.check(used <= limit, "more than fits");
  }
};

struct Shelf {
  std::vector<Sized> items{};

  template <typename Archive>
  void archive(Archive& a) {
    a.list(items, [] { return Sized(5); });
  }
};

TEST(ByteArchive, ElementsAreMadeByWhoKnowsHowAndHeldToTheirConditions) {
  Shelf shelf;
  shelf.items.emplace_back(5);
  shelf.items.back().used = 4;
  Shelf after;
  restore(after, state_of(shelf));
  ASSERT_EQ(after.items.size(), 1u);
  EXPECT_EQ(after.items.front().used, 4);
  EXPECT_EQ(after.items.front().limit, 5);
  EXPECT_THROW(restore(after, state_of(std::vector<int>{6})), DataError);
}

TEST(ByteArchive, EnumsAreNoOtherThanThereAre) {
  Colour colour = Colour::kRed;
  restore(colour, state_of(1));
  EXPECT_EQ(colour, Colour::kGreen);
  for (const int number : {2, -1, 1 << 30, std::numeric_limits<int>::min()})
    EXPECT_THROW(restore(colour, state_of(number)), DataError) << number;
}

TEST(ByteArchive, StampsAreNearEnoughToBeSubtracted) {
  Stamp stamp;
  const std::int64_t most = (std::int64_t{1} << 62) - 1;
  for (const std::int64_t nanoseconds : {most, -most}) {
    restore(stamp, state_of(nanoseconds));
    EXPECT_EQ(stamp.nanoseconds, nanoseconds);
  }
  for (const std::int64_t nanoseconds : {most + 1, -most - 1})
    EXPECT_THROW(restore(stamp, state_of(nanoseconds)), DataError) << nanoseconds;
}

TEST(ByteArchive, ErrorsNamePathAndOffset) {
  int number = 0;
  bool flag = false;
  const std::string state = state_of(1, std::uint8_t{9});
  ByteReader reader(state, {"some/file", {}, 100});
  reader(number);
  try {
    reader(flag);
    FAIL();
  } catch (const DataError& error) {
    EXPECT_EQ(error.location().path, "some/file");
    EXPECT_EQ(error.location().byte_offset, 105);
    EXPECT_THAT(error.what(), HasSubstr("neither yes nor no"));
  }
}

/// Lives by counting.
class Counter {
 public:
  struct State {
    int count = 0;

    template <typename Archive>
    void archive(Archive& a) {
      a(count);
    }
  };
  void add() { ++state_.count; }
  [[nodiscard]] const State& state() const { return state_; }
  void restore(State state) {
    require_sound(is_count(state.count), "a negative count");
    state_ = state;
  }

 private:
  State state_{};
};

TEST(SoundState, AnObjectGoesOnFromAStateThatItCanHaveHad) {
  Counter before;
  before.add();
  Counter after = test::restored(before, Counter());
  after.add();
  EXPECT_EQ(after.state().count, 2);
  EXPECT_THROW(after.restore({-1}), UsageError);
  EXPECT_EQ(after.state().count, 2);
}

}  // namespace
}  // namespace loopstone
