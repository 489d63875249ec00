#include "loopstone/live/live_log.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

using std::chrono::milliseconds;

/// The time of now, and later each time it is asked.
double now_s() {
  static std::atomic<double> last_s{0.0};
  const double clock_s =
      std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  double before_s = last_s;
  double told_s = 0.0;
  do {
    told_s = std::max(clock_s, before_s + 1e-6);
  } while (!last_s.compare_exchange_weak(before_s, told_s));
  return told_s;
}

SensorMessage scan_at(double seconds, int lidar = 0) {
  return LaserScan{.stamp = Stamp::from_seconds(seconds), .lidar = lidar, .ranges_m = {1.0F}};
}
SensorMessage pose_at(double seconds) { return OdometryPose{Stamp::from_seconds(seconds), {}}; }

/// Tells what a function makes, until that makes nothing any more.
class Teller final : public LogReader {
 public:
  using Make = std::function<std::optional<SensorMessage>(int number)>;
  Teller(Make make, LogOptions how) : make_(std::move(make)), how_(std::move(how)) {}
  [[nodiscard]] std::optional<SensorMessage> next() override { return make_(number_++); }
  [[nodiscard]] ReadProgress progress() const override { return {}; }
  [[nodiscard]] std::string format() const override { return "teller"; }
  [[nodiscard]] RobotModel robot(RobotModel base) const override {
    base.lidars = {{.name = "first", .robot_T_lidar = {1.0, 0.0, 0.0}},
                   {.name = "second", .robot_T_lidar = {2.0, 0.0, 0.0}}};
    return base;
  }
  [[nodiscard]] const SkippedRecords& skipped() const override { return skipped_; }

 private:
  Make make_;
  LogOptions how_;
  int number_ = 0;
  SkippedRecords skipped_{};
};

LiveSource source(const std::string& name, Teller::Make make) {
  return {.name = name,
          .open = [make = std::move(make)](
                      const LogOptions& how) { return std::make_unique<Teller>(make, how); },
          .is_opened_again = false};
}
/// So many scans, ten a second by their stamps, as fast as they are taken.
LiveSource scans(const std::string& name, int count, double first_s) {
  return source(name, [=](int i) {
    return i < count ? std::optional(scan_at(first_s + 0.1 * i)) : std::nullopt;
  });
}

std::vector<SensorMessage> all_of(LiveLog& log) {
  std::vector<SensorMessage> messages;
  while (auto message = log.next()) messages.push_back(std::move(*message));
  return messages;
}

/// What was told of the sources.
struct News {
  std::vector<std::string> texts{};
  [[nodiscard]] LiveLogOptions options() {
    return {.on_news = [this](const LiveNews& news) {
      texts.push_back(news.source + ": " + news.text);
    }};
  }
  [[nodiscard]] std::ptrdiff_t count(const std::string& part) const {
    return std::ranges::count_if(
        texts, [&](const std::string& text) { return text.find(part) != text.npos; });
  }
};

TEST(LiveSources, GivesAllOfASourceInItsOrder) {
  LiveLog log({scans("laser", 5000, 100.0)}, {.most_waiting = 10});
  ASSERT_TRUE(log.wait_for_sources());
  const auto messages = all_of(log);
  ASSERT_EQ(messages.size(), 5000U) << "who waits loses nothing";
  for (std::size_t i = 0; i < messages.size(); ++i)
    EXPECT_EQ(stamp_of(messages[i]), Stamp::from_seconds(100.0 + 0.1 * static_cast<double>(i)));
}

TEST(LiveSources, LosesTheOldestScansOfWhatDoesNotWait) {
  News news;
  LiveLogOptions options = news.options();
  options.most_waiting = 50;
  LiveSource laser = scans("laser", 400, 100.0);
  laser.waits = false;
  LiveLog log({laser}, options);
  ASSERT_TRUE(log.wait_for_sources());
  std::this_thread::sleep_for(milliseconds(100));
  const auto messages = all_of(log);
  EXPECT_EQ(messages.size(), 50U);
  EXPECT_EQ(stamp_of(messages.back()), Stamp::from_seconds(139.9)) << "the newest is there";
  EXPECT_EQ(news.count("left out"), 1);
}

TEST(LiveSources, OpensASourceThatIsLostAgain) {
  News news;
  LiveLogOptions options = news.options();
  options.again_s = 0.01;
  const auto opened = std::make_shared<std::atomic<int>>(0);
  LiveSource laser;
  laser.name = "laser";
  laser.open = [opened](const LogOptions& how) -> std::unique_ptr<LogReader> {
    const int time = ++*opened;
    if (time == 2 || time == 3) throw DataError({"laser"}, "nobody is there");
    return std::make_unique<Teller>(
        [time](int i) -> std::optional<SensorMessage> {
          if (i == 10 && time == 1) throw DataError({"laser"}, "the cable is off");
          if (i == 10) return {};
          return scan_at(100.0 * time + 0.1 * i);
        },
        how);
  };
  LiveLog log({laser}, options);
  ASSERT_TRUE(log.wait_for_sources());
  int scans = 0;
  for (; scans < 20; ++scans) ASSERT_TRUE(log.next());
  EXPECT_EQ(news.count("laser: the cable is off; trying again"), 1);
  EXPECT_EQ(news.count("laser: nobody is there; trying again"), 1) << "the same is told once";
  EXPECT_GE(news.count("laser: is back"), 1);
}

