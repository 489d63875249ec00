#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <memory>
#include <thread>
#include <vector>

#include "devices/scip_text.hpp"
#include "loopstone/devices/scanner.hpp"
#include "loopstone/geometry/angle.hpp"
#include "support/emulated_scip.hpp"
#include "support/segment_world.hpp"
#include "support/web_client.hpp"
#include "unit/devices/scanner_checks.hpp"

// Against an emulated scanner: no hardware was at hand.
namespace loopstone {
namespace {

using test::EmulatedRoom;
using test::EmulatedScip;
using test::error_of;
using test::scans_of;
using test::ScipModel;
using test::ScipTroubles;
using testing::Contains;
using testing::HasSubstr;

const Pose2 kPose{2.5, 2.0, 0.3};

double range_in_room(double angle_rad) {
  static const test::Walls walls = test::furnished_room();
  const double heading = kPose.yaw + angle_rad;
  return test::cast_ray(walls, {kPose.x, kPose.y}, {std::cos(heading), std::sin(heading)});
}

EmulatedRoom room() {
  return {
      .range_m = [](double, double angle_rad) { return range_in_room(angle_rad); },
      .brightness = [](double angle_rad) { return 3000 + static_cast<int>(100.0 * angle_rad); }};
}

/// A small URG-04LX: 10 turns a second would make tests slow.
ScipModel small_model() {
  return {.name = "URG-04LX",
          .shortest_mm = 20,
          .longest_mm = 4095,
          .steps_of_turn = 1024,
          .first_step = 44,
          .last_step = 725,
          .front_step = 384,
          .turns_a_minute = 3000,
          .nothing = 0,
          .knows_intensities = false};
}

TEST(ScipScannerThread, TellsWhatItIs) {
  const EmulatedScip device(room());
  const auto scanner = open_scanner(device.address());
  const ScannerFacts& facts = scanner->facts();
  EXPECT_EQ(facts.address, device.address());
  EXPECT_EQ(facts.vendor, "Hokuyo Automatic Co.,Ltd.");
  EXPECT_EQ(facts.model, "SOKUIKI Sensor UTM-30LX");
  EXPECT_EQ(facts.serial, "H1234567");
  EXPECT_EQ(facts.firmware, "1.18.01(25/Jul./2011)");
  EXPECT_EQ(facts.mode, "MD by SCIP 2.0");
  EXPECT_EQ(facts.beams, 1081);
  EXPECT_DOUBLE_EQ(facts.angle_min_rad, -0.75 * kPi);
  EXPECT_DOUBLE_EQ(facts.angle_increment_rad, kPi / 720.0);
  EXPECT_DOUBLE_EQ(facts.range_min_m, 0.023);
  EXPECT_DOUBLE_EQ(facts.range_max_m, 60.0);
  EXPECT_DOUBLE_EQ(facts.rate_hz, 40.0);
  EXPECT_FALSE(facts.intensities);
}

TEST(ScipScannerThread, LaserIsOffBeforeAndAfter) {
  const EmulatedScip device(room());
  const ScannerOptions patient{.silence_s = 60.0};  // nothing is asked twice
  EXPECT_FALSE(device.laser_is_on());
  auto scanner = open_scanner(device.address(), patient);
  (void)scanner->next();
  EXPECT_TRUE(device.laser_is_on());
  scanner.reset();
  // QT is on its way; whoever opens it next hears about it.
  scanner = open_scanner(device.address(), patient);
  const auto commands = device.commands();
  EXPECT_EQ(commands.front(), "QT");
  EXPECT_EQ(std::count(commands.begin(), commands.end(), "QT"), 3);
}

TEST(ScipScannerThread, RangesAreThoseOfTheRoom) {
  const EmulatedScip device(room());
  const auto scanner = open_scanner(device.address());
  for (const LaserScan& scan : scans_of(*scanner, 3)) {
    ASSERT_EQ(scan.ranges_m.size(), 1081U);
    EXPECT_DOUBLE_EQ(scan.angle_min_rad, scanner->facts().angle_min_rad);
    EXPECT_DOUBLE_EQ(scan.angle_increment_rad, scanner->facts().angle_increment_rad);
    for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
      const double range_m = range_in_room(scan.angle_rad(i));
      EXPECT_NEAR(scan.ranges_m[i], range_m, 0.0005 + 1e-6) << i;
    }
    EXPECT_TRUE(scan.intensities.empty());
    EXPECT_DOUBLE_EQ(scan.time_increment_s, 0.025 / 1440.0);
  }
  EXPECT_EQ(scanner->skipped().broken, 0);
  EXPECT_EQ(scanner->skipped().lost, 0);
}

TEST(ScipScannerThread, WhatMeetsNothingIsInfiniteAndWhatIsTooNearIsBad) {
  EmulatedRoom half_open{.range_m = [](double, double angle_rad) {
    return angle_rad > 1.0 ? 100.0 : angle_rad > 0.0 ? 0.01 : 3.0;
  }};
  const EmulatedScip device(half_open);
  const LaserScan scan = open_scanner(device.address())->next().value();
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const double angle_rad = scan.angle_rad(i);
    if (std::abs(angle_rad) < 1e-6) continue;
    if (angle_rad > 1.0) {
      EXPECT_TRUE(std::isinf(scan.ranges_m[i])) << i;
    } else if (angle_rad > 0.0) {
      EXPECT_TRUE(std::isnan(scan.ranges_m[i])) << i;
    } else {
      EXPECT_EQ(scan.ranges_m[i], 3.0F) << i;
    }
  }
}

