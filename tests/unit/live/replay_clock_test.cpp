#include "loopstone/live/replay_clock.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>
#include <vector>

namespace loopstone {
namespace {

using Turn = ReplayClock::Turn;

constexpr Stamp at(double seconds) { return Stamp{static_cast<std::int64_t>(seconds * 1e9)}; }

/// A recording of 100 s, played as fast as it goes unless told otherwise.
struct Replay : testing::Test {
  std::vector<PlaybackState> told{};
  ReplayClock clock{
      {at(0), at(100)}, 0.0, [this](const PlaybackState& state) { told.push_back(state); }};
  static bool yes() { return true; }
  static bool no() { return false; }
};

TEST_F(Replay, GoesAsFastAsItCan) {
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].status, PlaybackStatus::kPlaying);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(clock.wait_for(at(i), no), Turn::kGoOn);
}

TEST_F(Replay, GoesAtItsPace) {
  clock.control({.speed = 100.0});
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i <= 10; ++i) EXPECT_EQ(clock.wait_for(at(i), yes), Turn::kGoOn);
  // Never faster; how much slower is the machine's to say.
  EXPECT_GE(std::chrono::steady_clock::now() - start, std::chrono::milliseconds(99));
}

TEST_F(Replay, PausesUntilSomebodyPlays) {
  EXPECT_EQ(clock.wait_for(at(1), no), Turn::kGoOn);
  clock.control({.play = false, .speed = 1.0, .request = "a"});
  EXPECT_EQ(told.back().status, PlaybackStatus::kPaused);
  EXPECT_EQ(told.back().request, "a");
  EXPECT_EQ(told.back().now, at(1));
  EXPECT_FALSE(told.back().did_seek);
  EXPECT_EQ(clock.wait_for(at(2), no), Turn::kStopped);
  std::thread player([&] { clock.control({.speed = 0.0}); });
  EXPECT_EQ(clock.wait_for(at(2), yes), Turn::kGoOn);
  player.join();
}

TEST_F(Replay, GoesForwardWithoutWaiting) {
  clock.control({.play = false, .speed = 1.0, .seek_to = at(50)});
  EXPECT_EQ(told.back().status, PlaybackStatus::kBuffering);
  EXPECT_TRUE(told.back().did_seek);
  EXPECT_EQ(told.back().now, at(50));
  for (int i = 1; i <= 50; ++i) EXPECT_EQ(clock.wait_for(at(i), no), Turn::kGoOn) << i;
  EXPECT_EQ(told.back().status, PlaybackStatus::kPaused);
  EXPECT_EQ(clock.wait_for(at(51), no), Turn::kStopped);
  EXPECT_FALSE(clock.goal().has_value());
}

TEST_F(Replay, GoesBackFromTheBeginning) {
  for (int i = 1; i <= 50; ++i) (void)clock.wait_for(at(i), no);
  clock.control({.play = true, .speed = 0.0, .seek_to = at(20)});
  EXPECT_EQ(clock.wait_for(at(51), no), Turn::kSeekBack);
  EXPECT_EQ(clock.goal(), at(20));
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(clock.wait_for(at(i), no), Turn::kGoOn);
    EXPECT_TRUE(clock.goal().has_value());
  }
  EXPECT_EQ(clock.wait_for(at(20), no), Turn::kGoOn);
  EXPECT_EQ(told.back().status, PlaybackStatus::kPlaying);
  // A second wish while on the way, farther back.
  clock.control({.seek_to = at(80)});
  EXPECT_EQ(clock.wait_for(at(30), no), Turn::kGoOn);
  clock.control({.seek_to = at(5)});
  EXPECT_EQ(clock.wait_for(at(31), no), Turn::kSeekBack);
  EXPECT_EQ(clock.goal(), at(5));
}

TEST_F(Replay, EndsAndBeginsAgain) {
  EXPECT_EQ(clock.wait_for(at(100), no), Turn::kGoOn);
  EXPECT_EQ(clock.wait_at_end(no), Turn::kStopped);
  EXPECT_EQ(told.back().status, PlaybackStatus::kEnded);
  clock.control({.play = false});
  EXPECT_EQ(clock.wait_at_end(no), Turn::kStopped);
  clock.control({.play = true, .speed = 0.0});
  EXPECT_EQ(clock.wait_at_end(yes), Turn::kSeekBack);
  EXPECT_EQ(clock.wait_for(at(0), no), Turn::kGoOn);
  EXPECT_EQ(told.back().status, PlaybackStatus::kPlaying);
  // Beyond the end is the end.
  clock.control({.seek_to = at(1e6)});
  EXPECT_EQ(clock.goal(), at(100));
  EXPECT_EQ(clock.wait_at_end(no), Turn::kStopped);
  clock.control({.seek_to = Stamp{-5}});
  EXPECT_EQ(clock.goal(), at(0));
}

TEST_F(Replay, WhoIsLateIsNotHurried) {
  clock.control({.speed = 10.0});
  EXPECT_EQ(clock.wait_for(at(0), yes), Turn::kGoOn);
  std::this_thread::sleep_for(std::chrono::milliseconds(400));  // of 4 s of the recording
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(clock.wait_for(at(1), yes), Turn::kGoOn);
  EXPECT_EQ(clock.wait_for(at(2), yes), Turn::kGoOn);
  EXPECT_GE(std::chrono::steady_clock::now() - start, std::chrono::milliseconds(90));
}

}  // namespace
}  // namespace loopstone
