// Every format of logs, by the table: nothing here names one.

#include "loopstone/formats/log_format.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "loopstone/formats/convert_log.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/formats/log_files.hpp"
#include "loopstone/formats/log_format_words.hpp"
#include "support/memory_log.hpp"
#include "support/pose_near.hpp"
#include "support/read_log.hpp"
#include "support/simulated_log.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

namespace fs = std::filesystem;
using test::LogContent;
using test::pose_near;
using test::TempDir;
using testing::HasSubstr;
using testing::IsEmpty;

/// The name of a test case, and of the format's log in a folder.
std::string case_name(const testing::TestParamInfo<const LogFormat*>& info) {
  return std::string(info.param->name);
}

std::string path_in(const TempDir& folder, const LogFormat& format) {
  const bool is_file = format.place == LogPlace::kFile;
  return folder / (std::string(format.name) + (is_file ? std::string(format.endings[0]) : ""));
}

/// Of several formats that are folders a name alone means the first.
LogTarget target_at(const std::string& path, const LogFormat& format) {
  if (format.place == LogPlace::kFile) return log_target(path);
  return log_target(path, std::string(format.name));
}

std::vector<std::string> write_log(const LogTarget& target,
                                   const std::vector<SensorMessage>& messages) {
  const auto writer = create_log(target, RobotModel{});
  for (const SensorMessage& message : messages) writer->write(message);
  writer->finish();
  return writer->notes();
}

std::vector<SensorMessage> make_drive(bool poses) {
  SimulationOptions options;
  options.duration_s = 3.0;
  options.start_s = 1.7e9;
  options.laser.beams = 181;
  options.laser.fov_rad = kPi;
  options.odometry_poses = poses;
  std::vector<SensorMessage> messages = test::simulate_log("office", 1, options).messages;
  static const TempDir folder;
  const CameraModel camera;
  const std::string colour = folder / "colour.png";
  const std::string depth = folder / "depth.png";
  write_png(colour, make_image(camera.colour.width_px, camera.colour.height_px, 3));
  write_png(depth, make_image(camera.depth.width_px, camera.depth.height_px, 1, 2));
  const Stamp end = stamp_of(messages.back());
  messages.emplace_back(
      RgbdFrame{.stamp = end, .colour_stamp = end, .colour_path = colour, .depth_path = depth});
  return messages;
}

/// A drive with all that the simulator tells (poses or wheels), by a clock that counts from 1970,
/// and one frame of the floor. It is simulated once: that takes longer than writing and reading it.
const std::vector<SensorMessage>& drive(bool poses) {
  static const std::vector<SensorMessage> with_poses = make_drive(true);
  static const std::vector<SensorMessage> with_wheels = make_drive(false);
  return poses ? with_poses : with_wheels;
}

std::vector<SensorMessage> held_of(const std::vector<SensorMessage>& messages,
                                   const LogFormat& format) {
  std::vector<SensorMessage> held;
  for (const SensorMessage& message : messages) {
    if (holds(format.holds, message)) held.push_back(message);
  }
  return held;
}

template <typename Reading>
std::vector<Reading> only(const std::vector<SensorMessage>& messages) {
  std::vector<Reading> readings;
  for (const SensorMessage& message : messages) {
    if (const auto* reading = std::get_if<Reading>(&message)) readings.push_back(*reading);
  }
  return readings;
}