TEST(ScipScannerThread, IntensitiesComeWhereTheyAreKnown) {
  const EmulatedScip device(room());
  const auto scanner = open_scanner(device.address(), {.intensities = true});
  EXPECT_TRUE(scanner->facts().intensities);
  EXPECT_EQ(scanner->facts().mode, "ME by SCIP 2.0");
  const LaserScan scan = scanner->next().value();
  ASSERT_EQ(scan.intensities.size(), 1081U);
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    EXPECT_NEAR(scan.ranges_m[i], range_in_room(scan.angle_rad(i)), 0.0005 + 1e-6);
    EXPECT_NEAR(scan.intensities[i], 3000.0 + 100.0 * scan.angle_rad(i), 1.0);
  }
  const EmulatedScip other(room(), small_model());
  const auto without = open_scanner(other.address(), {.intensities = true});
  EXPECT_FALSE(without->facts().intensities);
  EXPECT_TRUE(without->next()->intensities.empty());
}

TEST(ScipScannerThread, IsHeardThoughTheMachineIsTooSlowForIt) {
  // A turn of 25 ms takes 40 ms to be emulated.
  const auto look = [beams = 0](double, double) mutable {
    if (++beams % 1081 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(40));
    return 2.0;
  };
  const EmulatedScip device({.range_m = look});
  for (int i = 0; i < 2; ++i) EXPECT_EQ(scans_of(*open_scanner(device.address()), 3).size(), 3U);
}

/// Differences of neighbouring stamps [ms].
std::vector<double> spacings_ms(const std::vector<LaserScan>& scans) {
  std::vector<double> spacings;
  for (std::size_t i = 1; i < scans.size(); ++i)
    spacings.push_back((scans[i].stamp - scans[i - 1].stamp).seconds() * 1e3);
  return spacings;
}

TEST(ScipScannerThread, StampsAreEvenThoughScansComeLate) {
  // By up to 20 ms, in no order.
  const EmulatedScip device(room(), {},
                            {.late_s = [](int scan) { return 0.001 * (scan * 7919 % 21); }});
  const auto scanner = open_scanner(device.address());
  const auto scans = scans_of(*scanner, 20);
  // The device's clock tells whole milliseconds.
  for (const double spacing_ms : spacings_ms(scans)) EXPECT_NEAR(spacing_ms, 25.0, 1.01);
}

/// Of stamps to the nearest of those that are true, of every second stamp less than so much [ms].
double usual_error_ms(const std::vector<LaserScan>& scans, const std::vector<std::int64_t>& truth) {
  std::vector<double> errors_ms;
  for (const LaserScan& scan : scans) {
    double error_ms = 1e9;
    for (const std::int64_t truth_ns : truth) {
      const auto off_ns = static_cast<double>(scan.stamp.nanoseconds - truth_ns);
      error_ms = std::min(error_ms, std::abs(off_ns) * 1e-6);
    }
    errors_ms.push_back(error_ms);
  }
  std::sort(errors_ms.begin(), errors_ms.end());
  return errors_ms[errors_ms.size() / 2];
}

