#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "loopstone/devices/scanner.hpp"
#include "loopstone/geometry/angle.hpp"
#include "support/emulated_rplidar.hpp"
#include "support/segment_world.hpp"
#include "unit/devices/scanner_checks.hpp"

// Against an emulated scanner: no hardware was at hand.
namespace loopstone {
namespace {

using test::EmulatedRoom;
using test::EmulatedRplidar;
using test::error_of;
using test::RplidarModel;
using test::scans_of;
using testing::Contains;
using testing::HasSubstr;

const Pose2 kPose{2.5, 2.0, 0.3};
constexpr std::uint8_t kScan = 0x20;
constexpr std::uint8_t kReset = 0x40;
constexpr std::uint8_t kExpressScan = 0x82;

double range_in_room(double angle_rad) {
  static const test::Walls walls = test::furnished_room();
  const double heading = kPose.yaw + angle_rad;
  return test::cast_ray(walls, {kPose.x, kPose.y}, {std::cos(heading), std::sin(heading)});
}

EmulatedRoom room() {
  return {.range_m = [](double, double angle_rad) { return range_in_room(angle_rad); },
          .brightness = [](double angle_rad) { return std::cos(angle_rad) > 0.0 ? 47 : 15; }};
}

/// Turns of 20 ms, so that tests are quick.
RplidarModel quick_model() {
  return {.turns_a_second = 50.0, .spin_up_s = 0.01, .standard_us = 100.0, .express_us = 50.0};
}
RplidarModel quick_s1() {
  return {.number = 0x61,
          .turns_a_second = 50.0,
          .spin_up_s = 0.01,
          .standard_us = 100.0,
          .express_us = 50.0,
          .dense_us = 25.0,
          .range_max_m = 40.0};
}

/// Each range is one that the room has within half a beam (and half a degree of rounding).
void expect_room(const LaserScan& scan, double rounding_m) {
  std::size_t bad = 0;
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    if (std::isnan(scan.ranges_m[i])) {
      ++bad;
      continue;
    }
    double least_m = 1e9;
    double most_m = 0.0;
    constexpr int kSteps = 20;
    for (int k = -kSteps; k <= kSteps; ++k) {
      const double off_rad = scan.angle_increment_rad * 0.5 * k / kSteps;  // which is negative
      const double more_rad = (k > 0 ? -1.0 : 1.0) * 0.0005;  // 1/64 deg, and the walk's own steps
      const double range_m = range_in_room(scan.angle_rad(i) + off_rad + more_rad);
      least_m = std::min(least_m, range_m);
      most_m = std::max(most_m, range_m);
    }
    EXPECT_GE(scan.ranges_m[i], least_m - rounding_m - 0.002) << i;
    EXPECT_LE(scan.ranges_m[i], most_m + rounding_m + 0.002) << i;
  }
  EXPECT_LE(bad, scan.ranges_m.size() / 50);
}

TEST(RplidarScannerThread, TellsWhatItIs) {
  const EmulatedRplidar device(room(), quick_model());
  const auto scanner = open_scanner(device.address());
  const ScannerFacts& facts = scanner->facts();
  EXPECT_EQ(facts.vendor, "Slamtec");
  EXPECT_EQ(facts.model, "RPLIDAR A1M8");
  EXPECT_EQ(facts.serial, "A0A1A2A3A4A5A6A7A8A9AAABACADAEAF");
  EXPECT_EQ(facts.firmware, "1.29, hardware 7");
  EXPECT_EQ(facts.mode, "Express");
  EXPECT_NEAR(facts.beams, 380, 8);  // of 400 samples a turn
  EXPECT_DOUBLE_EQ(facts.angle_increment_rad, -2.0 * kPi / facts.beams);
  EXPECT_DOUBLE_EQ(facts.range_min_m, 0.15);
  EXPECT_DOUBLE_EQ(facts.range_max_m, 12.0);
  EXPECT_FALSE(facts.intensities);
}

TEST(RplidarScannerThread, RangesAreThoseOfTheRoomInEachMode) {
  const EmulatedRplidar a1(room(), quick_model());
  const EmulatedRplidar s1(room(), quick_s1());
  const std::pair<const EmulatedRplidar*, const char*> cases[] = {
      {&a1, "standard"}, {&a1, "express"}, {&s1, "Standard"}, {&s1, "dense"}, {&s1, "denseboost"}};
  for (const auto& [device, mode] : cases) {
    SCOPED_TRACE(mode);
    const auto scanner = open_scanner(device->address("?mode=" + std::string(mode)));
    for (const LaserScan& scan : scans_of(*scanner, 3)) {
      EXPECT_EQ(scan.ranges_m.size(), static_cast<std::size_t>(scanner->facts().beams));
      EXPECT_EQ(scan.angle_min_rad, 0.0);
      expect_room(scan, 0.0005);
    }
    EXPECT_EQ(scanner->skipped().broken, 0);
  }
}

TEST(RplidarScannerThread, QualityIsTheIntensityOfStandardScans) {
  const EmulatedRplidar device(room(), quick_model());
  const auto scanner = open_scanner(device.address(), {.intensities = true});
  EXPECT_EQ(scanner->facts().mode, "Standard");
  EXPECT_TRUE(scanner->facts().intensities);
  const LaserScan scan = scanner->next().value();
  ASSERT_EQ(scan.intensities.size(), scan.ranges_m.size());
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const double front = std::cos(scan.angle_rad(i));
    if (std::abs(front) < 0.05 || std::isnan(scan.ranges_m[i])) continue;
    EXPECT_EQ(scan.intensities[i], front > 0.0 ? 47.0F : 15.0F) << i;
  }
}