void expect_same(const LaserScan& wanted, const LaserScan& read, const LogFormat& format) {
  ASSERT_EQ(read.ranges_m.size(), wanted.ranges_m.size());
  for (std::size_t beam = 0; beam < wanted.ranges_m.size(); ++beam) {
    if (std::isnan(wanted.ranges_m[beam])) {
      EXPECT_TRUE(std::isnan(read.ranges_m[beam])) << beam;
    } else {
      EXPECT_EQ(read.ranges_m[beam], wanted.ranges_m[beam]) << beam;
    }
  }
  EXPECT_NEAR(read.angle_min_rad, wanted.angle_min_rad, 1e-6);
  EXPECT_NEAR(read.angle_increment_rad, wanted.angle_increment_rad, 1e-8);
  const double rounding = format.holds.single_precision ? 1e-7 : 0.0;
  EXPECT_NEAR(read.range_max_m, wanted.range_max_m, rounding * wanted.range_max_m);
  const double time_increment_s = format.holds.beam_times ? wanted.time_increment_s : 0.0;
  EXPECT_NEAR(read.time_increment_s, time_increment_s, rounding * time_increment_s);
  if (wanted.robot_T_lidar && format.holds.lidar_mount) {
    ASSERT_TRUE(read.robot_T_lidar);
    EXPECT_TRUE(pose_near(*read.robot_T_lidar, *wanted.robot_T_lidar, 1e-5, 1e-5));
  }
}

void expect_same(const OdometryPose& wanted, const OdometryPose& read, const LogFormat& format) {
  if (format.holds.single_precision) {  // headings are quaternions there
    EXPECT_TRUE(pose_near(read.odom_T_robot, wanted.odom_T_robot, 1e-15, 1e-12));
  } else {
    EXPECT_EQ(read.odom_T_robot, wanted.odom_T_robot);
  }
}

void expect_same(const WheelTicks& wanted, const WheelTicks& read, const LogFormat&) {
  EXPECT_EQ(read.counts, wanted.counts);
}

void expect_same(const ImuSample& wanted, const ImuSample& read, const LogFormat&) {
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(read.angular_velocity_rad_s[axis], wanted.angular_velocity_rad_s[axis], 1e-12);
    EXPECT_NEAR(read.linear_acceleration_m_s2[axis], wanted.linear_acceleration_m_s2[axis], 1e-12);
  }
}

void expect_same(const RgbdFrame& wanted, const RgbdFrame& read, const LogFormat&) {
  EXPECT_EQ(read.colour_path.empty(), wanted.colour_path.empty());
  EXPECT_EQ(read.depth_path.empty(), wanted.depth_path.empty());
}

template <typename Reading>
void expect_all(const std::vector<SensorMessage>& wanted, const std::vector<SensorMessage>& read,
                const LogFormat& format) {
  const auto before = only<Reading>(wanted);
  const auto after = only<Reading>(read);
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    const Duration off = after[i].stamp - before[i].stamp;
    EXPECT_LE(std::abs(off.nanoseconds), format.holds.stamp_error.nanoseconds);
    expect_same(before[i], after[i], format);
  }
}

void expect_all_kinds(const std::vector<SensorMessage>& wanted,
                      const std::vector<SensorMessage>& read, const LogFormat& format) {
  EXPECT_EQ(read.size(), wanted.size());
  expect_all<LaserScan>(wanted, read, format);
  expect_all<OdometryPose>(wanted, read, format);
  expect_all<WheelTicks>(wanted, read, format);
  expect_all<ImuSample>(wanted, read, format);
  expect_all<RgbdFrame>(wanted, read, format);
}

class EachLogFormat : public testing::TestWithParam<const LogFormat*> {
 protected:
  [[nodiscard]] static const LogFormat& format() { return *GetParam(); }
};

TEST_P(EachLogFormat, IsWholeAndFoundByItsName) {
  EXPECT_EQ(find_log_format(format().name), &format());
  EXPECT_EQ(&log_format(format().name), &format());
  for (const std::string_view word :
       {format().name, format().title, format().noun, format().file_is}) {
    EXPECT_FALSE(word.empty()) << format().name;
  }
  ASSERT_FALSE(format().endings.empty());
  EXPECT_NE(format().recognise, nullptr);
  EXPECT_NE(format().open, nullptr);
  const bool is_folder = format().place == LogPlace::kFolder;
  EXPECT_EQ(!format().expected.empty(), is_folder) << "what a folder lacks can be told";
  EXPECT_EQ(format().files != nullptr, is_folder);
  EXPECT_EQ(format().parts != nullptr, is_folder && format().can_be_written());
  EXPECT_TRUE(format().holds.scans) << "a log without scans can't become a map";
}