TEST(ScipScannerThread, StampsAreOfTheFirstBeam) {
  ScipModel slow = small_model();
  slow.turns_a_minute = 1200;  // 50 ms a turn; the first beam comes 8 ms after the rear
  const EmulatedScip device(room(), slow);
  // Asking for the device's clock takes well below a millisecond, unless the machine is busy: then
  // it is asked anew.
  double best_ms = 1e9;
  for (int i = 0; i < 10 && best_ms > 4.0; ++i) {
    const auto scanner = open_scanner(device.address());
    const auto scans = scans_of(*scanner, 5);
    best_ms = std::min(best_ms, usual_error_ms(scans, device.first_beams_ns()));
  }
  EXPECT_LT(best_ms, 4.0);
}

TEST(ScipScannerThread, StampsGoOnWhereTheDevicesClockWraps) {
  const EmulatedScip device(room(), {.clock_ms = 0xFFFFFF - 200});
  const auto scanner = open_scanner(device.address());
  for (const double spacing_ms : spacings_ms(scans_of(*scanner, 16)))
    EXPECT_NEAR(spacing_ms, 25.0, 1.01);
  EXPECT_EQ(scanner->skipped().lost, 0);
}

TEST(ScipScannerThread, StampsGoOnWhenTheDeviceStartsAnew) {
  const EmulatedScip device(room(), {.clock_ms = 9'000'000}, {.restarts_after = 6});
  const auto scanner = open_scanner(device.address());
  const auto scans = scans_of(*scanner, 12);
  for (const double spacing_ms : spacings_ms(scans)) EXPECT_GT(spacing_ms, 0.0);
  EXPECT_EQ(scanner->skipped().lost, 0);
}

TEST(ScipTroubleThread, ScansThatNeverCameAreCounted) {
  const EmulatedScip device(room(), {}, {.scan = [](int scan, const std::string& bytes) {
                              return scan == 4 || scan == 5 ? std::string() : bytes;
                            }});
  const auto scanner = open_scanner(device.address());
  const auto spacings = spacings_ms(scans_of(*scanner, 6));
  EXPECT_NEAR(spacings[3], 75.0, 1.01);
  EXPECT_EQ(scanner->skipped().lost, 2);
  EXPECT_EQ(scanner->skipped().broken, 0);
}

TEST(ScipTroubleThread, DamagedScansAreLeftOutAndCounted) {
  const EmulatedScip device(room(), {}, {.scan = [](int scan, std::string bytes) {
                              if (scan == 2) bytes[500] = static_cast<char>(bytes[500] ^ 1);
                              if (scan == 4) bytes.erase(700, 3);
                              if (scan == 6) bytes.erase(bytes.size() - 40);
                              if (scan == 8) bytes.insert(900, "\nnoise\n\n");
                              return bytes;
                            }});
  const auto scanner = open_scanner(device.address());
  for (const LaserScan& scan : scans_of(*scanner, 8)) {
    for (std::size_t i = 0; i < scan.ranges_m.size(); ++i)
      ASSERT_NEAR(scan.ranges_m[i], range_in_room(scan.angle_rad(i)), 0.0005 + 1e-6);
  }
  // The sixth took the echo of the seventh with it; the eighth fell into two.
  EXPECT_EQ(scanner->skipped().broken, 4);
  EXPECT_EQ(scanner->skipped().lost, 1);
}

TEST(ScipTroubleThread, OpensADeviceThatIsStillSending) {
  const EmulatedScip device(room(), {}, {.is_sending = true});
  const auto scanner = open_scanner(device.address());
  for (const double spacing_ms : spacings_ms(scans_of(*scanner, 4)))
    EXPECT_NEAR(spacing_ms, 25.0, 1.01);
  EXPECT_EQ(scanner->skipped().broken, 0);
}

TEST(ScipTroubleThread, OpensADeviceWithHalfACommandInItsBuffer) {
  const EmulatedScip device(room());
  {
    const std::string place = device.address();
    const test::WebClient other(
        static_cast<std::uint16_t>(std::stoi(place.substr(place.rfind(':') + 1))));
    other.write("VV\nMD00");
  }
  const auto scanner = open_scanner(device.address(), {.silence_s = 1.0});
  EXPECT_EQ(scanner->next()->ranges_m.size(), 1081U);
  EXPECT_THAT(device.commands(), Contains("MD00QT"));
}