TEST(LiveSources, WhatCanNeverBeOpenedIsThrown) {
  LiveSource wrong;
  wrong.name = "wrong";
  wrong.open = [](const LogOptions&) -> std::unique_ptr<LogReader> {
    throw UsageError("no such thing");
  };
  LiveLog log({wrong}, {});
  EXPECT_THROW((void)log.wait_for_sources(), UsageError);

  LiveSource gone = wrong;
  gone.is_opened_again = false;
  gone.open = [](const LogOptions&) -> std::unique_ptr<LogReader> {
    throw DataError({"gone"}, "there is no such file");
  };
  LiveLog other({gone}, {});
  EXPECT_THROW((void)other.wait_for_sources(), DataError);
}

TEST(LiveSources, TellsOfSilenceAndItsEnd) {
  News news;
  LiveLogOptions options = news.options();
  options.silence_s = 0.1;
  int idle = 0;
  options.idle = [&] { ++idle; };
  LiveLog log({source("laser",
                      [](int i) -> std::optional<SensorMessage> {
                        if (i == 5) std::this_thread::sleep_for(milliseconds(400));
                        if (i == 10) return {};
                        return scan_at(now_s());
                      })},
              options);
  ASSERT_TRUE(log.wait_for_sources());
  EXPECT_EQ(all_of(log).size(), 10U);
  EXPECT_EQ(news.count("laser: no scan for"), 1);
  EXPECT_EQ(news.count("laser: scans come again"), 1);
  EXPECT_GT(idle, 2);
}

TEST(LiveSources, WhoIsBehindDoesNotCallItSilence) {
  News news;
  LiveLogOptions options = news.options();
  options.silence_s = 0.1;
  LiveLog log({scans("laser", 40, 100.0)}, options);
  ASSERT_TRUE(log.wait_for_sources());
  int count = 0;
  while (log.next()) {
    if (++count % 10 == 0 && count < 40) std::this_thread::sleep_for(milliseconds(200));
  }
  EXPECT_EQ(count, 40);
  EXPECT_EQ(news.count("no scan for"), 0);
  EXPECT_EQ(news.count("scans come again"), 0);
}

TEST(LiveSources, NumbersLasersAndPlacesThemAsTheirSourcesSay) {
  std::atomic<bool> both_sent = false;
  LiveLog log({source("two",
                      [&](int i) -> std::optional<SensorMessage> {
                        if (i == 2) both_sent = true;
                        if (i == 20) return {};
                        return scan_at(now_s(), i % 2);
                      }),
               source("odometry",
                      [&](int i) -> std::optional<SensorMessage> {
                        if (i < 20) return pose_at(now_s());
                        // Lasers are counted once all sources have sent scans or are over.
                        while (!both_sent) std::this_thread::sleep_for(milliseconds(1));
                        return {};
                      }),
               source("second only",
                      [](int i) -> std::optional<SensorMessage> {
                        if (i == 20) return {};
                        return scan_at(now_s(), 1);
                      })},
              {});
  ASSERT_TRUE(log.wait_for_sources());
  const RobotModel robot = log.robot({});
  ASSERT_EQ(robot.lidars.size(), 3U);
  EXPECT_EQ(robot.lidars[0].name, "first");
  EXPECT_EQ(robot.lidars[1].name, "second");
  EXPECT_EQ(robot.lidars[2].name, "second");
  std::vector<int> seen(3);
  for (const SensorMessage& message : all_of(log)) {
    if (const auto* scan = std::get_if<LaserScan>(&message))
      ++seen.at(static_cast<std::size_t>(scan->lidar));
  }
  for (const int count : seen) EXPECT_GT(count, 0);
}

TEST(LiveSources, PutsClocksTogetherThatDiffer) {
  News news;
  LiveLog log({source("laser",
                      [](int i) -> std::optional<SensorMessage> {
                        if (i == 40) return {};
                        std::this_thread::sleep_for(milliseconds(5));
                        return scan_at(now_s());
                      }),
               source("wheels",
                      [](int i) -> std::optional<SensorMessage> {
                        if (i == 40) return {};
                        std::this_thread::sleep_for(milliseconds(5));
                        return pose_at(now_s() - 3600.0);
                      })},
              news.options());
  ASSERT_TRUE(log.wait_for_sources());
  std::optional<Stamp> scan;
  std::optional<Stamp> pose;
  for (const SensorMessage& message : all_of(log)) {
    (std::holds_alternative<LaserScan>(message) ? scan : pose) = stamp_of(message);
  }
  ASSERT_TRUE(scan && pose);
  EXPECT_NEAR((*scan - *pose).seconds(), 0.0, 1.0);
  EXPECT_EQ(news.count("its stamps are put on that"), 1);
}

TEST(LiveSources, EndsWhenNothingComesAndWhenToldTo) {
  const auto silent_after_ten = [](int i) -> std::optional<SensorMessage> {
    if (i == 10) std::this_thread::sleep_for(milliseconds(600));
    if (i == 11) return {};
    return scan_at(100.0 + 0.1 * i);
  };
  LiveLog log({source("laser", silent_after_ten)}, {.end_after_s = 0.1});
  ASSERT_TRUE(log.wait_for_sources());
  EXPECT_EQ(all_of(log).size(), 10U);

  std::atomic<bool> stop{false};
  LiveLogOptions options;
  options.reading.stop = [&] { return stop.load(); };
  LiveLog other({source("laser", silent_after_ten)}, options);
  ASSERT_TRUE(other.wait_for_sources());
  EXPECT_TRUE(other.next());
  stop = true;
  EXPECT_FALSE(other.next());
}

}  // namespace
}  // namespace loopstone