TEST_P(EachLogFormat, BringsBackWhatItHoldsAndTellsWhatItDoesNot) {
  if (!format().can_be_written()) GTEST_SKIP() << "is only read";
  for (const bool poses : {true, false}) {
    const TempDir folder;
    const std::string path = path_in(folder, format());
    const auto& messages = drive(poses);
    const auto wanted = held_of(messages, format());
    const auto notes = write_log(target_at(path, format()), messages);
    const LogContent log = test::read_log(path);
    expect_all_kinds(wanted, log.messages, format());
    EXPECT_EQ(log.skipped, 0);
    EXPECT_TRUE(log.in_time_order);
    std::map<std::string, std::int64_t> lost;
    for (const SensorMessage& message : messages) {
      const MessageKind& kind = message_kinds()[message.index()];
      if (!holds(format().holds, message)) ++lost[std::string(kind.name)];
    }
    for (const auto& [kind, count] : lost) {
      const std::string told = std::to_string(count) + " " + kind + " are left out";
      EXPECT_THAT(notes, testing::Contains(HasSubstr(told)));
    }
    const auto loses_sweep = testing::Contains(HasSubstr("lose the time between their beams"));
    if (format().holds.beam_times) {
      EXPECT_THAT(notes, testing::Not(loses_sweep));
    } else {
      EXPECT_THAT(notes, loses_sweep);
    }
  }
}

TEST_P(EachLogFormat, IsRecognisedByItsContentUnderAnyName) {
  if (!format().can_be_written()) GTEST_SKIP() << "is only read";
  const TempDir folder;
  write_log({&format(), folder / "any_name"}, drive(true));
  EXPECT_EQ(&recognise_log(look_at_log(folder / "any_name")), &format());
  EXPECT_EQ(open_log(folder / "any_name")->format(), format().name);
}

TEST_P(EachLogFormat, RefusesTheOthersFiles) {
  for (const LogFormat& other : log_formats()) {
    if (!other.can_be_written() || &other == &format()) continue;
    const TempDir folder;
    write_log({&other, folder / "any_name"}, drive(true));
    std::vector<std::string> files = log_parts({&other, folder / "any_name"}).files;
    files.push_back(folder / "any_name");
    for (const std::string& file : files) {
      if (!fs::exists(file)) continue;
      const LogInput log = look_at_log(file);
      EXPECT_EQ(&recognise_log(log), &other) << file;
      EXPECT_THROW((void)open_log(log, format()), DataError) << format().name << ": " << file;
    }
  }
}

TEST_P(EachLogFormat, RefusesNoiseAndNothing) {
  const TempDir folder;
  const std::string noise = folder.write("noise", std::string("\x07\x00\xff\x13 noise", 10));
  EXPECT_THROW((void)open_log(look_at_log(noise), format()), DataError);
  fs::create_directories(folder / "nothing");
  EXPECT_THROW((void)open_log(look_at_log(folder / "nothing"), format()), DataError);
}

TEST_P(EachLogFormat, WritesOnlyThePartsThatItNames) {
  if (!format().can_be_written()) GTEST_SKIP() << "is only read";
  const TempDir folder;
  const LogTarget target = target_at(path_in(folder, format()), format());
  write_log(target, drive(true));
  const LogParts parts = log_parts(target);
  std::set<fs::path> named(parts.files.begin(), parts.files.end());
  const std::set<fs::path> folders(parts.folders.begin(), parts.folders.end());
  std::size_t found = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder.path())) {
    if (!entry.is_regular_file()) continue;
    ++found;
    EXPECT_TRUE(named.count(entry.path()) + folders.count(entry.path().parent_path()) > 0)
        << entry.path();
  }
  EXPECT_GT(found, 0u);
  for (const std::string& path : LogFiles(target.path).paths()) {
    EXPECT_TRUE(named.count(path)) << path;
  }
}