TEST(ScipTroubleThread, OpensADeviceThatSaysSomethingElseFirst) {
  const EmulatedScip device(room(), {},
                            {.said_before = std::string("\0\xFFrubbish\n\nPP\n00P\nDMIN:2", 24)});
  const auto scanner = open_scanner(device.address(), {.silence_s = 1.0});
  EXPECT_EQ(scanner->facts().beams, 1081);
}

TEST(ScipTroubleThread, AsksAgainWhenAReplyIsDamaged) {
  const auto asked = std::make_shared<std::atomic<int>>(0);
  const EmulatedScip device(room(), {},
                            {.reply = [asked](const std::string& command, std::string reply) {
                              if (command == "PP" && asked->fetch_add(1) < 2)
                                reply[20] = static_cast<char>(reply[20] ^ 1);
                              return reply;
                            }});
  const auto scanner = open_scanner(device.address());
  EXPECT_EQ(scanner->facts().beams, 1081);
  EXPECT_EQ(*asked, 3);
}

TEST(ScipTroubleThread, RefusalsAreToldInWords) {
  const auto refuse = [](const std::string& refused, const std::string& status) {
    return ScipTroubles{.reply = [=](const std::string& command, std::string reply) {
      if (!command.starts_with(refused)) return reply;
      return command + "\n" + status + scip_checksum(status) + "\n\n";
    }};
  };
  const EmulatedScip no_scan(room(), {}, refuse("MD", "04"));
  EXPECT_THAT(error_of([&] { (void)open_scanner(no_scan.address()); }),
              HasSubstr(no_scan.address() + ": refuses MD: status 04: the last step is out of"));
  const EmulatedScip no_facts(room(), {}, refuse("PP", "0A"));
  EXPECT_THAT(error_of([&] { (void)open_scanner(no_facts.address()); }),
              HasSubstr("refuses PP: status 0A: it can't make the reply"));
  const EmulatedScip no_clock(room(), {}, refuse("TM0", "0E"));
  EXPECT_TRUE(open_scanner(no_clock.address())->next());
}

TEST(ScipTroubleThread, ALaserThatFailsIsResetOnce) {
  const EmulatedScip device(room(), {}, {.laser_fails_until_reset = true});
  EXPECT_TRUE(open_scanner(device.address())->next());
  EXPECT_THAT(device.commands(), Contains("RS"));
  const EmulatedScip broken(room(), {},
                            {.reply = [](const std::string& command, const std::string& reply) {
                              return command == "BM" ? "BM\n01Q\n\n" : reply;
                            }});
  EXPECT_THAT(error_of([&] { (void)open_scanner(broken.address()); }),
              HasSubstr("its laser has failed; switch it off and on"));
}

TEST(ScipTroubleThread, FailuresWhileItMeasuresAreToldInWords) {
  const auto fail_with = [](const std::string& status) {
    return ScipTroubles{.scan = [=](int scan, const std::string& bytes) {
      if (scan != 3) return bytes;
      return bytes.substr(0, 16) + status + scip_checksum(status) + "\n\n";
    }};
  };
  const EmulatedScip failing(room(), {}, fail_with("55"));
  const auto scanner = open_scanner(failing.address());
  (void)scans_of(*scanner, 3);
  EXPECT_THAT(error_of([&] { (void)scanner->next(); }), HasSubstr("another part has failed"));
  // One that checks itself goes on.
  const EmulatedScip checking(room(), {}, fail_with("21"));
  const auto patient = open_scanner(checking.address());
  EXPECT_EQ(scans_of(*patient, 5).size(), 5U);
  EXPECT_EQ(patient->skipped().lost, 1);
}

TEST(ScipTroubleThread, SilenceIsAnError) {
  const EmulatedScip device(room(), {}, {.is_silent_after = 3});
  const auto scanner = open_scanner(device.address(), {.silence_s = 0.5});
  (void)scans_of(*scanner, 3);
  EXPECT_THAT(error_of([&] { (void)scanner->next(); }), HasSubstr("has been silent for 0.5 s"));
}

