#include "loopstone/simulation/realism.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "loopstone/base/error.hpp"
#include "support/simulated_log.hpp"

namespace loopstone {
namespace {

using test::simulate_log;
using test::SimulatedLog;

SimulationOptions with(const std::string& effects, double duration_s = 8.0) {
  SimulationOptions options{.duration_s = duration_s};
  options.laser.beams = 91;
  options.laser.rate_hz = 5.0;
  choose_realism(options.realism, effects);
  return options;
}

bool has(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

TEST(Realism, NothingIsOnUntilItIsChosen) {
  EXPECT_TRUE(realism_names(Realism{}).empty());
  EXPECT_GE(realism_names().size(), 25U);
  const auto names = realism_names();
  EXPECT_EQ(std::set(names.begin(), names.end()).size(), names.size());
}

TEST(Realism, ListsChooseExactlyWhatTheyName) {
  Realism realism;
  choose_realism(realism, "follower,blocked");
  EXPECT_EQ(realism_names(realism), (std::vector<std::string>{"blocked", "follower"}));
  choose_realism(realism, "glass");
  EXPECT_EQ(realism_names(realism), std::vector<std::string>{"glass"});
  choose_realism(realism, "all");
  EXPECT_EQ(realism_names(realism), realism_names());
  choose_realism(realism, "usual");
  EXPECT_EQ(realism_names(realism).size(), usual_realism().size());
  for (const std::string& name : usual_realism()) EXPECT_TRUE(has(realism_names(realism), name));
  EXPECT_FALSE(has(usual_realism(), "blocked"));
  choose_realism(realism, "usual,blocked");
  EXPECT_EQ(realism_names(realism).size(), usual_realism().size() + 1);
  choose_realism(realism, "none");
  EXPECT_TRUE(realism_names(realism).empty());
}

TEST(Realism, AnUnknownNameListsTheKnownOnes) {
  Realism realism;
  try {
    choose_realism(realism, "blocked,foggy");
    FAIL() << "accepted";
  } catch (const UsageError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("foggy"), std::string::npos) << text;
    EXPECT_NE(text.find("upside_down"), std::string::npos) << text;
    EXPECT_NE(text.find("usual"), std::string::npos) << text;
  }
}

TEST(Realism, EachEffectHasItsOwnNumbers) {
  EXPECT_EQ(realism_stream(7, "blocked")(), realism_stream(7, "blocked")());
  EXPECT_NE(realism_stream(7, "blocked")(), realism_stream(7, "dirty")());
  EXPECT_NE(realism_stream(7, "blocked")(), realism_stream(8, "blocked")());
}

TEST(Realism, OneEffectMoreLeavesTheOthersDrawsAlone) {
  const SimulatedLog one = simulate_log("office", 5, with("mount,gyro,stamps"));
  const SimulatedLog more =
      simulate_log("office", 5, with("mount,gyro,stamps,range,wheels,mixed,walkers"));
  const auto value_of = [](const SimulatedLog& log, const std::string& effect,
                           const std::string& name) {
    for (const RealismFact& fact : log.summary.realism.facts) {
      if (fact.effect == effect && fact.name == name) return fact.value;
    }
    ADD_FAILURE() << effect << " " << name << " is not told";
    return 0.0;
  };
  for (const char* name : {"robot_T_lidar_x_m", "robot_T_lidar_y_m", "robot_T_lidar_yaw_rad"})
    EXPECT_EQ(value_of(one, "mount", name), value_of(more, "mount", name));
  EXPECT_EQ(value_of(one, "gyro", "scale"), value_of(more, "gyro", "scale"));
  ASSERT_EQ(one.messages.size(), more.messages.size());
  for (std::size_t i = 0; i < one.messages.size(); ++i) {
    ASSERT_EQ(stamp_of(one.messages[i]), stamp_of(more.messages[i]));
    const auto* imu = std::get_if<ImuSample>(&one.messages[i]);
    if (imu == nullptr) continue;
    const auto& other = std::get<ImuSample>(more.messages[i]);
    ASSERT_EQ(imu->angular_velocity_rad_s, other.angular_velocity_rad_s);
  }
}

TEST(Realism, EveryEffectByItselfAndAllAtOnceCanBeSimulated) {
  std::vector<std::string> lists = realism_names();
  lists.emplace_back("usual");
  lists.emplace_back("all");
  for (const std::string& list : lists) {
    SimulationOptions options = with(list, 4.0);
    options.laser.beams = 31;
    const SimulatedLog log = simulate_log("rooms", 2, options);
    EXPECT_GT(log.scans().size(), 8U) << list;
    EXPECT_EQ(log.truth.size(), log.scans().size()) << list;
  }
}

TEST(Realism, SpoilsEndWithTheLog) {
  SimulationOptions options = with("blocked,crowd,carried,follower", 8.0);
  options.realism.blocked.at_s = 5.0;
  const auto spoils = simulate_log("rooms", 3, options).summary.realism.spoils;
  ASSERT_EQ(spoils.size(), 2U) << "nobody is carried or crowded after the end";
  EXPECT_EQ(spoils[0].effect, "blocked");
  EXPECT_NEAR(spoils[0].to_s, 8.0, 0.021);
  EXPECT_EQ(spoils[1].effect, "follower");
}

TEST(Realism, SameSeedSameBits) {
  const auto a = simulate_log("rooms", 3, with("all", 6.0)).scans();
  const auto b = simulate_log("rooms", 3, with("all", 6.0)).scans();
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].stamp, b[i].stamp);
    for (std::size_t beam = 0; beam < a[i].ranges_m.size(); ++beam) {
      const float range = a[i].ranges_m[beam];
      EXPECT_TRUE(range == b[i].ranges_m[beam] ||
                  (std::isnan(range) && std::isnan(b[i].ranges_m[beam])));
    }
  }
}

}  // namespace
}  // namespace loopstone