TEST_P(EachLogFormat, NamesOfOutputsMeanIt) {
  if (!format().can_be_written()) GTEST_SKIP() << "is only read";
  const std::string name(format().name);
  EXPECT_EQ(log_target("some.where", name).format, &format());
  for (const std::string_view ending : format().endings) {
    const std::string file = "a" + std::string(ending);
    EXPECT_TRUE(has_log_ending(file));
    if (format().place == LogPlace::kFolder) continue;
    EXPECT_EQ(log_target(file).format, &format());
    for (const std::string_view packing : format().packings) {
      EXPECT_EQ(log_target(file + std::string(packing)).format, &format());
    }
  }
  const LogTarget set = log_target("some#21", name);
  EXPECT_EQ(set.set, format().has_sets ? 21 : LogTarget::kDefaultSet);
  EXPECT_EQ(set.path, format().has_sets ? "some" : "some#21");
}

TEST_P(EachLogFormat, TellsTheLasersThatItSaysApartAndRefusesMore) {
  if (!format().can_be_written()) GTEST_SKIP() << "is only read";
  for (const int lidars : {format().holds.lidars, format().holds.lidars + 1}) {
    const TempDir folder;
    std::vector<SensorMessage> messages = drive(true);
    std::vector<SensorMessage> all;
    for (const SensorMessage& message : messages) {
      const auto* const scan = std::get_if<LaserScan>(&message);
      if (scan == nullptr) {
        all.push_back(message);
        continue;
      }
      for (int lidar = 0; lidar < lidars; ++lidar) {
        all.emplace_back(*scan);
        std::get<LaserScan>(all.back()).lidar = lidar;
      }
    }
    const LogTarget target = target_at(path_in(folder, format()), format());
    if (lidars > format().holds.lidars) {
      EXPECT_THROW((void)write_log(target, all), DataError);
      continue;
    }
    (void)write_log(target, all);
    std::set<int> seen;
    for (const LaserScan& scan : test::read_log(target.path).scans) seen.insert(scan.lidar);
    EXPECT_EQ(seen.size(), static_cast<std::size_t>(lidars));
  }
}

TEST_P(EachLogFormat, KeepsOrRefusesBeamsThatChangeAsItSays) {
  if (!format().can_be_written()) GTEST_SKIP() << "is only read";
  const TempDir folder;
  std::vector<SensorMessage> messages = drive(true);
  std::vector<std::size_t> beams;
  for (SensorMessage& message : messages) {
    auto* const scan = std::get_if<LaserScan>(&message);
    if (scan == nullptr) continue;
    if (beams.size() % 2 == 1) scan->ranges_m.resize(scan->ranges_m.size() - 10);
    beams.push_back(scan->ranges_m.size());
  }
  const LogTarget target = target_at(path_in(folder, format()), format());
  if (!format().holds.beams_change) {
    EXPECT_THROW((void)write_log(target, messages), DataError);
    return;
  }
  (void)write_log(target, messages);
  std::vector<std::size_t> read;
  for (const LaserScan& scan : test::read_log(target.path).scans) {
    read.push_back(scan.ranges_m.size());
  }
  EXPECT_EQ(read, beams);
}

TEST_P(EachLogFormat, TakesEveryOther) {
  if (!format().can_be_written()) GTEST_SKIP() << "is only read";
  for (const bool poses : {true, false}) {
    const TempDir folder;
    const auto& messages = drive(poses);
    test::MemoryLog log(messages);
    const LogTarget target = target_at(path_in(folder, format()), format());
    const auto writer = create_log(target, RobotModel{});
    const auto result = convert_log(log, *writer, format().holds, RobotModel{});
    writer->finish();
    const bool by_dead_reckoning = !poses && !format().holds.wheel_ticks;
    EXPECT_EQ(result.poses_by_dead_reckoning > 0, by_dead_reckoning);
    const LogContent read = test::read_log(target.path);
    EXPECT_EQ(read.scans.size(), only<LaserScan>(messages).size());
    EXPECT_FALSE(read.odometry.empty() && read.ticks.empty()) << "its motion must come along";
    EXPECT_EQ(read.imu.size(), format().holds.imu_samples ? only<ImuSample>(messages).size() : 0);
  }
}

