// Which of a recorded message's two times is believed.

#include "formats/topic_clock.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace loopstone {
namespace {

using Source = TopicClock::Source;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kStart = 1.7e9;

Stamp at(double seconds) {
  return Stamp{static_cast<std::int64_t>(kStart) * 1'000'000'000} + Duration::from_seconds(seconds);
}

/// Facts of messages at a rate; how their own stamps and the recorder's follow from the true time.
struct Clocks {
  std::function<std::optional<Stamp>(double)> own = [](double t) { return std::optional(at(t)); };
  std::function<Stamp(double)> recorded = [](double t) {
    return at(t + 0.005 + 0.003 * std::sin(91.0 * t));
  };
};
StampFacts facts_of(const Clocks& clocks, double rate_hz = 10.0, int count = 200,
                    double begin_s = 0.0) {
  StampFacts facts;
  for (int i = 0; i < count; ++i) {
    const double t = begin_s + i / rate_hz;
    facts.add(clocks.own(t), clocks.recorded(t));
  }
  return facts;
}

ClockChoice chosen(const StampFacts& first, StampUse use = StampUse::kAuto) {
  return choose_clocks({{"/scan", &first}}, use);
}
ClockChoice chosen(const StampFacts& first, const StampFacts& second,
                   StampUse use = StampUse::kAuto) {
  return choose_clocks({{"/scan", &first}, {"/imu", &second}}, use);
}

TEST(TopicClock, GoodStampsAreBelieved) {
  const StampFacts facts = facts_of({});
  EXPECT_EQ(facts.fault_of_own(), "");
  EXPECT_EQ(facts.fault_of_record(), "");
  EXPECT_NEAR(facts.period_s(), 0.1, 1e-6);
  EXPECT_NEAR(facts.offset().seconds(), 0.005, 0.003);
  EXPECT_LT(facts.scatter().seconds(), 0.006);
  const ClockChoice choice = chosen(facts, facts);
  EXPECT_THAT(choice.notes, IsEmpty());
  EXPECT_THAT(choice.warnings, IsEmpty());
  ASSERT_EQ(choice.clocks.size(), 2u);
  EXPECT_EQ(choice.clocks[1].source, Source::kOwn);
  EXPECT_EQ(choice.clocks[1].time(at(3), at(5)), at(3));
}

TEST(TopicClock, AConstantOffsetIsANote) {
  const StampFacts facts = facts_of({.recorded = [](double t) { return at(t - 3600.0); }});
  const ClockChoice choice = chosen(facts);
  EXPECT_EQ(choice.clocks[0].source, Source::kOwn);
  EXPECT_EQ(choice.clocks[0].shift, Duration{});
  EXPECT_THAT(choice.notes, ElementsAre(HasSubstr("-3600.00 s")));
  EXPECT_THAT(choice.warnings, IsEmpty());
}

struct Fault {
  const char* name;
  std::function<std::optional<Stamp>(double)> own;
  const char* said;
};
class FaultyStamps : public testing::TestWithParam<Fault> {};

TEST_P(FaultyStamps, GiveWayToTheRecorders) {
  const StampFacts facts = facts_of({.own = GetParam().own});
  EXPECT_THAT(facts.fault_of_own(), HasSubstr(GetParam().said));
  const ClockChoice choice = chosen(facts);
  EXPECT_EQ(choice.clocks[0].source, Source::kRecord);
  EXPECT_EQ(choice.clocks[0].time(Stamp{}, at(5)), at(5));
  EXPECT_THAT(choice.warnings, ElementsAre(HasSubstr("/scan: its stamps ")));
  EXPECT_NEAR(facts.period_s(), 0.1, 0.01) << "by the clock that is usable";
}

INSTANTIATE_TEST_SUITE_P(
    All, FaultyStamps,
    testing::Values(
        Fault{"zero", [](double) { return Stamp{}; }, "zero"},
        Fault{"constant", [](double) { return at(1); }, "all the same"},
        Fault{"missing", [](double) { return std::optional<Stamp>(); }, "missing"},
        Fault{"backwards", [](double s) { return at(-s); }, "run -1 times"},
        Fault{"milliseconds", [](double s) { return Stamp::from_seconds(1e3 * s + 5); },
              "run 1e+03"},
        Fault{"kiloseconds", [](double s) { return Stamp::from_seconds(1e-3 * s + 5); },
              "run 0.001"},
        Fault{"half_speed", [](double s) { return at(std::floor(2.5 * s)); }, "stand still"},
        Fault{"to_and_fro",
              [](double s) { return at(s + (std::lround(10 * s) % 3 == 0 ? 100.0 : 0.0)); },
              "to and fro"}),
    [](const auto& given) { return given.param.name; });

TEST(TopicClock, ASimulationsClockIsBelievedAndNoOffsetIsMadeOfItsSpeed) {
  // Gazebo at 0.9 of real time, recorded by the computer's clock; the IMU is ten times as fast.
  for (const double speed : {0.3, 0.9, 1.7, 10.0}) {
    const Clocks clocks{.own = [=](double t) { return Stamp::from_seconds(50.0 + speed * t); }};
    const StampFacts laser = facts_of(clocks, 10.0, 300);
    const StampFacts imu = facts_of(clocks, 100.0, 400);
    const ClockChoice choice = chosen(laser, imu);
    EXPECT_EQ(choice.clocks[0].source, Source::kOwn) << speed;
    EXPECT_EQ(choice.clocks[1].source, Source::kOwn) << speed;
    EXPECT_EQ(choice.clocks[1].shift, Duration{}) << speed;
    EXPECT_THAT(choice.warnings, IsEmpty()) << speed;
    EXPECT_THAT(choice.notes, testing::Contains(HasSubstr("times as fast"))) << speed;
  }
}

TEST(TopicClock, InASimulationAClockThatIsOffIsStillFound) {
  const Clocks laser{.own = [](double t) { return Stamp::from_seconds(50.0 + 0.5 * t); }};
  const Clocks imu{.own = [](double t) { return Stamp::from_seconds(47.0 + 0.5 * t); }};
  const StampFacts first = facts_of(laser, 10.0, 300);
  const ClockChoice choice = chosen(first, facts_of(imu, 100.0, 400));
  EXPECT_NEAR(choice.clocks[1].shift.seconds(), 3.0, 0.02);
  // A topic that begins only after what was seen of the laser can't be compared.
  const ClockChoice late = chosen(first, facts_of(imu, 100.0, 400, 100.0));
  EXPECT_EQ(late.clocks[1].shift, Duration{});
  EXPECT_THAT(late.warnings, IsEmpty());
}

TEST(TopicClock, ASecondClockIsBroughtToTheFirst) {
  const StampFacts laser = facts_of({});
  for (const double off_s : {3.0, -3.0, 0.3, 1e6}) {
    const StampFacts imu = facts_of({.own = [=](double t) { return at(t + off_s); }}, 100.0);
    const ClockChoice choice = chosen(laser, imu);
    EXPECT_EQ(choice.clocks[1].source, Source::kOwn);
    EXPECT_NEAR(choice.clocks[1].shift.seconds(), -off_s, 0.01);
    const Duration error = choice.clocks[1].time(at(7 + off_s), at(7.01)) - at(7);
    EXPECT_LT(std::abs(error.seconds()), 0.01) << "events agree";
    EXPECT_THAT(choice.warnings, ElementsAre(HasSubstr("/imu: its clock is")));
  }
  const StampFacts near = facts_of({.own = [](double t) { return at(t + 0.1); }}, 100.0);
  EXPECT_THAT(chosen(laser, near).warnings, IsEmpty());
  EXPECT_EQ(chosen(laser, near).clocks[1].shift, Duration{});
}

TEST(TopicClock, ATopicWithoutStampsFollowsTheRecorderOnTheLaserClock) {
  const StampFacts laser = facts_of({.own = [](double t) { return at(t - 40.0); }});
  for (const bool zero : {false, true}) {
    const StampFacts imu =
        facts_of({.own = [=](double) { return zero ? std::optional(Stamp{}) : std::nullopt; }});
    const ClockChoice choice = chosen(laser, imu);
    EXPECT_EQ(choice.clocks[1].source, Source::kRecord);
    const Duration error = choice.clocks[1].time(Stamp{}, at(7.005)) - at(7 - 40.0);
    EXPECT_LT(std::abs(error.seconds()), 0.01);
    EXPECT_EQ(choice.warnings.size(), zero ? 1u : 0u) << "a type without a header is no fault";
  }
}

TEST(TopicClock, WhenTheLaserGoesByTheRecorderSoDoOthersClocks) {
  const StampFacts laser = facts_of({.own = [](double) { return Stamp{}; }});
  const StampFacts imu = facts_of({.own = [](double t) { return at(t + 100.0); }}, 100.0);
  const ClockChoice choice = chosen(laser, imu);
  EXPECT_EQ(choice.clocks[0].source, Source::kRecord);
  EXPECT_NEAR(choice.clocks[1].shift.seconds(), -100.0, 0.02);
  const StampFacts slow = facts_of({.own = [](double t) { return at(0.5 * t); }}, 100.0);
  EXPECT_EQ(chosen(laser, slow).clocks[1].source, Source::kRecord);
}

TEST(TopicClock, WithoutAnyClockTheOrderCounts) {
  const Clocks none{.own = [](double) { return Stamp{}; },
                    .recorded = [](double) { return at(0); }};
  const StampFacts facts = facts_of(none);
  EXPECT_EQ(facts.period_s(), 0.0);
  const ClockChoice choice = chosen(facts, facts);
  for (const TopicClock& clock : choice.clocks) {
    EXPECT_EQ(clock.source, Source::kOrder);
    EXPECT_DOUBLE_EQ(clock.period_s, 0.1);
  }
  EXPECT_THAT(choice.warnings, ElementsAre(HasSubstr("in their order, 0.100 s")));
}

TEST(TopicClock, TheUserDecides) {
  const StampFacts bad = facts_of({.own = [](double) { return Stamp{}; }}, 20.0);
  const StampFacts good = facts_of({}, 20.0);
  EXPECT_EQ(chosen(bad, bad, StampUse::kHeader).clocks[1].source, Source::kOwn);
  EXPECT_EQ(chosen(bad, StampUse::kHeader).clocks[0].source, Source::kOwn);
  const ClockChoice record = chosen(good, good, StampUse::kRecord);
  EXPECT_EQ(record.clocks[0].source, Source::kRecord);
  EXPECT_EQ(record.clocks[1].source, Source::kRecord);
  EXPECT_EQ(record.clocks[1].shift, Duration{});
  const ClockChoice order = chosen(good, good, StampUse::kOrder);
  EXPECT_EQ(order.clocks[1].source, Source::kOrder);
  EXPECT_NEAR(order.clocks[0].period_s, 0.05, 1e-6);
  for (const auto use : {StampUse::kHeader, StampUse::kRecord, StampUse::kOrder}) {
    EXPECT_THAT(chosen(bad, use).warnings, IsEmpty()) << "what was asked for is no surprise";
  }
}

TEST(TopicClock, NothingKnownIsNoHarm) {
  EXPECT_THAT(choose_clocks({}, StampUse::kAuto).clocks, IsEmpty());
  const StampFacts none;
  EXPECT_NE(none.fault_of_own(), "");
  EXPECT_EQ(none.offset(), Duration{});
  EXPECT_EQ(none.scatter(), Duration{});
  const StampFacts one = facts_of({}, 10.0, 1);
  EXPECT_EQ(one.fault_of_own(), "");
  EXPECT_EQ(chosen(one, none).clocks[1].source, Source::kRecord);
}

TEST(ClockDrift, IsMeasuredFromTheBeginningToTheEnd) {
  ClockDrift drift;
  for (int i = 0; i < 399; ++i) drift.add(at(0.1 * i), at(0.1 * i * 1.0001 + 0.01));
  EXPECT_FALSE(drift.drift_s()) << "too short";
  for (int i = 399; i < 20'000; ++i) {
    const double late_s = i % 7 == 0 ? 0.5 : 0.0;
    drift.add(at(0.1 * i), at(0.1 * i * 1.0001 + 0.01 + late_s));
  }
  ASSERT_TRUE(drift.drift_s());
  EXPECT_NEAR(*drift.drift_s(), 0.2, 0.005);
}

}  // namespace
}  // namespace loopstone