TEST(RplidarScannerThread, WhatMeetsNothingIsInfinite) {
  EmulatedRoom half_open{
      .range_m = [](double, double angle_rad) { return std::sin(angle_rad) > 0.0 ? 50.0 : 3.0; },
      .brightness = [](double) { return 47; }};
  const EmulatedRplidar device(half_open, quick_model());
  const LaserScan scan = open_scanner(device.address())->next().value();
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const double left = std::sin(scan.angle_rad(i));
    if (std::abs(left) < 0.05 || std::isnan(scan.ranges_m[i])) continue;
    EXPECT_EQ(std::isinf(scan.ranges_m[i]), left > 0.0) << i;
    if (left < 0.0) {
      EXPECT_EQ(scan.ranges_m[i], 3.0F) << i;
    }
  }
}

TEST(RplidarScannerThread, OlderFirmwareHasLess) {
  RplidarModel model = quick_model();
  model.firmware_minor = 20;
  const EmulatedRplidar without_modes(room(), model);
  EXPECT_EQ(open_scanner(without_modes.address(), {.silence_s = 1.0})->facts().mode, "Express");
  model.firmware_minor = 15;
  const EmulatedRplidar without_express(room(), model);
  const auto scanner = open_scanner(without_express.address(), {.silence_s = 1.0});
  EXPECT_EQ(scanner->facts().mode, "Standard");
  expect_room(scanner->next().value(), 0.0005);
}

TEST(RplidarScannerThread, TheMotorOfAnA3IsStartedAndStopped) {
  RplidarModel model = quick_model();
  model.number = 0x31;
  model.has_board = true;
  const EmulatedRplidar device(room(), model);
  auto scanner = open_scanner(device.address("?baud=256000"));
  EXPECT_EQ(device.motor_pwm(), 660);
  EXPECT_EQ(scanner->facts().model, "RPLIDAR A3M1");
  EXPECT_TRUE(scanner->next());
  scanner.reset();
  // Opening it again stops it first, after what was sent before.
  scanner = open_scanner(device.address("?baud=256000"));
  EXPECT_EQ(std::ranges::count(device.commands(), 0xF0), 3);
}

TEST(RplidarScannerThread, StampsAreOfTheBeginningOfTheTurn) {
  RplidarModel model;
  model.turns_a_second = 20.0;
  model.standard_us = 490.0;
  model.clock_rate = 0.98;  // a measurement takes 500 us, other than the device says
  const EmulatedRplidar device(room(), model);
  // The emulator looks every 2 ms whether something is due, unless the machine is busy.
  constexpr double kGoodMs = 5.0;
  double best_ms = 1e9;
  for (int i = 0; i < 10 && best_ms > kGoodMs; ++i) {
    const auto scanner = open_scanner(device.address("?mode=standard&baud=1000000"));
    std::vector<double> errors_ms;
    for (const LaserScan& scan : scans_of(*scanner, 11)) {
      double error_ms = 1e9;
      for (const std::int64_t truth_ns : device.turns_ns()) {
        const auto off_ns = static_cast<double>(scan.stamp.nanoseconds - truth_ns);
        error_ms = std::min(error_ms, std::abs(off_ns) * 1e-6);
      }
      errors_ms.push_back(error_ms);
    }
    std::sort(errors_ms.begin(), errors_ms.end());
    best_ms = std::min(best_ms, errors_ms[5]);
    if (best_ms > kGoodMs) continue;
    EXPECT_NEAR(1.0 / scanner->facts().rate_hz, 0.05, 0.0025);
  }
  EXPECT_LT(best_ms, kGoodMs);
}