TEST(ScipTroubleThread, RubbishIsAnError) {
  const EmulatedScip device(room(), {}, {.scan = [](int scan, const std::string& bytes) {
                              return scan < 3 ? bytes : std::string(bytes.size(), '\x7F');
                            }});
  const auto scanner = open_scanner(device.address(), {.silence_s = 1.5});
  (void)scans_of(*scanner, 3);
  EXPECT_THAT(error_of([&] { (void)scanner->next(); }), HasSubstr("has sent no sound scan"));
  const EmulatedScip deaf(room(), {}, {.reply = [](const std::string&, const std::string&) {
                            return std::string("login: ");
                          }});
  EXPECT_THAT(error_of([&] { (void)open_scanner(deaf.address(), {.silence_s = 0.2}); }),
              HasSubstr("does not understand SCIP"));
  const EmulatedScip mute(room(), {},
                          {.reply = [](const std::string&, const std::string&) { return ""; }});
  EXPECT_THAT(error_of([&] { (void)open_scanner(mute.address(), {.silence_s = 0.2}); }),
              HasSubstr("is silent; is it powered"));
}

TEST(ScipTroubleThread, IsOpenedAgainAfterItWasCutOff) {
  const EmulatedScip device(room(), {}, {.disconnects_after = 3});
  auto scanner = open_scanner(device.address());
  (void)scans_of(*scanner, 2);
  EXPECT_THAT(error_of([&] { (void)scanner->next(); }), HasSubstr("has closed the connection"));
  scanner.reset();
  scanner = open_scanner(device.address());
  EXPECT_EQ(scans_of(*scanner, 3).size(), 3U);
}

TEST(ScipTroubleThread, WhoeverStopsGetsNothing) {
  const EmulatedScip device(room(), {}, {.is_silent_after = 0});
  const auto asked = std::make_shared<std::atomic<int>>(-1);
  const auto scanner =
      open_scanner(device.address(),
                   {.stop = [asked] { return *asked >= 0 && ++*asked > 3; }, .silence_s = 60.0});
  *asked = 0;
  EXPECT_FALSE(scanner->next());
  EXPECT_EQ(open_scanner(device.address(), {.stop = [] { return true; }}), nullptr);
}

TEST(ScipScannerThread, SpeaksOverASerialPort) {
  const EmulatedScip device(room(), small_model(), {}, test::EmulatedLine::Kind::kTerminal);
  // 1.45 kB are under way for 12.6 ms: every turn of 20 ms fits.
  const auto quick = open_scanner(device.address() + "?baud=1152000");
  EXPECT_EQ(quick->facts().mode, "MS by SCIP 2.0");
  EXPECT_DOUBLE_EQ(quick->facts().rate_hz, 50.0);
  const LaserScan scan = quick->next().value();
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const double range_m = range_in_room(scan.angle_rad(i));
    if (range_m > 4.095) {
      EXPECT_TRUE(std::isinf(scan.ranges_m[i])) << i;
    } else {
      EXPECT_NEAR(scan.ranges_m[i], range_m, 0.0005 + 1e-6) << i;
    }
  }
}

TEST(ScipScannerThread, LeavesScansOutThatASlowLineCanNotCarry) {
  const EmulatedScip device(room(), small_model(), {}, test::EmulatedLine::Kind::kTerminal);
  const auto scanner = open_scanner(device.address() + "?baud=115200");
  // 126 ms a scan, of every seventh turn of 20 ms.
  EXPECT_NEAR(scanner->facts().rate_hz, 50.0 / 7.0, 1e-9);
  for (const double spacing_ms : spacings_ms(scans_of(*scanner, 3)))
    EXPECT_NEAR(spacing_ms, 140.0, 1.01);
  EXPECT_EQ(scanner->skipped().lost, 0);
}

TEST(ScipTroubleThread, PlacesThatCanNotBeOpenedAreTold) {
  EXPECT_THAT(error_of([] { (void)open_scanner("scip://127.0.0.1:1"); }),
              HasSubstr("scip://127.0.0.1:1: refuses the connection"));
  EXPECT_THAT(error_of([] { (void)open_scanner("scip:///dev/no-such-port"); }),
              HasSubstr("is not there; is the scanner plugged in?"));
  EXPECT_THAT(error_of([] { (void)open_scanner("scip:///dev/null"); }),
              HasSubstr("is no serial port"));
  EXPECT_THAT(error_of([] { (void)open_scanner("scip://no-such-host.invalid"); }),
              HasSubstr("names no host"));
}

}  // namespace
}  // namespace loopstone