std::vector<const LogFormat*> all_formats() {
  std::vector<const LogFormat*> formats;
  for (const LogFormat& format : log_formats()) formats.push_back(&format);
  return formats;
}

INSTANTIATE_TEST_SUITE_P(Table, EachLogFormat, testing::ValuesIn(all_formats()), case_name);

TEST(LogFormats, NamesAndEndingsAreTheirOwn) {
  std::set<std::string_view> names;
  std::set<std::string_view> endings;
  std::size_t all_endings = 0;
  for (const LogFormat& format : log_formats()) {
    names.insert(format.name);
    for (const std::string_view ending : format.endings) endings.insert(ending);
    all_endings += format.endings.size();
  }
  EXPECT_EQ(names.size(), log_formats().size());
  EXPECT_EQ(endings.size(), all_endings);
}

TEST(LogFormats, AnUnknownNameIsToldTheKnownOnes) {
  for (const auto& ask : std::vector<std::function<void()>>{
           [] { (void)log_format("carmin"); }, [] { (void)log_target("a", "carmin"); },
           [] { (void)create_log("a", "carmin", RobotModel{}); }}) {
    try {
      ask();
      FAIL() << "a format of that name was found";
    } catch (const UsageError& error) {
      EXPECT_THAT(error.what(), HasSubstr("'carmin'"));
      for (const LogFormat& format : log_formats()) {
        EXPECT_THAT(error.what(), HasSubstr(std::string(format.name)));
      }
    }
  }
}

TEST(LogFormats, NamesThatMeanNoneAreRefused) {
  EXPECT_THROW((void)log_target("a.txt"), UsageError);
  EXPECT_THROW((void)log_target("folder#x"), UsageError);
  EXPECT_THROW((void)log_target("folder#1234567"), UsageError);
  const TempDir folder;
  fs::create_directories(folder / "a.txt");
  EXPECT_EQ(log_target(folder / "a.txt").format->place, LogPlace::kFolder) << "it is one";
}

TEST(LogFormats, WordsOfAllAreInTheTexts) {
  const std::string text = log_formats_text();
  const std::string is = what_a_log_is();
  const std::string means = listed(log_name_meanings(), "and");
  const auto json = nlohmann::json::parse(log_formats_json()).at("formats");
  ASSERT_EQ(json.size(), log_formats().size());
  std::size_t row = 0;
  for (const LogFormat& format : log_formats()) {
    EXPECT_THAT(text, HasSubstr(std::string(format.noun)));
    EXPECT_THAT(is, HasSubstr(std::string(format.noun)));
    if (format.can_be_written() && format.place == LogPlace::kFile) {
      EXPECT_THAT(means, HasSubstr(std::string(format.noun)));
    }
    const auto& entry = json[row++];
    EXPECT_EQ(entry.at("name"), std::string(format.name));
    EXPECT_EQ(entry.at("written"), format.can_be_written());
    EXPECT_EQ(entry.at("holds").at("wheel_readings"), format.holds.wheel_ticks);
  }
  EXPECT_EQ(listed({}, "and"), "");
  EXPECT_EQ(listed({"a"}, "and"), "a");
  EXPECT_EQ(listed({"a", "b", "c"}, "or"), "a, b or c");
}

TEST(LogFormats, FilesOfOtherKindsAreToldWhatTheyAre) {
  const TempDir folder;
  const std::string png = folder.write("a.clf", "\x89PNG\r\n\x1a\n and more of it");
  try {
    (void)open_log(png);
    FAIL() << "a picture was opened";
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), HasSubstr("is a picture"));
    for (const LogFormat& format : log_formats()) {
      EXPECT_THAT(error.what(), HasSubstr(std::string(format.noun)));
    }
  }
}

TEST(LogFormats, AFolderWithALogInItIsToldSo) {
  const TempDir folder;
  const std::string file = folder.write("drive.clf.gz", "anything");
  try {
    (void)open_log(folder.path().string());
    FAIL() << "the folder was opened";
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), HasSubstr("give its name: " + file));
  }
}

}  // namespace
}  // namespace loopstone