TEST(RplidarScannerThread, TheGridStaysThoughTheMotorStillGainsSpeed) {
  EmulatedRoom round{.range_m = [](double, double) { return 2.0; },
                     .brightness = [](double) { return 47; }};
  RplidarModel model = quick_model();
  model.spin_up_s = 0.1;
  const EmulatedRplidar device(round, model);
  const auto scanner = open_scanner(device.address());
  for (const LaserScan& scan : scans_of(*scanner, 10)) {
    EXPECT_EQ(scan.ranges_m.size(), static_cast<std::size_t>(scanner->facts().beams));
    EXPECT_DOUBLE_EQ(scan.angle_increment_rad, scanner->facts().angle_increment_rad);
  }
}

TEST(RplidarScannerThread, IsHeardThoughTheMachineIsTooSlowForIt) {
  // A turn of 20 ms takes 40 ms to be emulated.
  const auto look = [samples = 0](double, double) mutable {
    if (++samples % 100 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return 2.0;
  };
  const EmulatedRplidar device({.range_m = look}, quick_model());
  for (int i = 0; i < 2; ++i) EXPECT_EQ(scans_of(*open_scanner(device.address()), 2).size(), 2U);
}

TEST(RplidarTroubleThread, DamageCostsTheTurnThatItIsInAndIsCounted) {
  // Opening takes half of a turn, a few to learn from; damage comes after.
  const auto spoil = [](std::int64_t packet, std::string bytes) {
    if (packet == 3210) bytes.erase(2, 1);
    if (packet == 4010) bytes[0] = static_cast<char>(bytes[0] ^ 1);
    return bytes;
  };
  // How many turns a gap took is known by the time alone, and a busy machine takes longer.
  std::int64_t least_lost = std::numeric_limits<std::int64_t>::max();
  for (int i = 0; i < 10 && least_lost > 0; ++i) {
    const EmulatedRplidar device(room(), quick_model(), {.packet = spoil});
    const auto scanner = open_scanner(device.address("?mode=standard"));
    std::vector<LaserScan> scans;
    while (scanner->skipped().broken < 2 && scans.size() < 100)
      scans.push_back(scanner->next().value());
    for (const LaserScan& scan : scans_of(*scanner, 3)) scans.push_back(scan);
    EXPECT_EQ(scanner->skipped().broken, 2);
    least_lost = std::min(least_lost, scanner->skipped().lost);
    for (const LaserScan& scan : scans) expect_room(scan, 0.0005);
  }
  EXPECT_EQ(least_lost, 0);
}

TEST(RplidarTroubleThread, DamagedCapsulesAreLeftOut) {
  const auto spoil = [](std::int64_t packet, std::string bytes) {
    if (packet == 150) bytes[40] = static_cast<char>(bytes[40] ^ 4);
    if (packet == 201) bytes.erase(10, 4);
    if (packet == 251) bytes.clear();
    return bytes;
  };
  const EmulatedRplidar device(room(), quick_model(), {.packet = spoil});
  const auto scanner = open_scanner(device.address());
  std::vector<LaserScan> scans;
  while (scanner->skipped().broken < 3 && scans.size() < 100)
    scans.push_back(scanner->next().value());
  EXPECT_EQ(scanner->skipped().broken, 3);
  for (const LaserScan& scan : scans) expect_room(scan, 0.0005);
}

TEST(RplidarTroubleThread, OpensADeviceThatIsStillSending) {
  const EmulatedRplidar device(room(), quick_model(), {.is_sending = true});
  EXPECT_TRUE(device.is_measuring());
  const auto scanner = open_scanner(device.address());
  expect_room(scanner->next().value(), 0.0005);
}

TEST(RplidarTroubleThread, AsksAgainWhenAnAnswerIsDamaged) {
  const auto asked = std::make_shared<std::atomic<int>>(0);
  const EmulatedRplidar device(room(), quick_model(),
                               {.answer = [asked](std::uint8_t command, std::string bytes) {
                                 if (command == 0x50 && (*asked)++ == 0) bytes.erase(3, 2);
                                 return "\xA5\x5A noise" + bytes;
                               }});
  EXPECT_EQ(open_scanner(device.address(), {.silence_s = 1.0})->facts().model, "RPLIDAR A1M8");
  EXPECT_EQ(*asked, 2);
}

TEST(RplidarTroubleThread, AnswersThatComeTwiceAreTakenOnce) {
  // As when the first one was so late that it was asked for again.
  const auto say_twice = [last = std::string()](std::uint8_t, const std::string& bytes) mutable {
    return std::exchange(last, bytes) + bytes;
  };
  const EmulatedRplidar device(room(), quick_s1(), {.answer = say_twice});
  const auto scanner = open_scanner(device.address());
  EXPECT_EQ(scanner->facts().mode, "DenseBoost");
  EXPECT_DOUBLE_EQ(scanner->facts().range_max_m, 40.0);
}

TEST(RplidarTroubleThread, ADeviceThatProtectsItselfIsResetOnce) {
  const EmulatedRplidar device(room(), quick_model(), {.has_failed = true});
  EXPECT_TRUE(open_scanner(device.address())->next());
  EXPECT_THAT(device.commands(), Contains(kReset));
  const EmulatedRplidar broken(room(), quick_model(), {.fails_for_good = true});
  EXPECT_THAT(error_of([&] { (void)open_scanner(broken.address()); }),
              HasSubstr("protects itself with error 0x0012; is its motor free?"));
}

TEST(RplidarScannerThread, ModesAreChosenByName) {
  const EmulatedRplidar device(room(), quick_model());
  (void)open_scanner(device.address("?mode=standard"));
  EXPECT_THAT(device.commands(), Contains(kScan));
  EXPECT_THAT(device.commands(), testing::Not(Contains(kExpressScan)));
  EXPECT_THAT(error_of([&] { (void)open_scanner(device.address("?mode=dense")); }),
              HasSubstr("has no mode 'dense' that is understood here; it has Standard, Express"));
}

TEST(RplidarTroubleThread, SilenceIsAnError) {
  const EmulatedRplidar device(room(), quick_model(), {.is_silent_after_s = 0.8});
  const auto scanner = open_scanner(device.address(), {.silence_s = 0.5});
  EXPECT_THAT(error_of([&] {
                for (int i = 0; i < 1000; ++i) (void)scanner->next();
              }),
              HasSubstr("has been silent for 0.5 s"));
}

TEST(RplidarTroubleThread, TurnsOfAnotherLengthForGoodAreAnError) {
  // From the eleventh on only every third beginning of a turn is told.
  const auto tell_few = [turns = 0](std::int64_t, std::string bytes) mutable {
    const bool begins = (bytes[0] & 1) == 1;
    if (begins && ++turns > 10 && turns % 3 != 0) bytes[0] = static_cast<char>(bytes[0] ^ 3);
    return bytes;
  };
  const EmulatedRplidar device(room(), quick_model(), {.packet = tell_few});
  const auto scanner = open_scanner(device.address("?mode=standard"), {.silence_s = 1.0});
  EXPECT_THAT(error_of([&] {
                for (int i = 0; i < 20; ++i) (void)scanner->next();
              }),
              HasSubstr("turns much faster or slower than when it was opened"));
  EXPECT_GE(scanner->skipped().broken, 10);
}

TEST(RplidarTroubleThread, OtherDevicesAreTold) {
  const EmulatedRplidar mute(room(), quick_model(),
                             {.answer = [](std::uint8_t, const std::string&) { return ""; }});
  EXPECT_THAT(error_of([&] { (void)open_scanner(mute.address(), {.silence_s = 0.2}); }),
              HasSubstr("does not say what it is"));
}

TEST(RplidarTroubleThread, IsOpenedAgainAfterItWasUnplugged) {
  const EmulatedRplidar device(room(), quick_model(), {.is_unplugged_after_s = 0.8});
  auto scanner = open_scanner(device.address());
  EXPECT_THAT(error_of([&] {
                for (int i = 0; i < 1000; ++i) (void)scanner->next();
              }),
              HasSubstr("is gone; was it unplugged?"));
  scanner.reset();
  scanner = open_scanner(device.address());
  expect_room(scanner->next().value(), 0.0005);
}

TEST(RplidarTroubleThread, WhoeverStopsGetsNothing) {
  const EmulatedRplidar device(room(), quick_model());
  const auto stopped = std::make_shared<bool>(false);
  auto scanner = open_scanner(device.address(), {.stop = [stopped] { return *stopped; }});
  EXPECT_TRUE(scanner->next());
  *stopped = true;
  // What has come already may be a scan or two.
  int more = 0;
  while (scanner->next() && more < 100) ++more;
  EXPECT_LT(more, 100);
  scanner.reset();
  EXPECT_EQ(open_scanner(device.address(), {.stop = [] { return true; }}), nullptr);
}

TEST(RplidarScannerThread, SpeaksOverANetworkToo) {
  const EmulatedRplidar device(room(), quick_model(), {}, test::EmulatedLine::Kind::kTcp);
  const auto scanner = open_scanner(device.address(""));
  expect_room(scanner->next().value(), 0.0005);
}

}  // namespace
}  // namespace loopstone
