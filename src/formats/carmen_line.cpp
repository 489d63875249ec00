#include "formats/carmen_line.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "formats/text_numbers.hpp"

namespace loopstone {
namespace {

constexpr std::int64_t kMostBeams = 100'000;
/// Coordinates of the grids in which the earth is surveyed (UTM) are less.
constexpr double kFarthestPoseM = 1e7;

/// Why a word is no stamp, and what to do. The usual mistake is a unit that makes the number too
/// large.
std::string reason_against_stamp(std::string_view word) {
  if (word.empty()) {
    return "the line ends before the time; every line ends with time [s], host and logger's time";
  }
  std::string reason = "the time is '" + std::string(word.substr(0, 24)) + "', expected seconds";
  const auto value = parse_number(word);
  if (!value || !(*value >= 1e10) || *value >= 1e20) return reason;
  const char* const unit = *value < 1e14   ? "milliseconds, divide it by 1000"
                           : *value < 1e17 ? "microseconds, divide it by 1e6"
                                           : "nanoseconds, divide it by 1e9";
  return reason + "; if it is in " + unit;
}

/// Reads words as numbers and remembers the first that isn't one.
class Fields {
 public:
  explicit Fields(Words words) : words_(words) {}

  double number(const char* what) {
    const std::string_view word = words_.next();
    const auto value = parse_number(word);
    if (!value) fail(what, word, "a number");
    return value.value_or(0.0);
  }
  /// A number that must be finite.
  double finite(const char* what) {
    const double value = number(what);
    if (!std::isfinite(value) && ok()) reason_ = std::string(what) + " is not finite";
    return value;
  }
  std::int64_t count(const char* what) {
    const std::string_view word = words_.next();
    const auto value = parse_integer(word);
    if (!value) {
      fail(what, word, "a whole number");
    } else if (*value < 0 || *value > kMostBeams) {
      if (ok())
        reason_ = std::string(what) + " is " + std::to_string(*value) + ", expected 0 to " +
                  std::to_string(kMostBeams);
    }
    return ok() ? *value : 0;
  }
  Pose2 pose(const char* what) {
    const double x = finite(what);
    const double y = finite(what);
    const double yaw = finite(what);
    if (ok() && std::max({std::abs(x), std::abs(y), std::abs(yaw)}) > kFarthestPoseM) {
      reason_ = std::string(what) + " lies more than 10,000 km away, or turns as often";
    }
    return {x, y, wrap_angle(yaw)};
  }
  std::vector<float> ranges(std::int64_t beams) {
    std::vector<float> values;
    values.reserve(static_cast<std::size_t>(std::min(beams, remaining_words())));
    for (std::int64_t i = 0; i < beams && ok(); ++i) {
      values.push_back(static_cast<float>(number("a range")));
    }
    return values;
  }
  void skip(std::int64_t words) {
    for (std::int64_t i = 0; i < words && ok(); ++i) {
      if (words_.next().empty()) reason_ = "the line ends too early";
    }
  }
  /// Time, host and the logger's time close every line. A time that is none is no reason to refuse
  /// the line: others may do.
  CarmenTimes times() {
    CarmenTimes times;
    const std::string_view word = words_.next();
    if (!ok()) return times;
    times.absent = word.empty();
    times.header = parse_stamp(word);
    if (!times.header) times.header_problem = reason_against_stamp(word);
    if (times.absent) return times;
    skip(1);
    const std::string_view logger = words_.next();
    if (ok() && logger.empty()) reason_ = "the line ends too early";
    if (ok() && !words_.next().empty()) {
      reason_ = "the line holds more words than its count of beams says";
    }
    times.logger = parse_stamp(logger);
    return times;
  }
  /// Words that are left, as far as it matters.
  int words_left(int most) const {
    Words rest = words_;
    int count = 0;
    while (count < most && !rest.next().empty()) ++count;
    return count;
  }
  bool ok() const { return reason_.empty(); }
  const std::string& reason() const { return reason_; }

 private:
  /// An upper bound: a word takes at least two characters. Keeps a lying count from reserving
  /// memory.
  std::int64_t remaining_words() const {
    return static_cast<std::int64_t>(words_.rest().size() / 2 + 1);
  }
  void fail(const char* what, std::string_view word, const char* expected) {
    if (!ok()) return;
    reason_ = word.empty() ? std::string("the line ends before ") + what
                           : std::string(what) + " is '" + std::string(word.substr(0, 24)) +
                                 "', expected " + expected;
  }

  Words words_;
  std::string reason_;
};

void read_poses(Fields& fields, CarmenScan& scan) {
  scan.odom_T_lidar = fields.pose("the laser's pose");
  scan.odom_T_robot = fields.pose("the robot's pose");
  scan.has_poses = true;
}

CarmenLine parse_old_laser(CarmenTag tag, Fields fields) {
  CarmenScan scan;
  scan.tag = tag;
  const std::int64_t beams = fields.count("the number of beams");
  scan.raw_ranges_m = fields.ranges(beams);
  // CARMEN writes no poses with LASER3 and on; other loggers may.
  constexpr int kPoseWords = 6;
  const bool has_poses = lidar_of(tag) < 2 || fields.words_left(kPoseWords) == kPoseWords;
  if (has_poses) read_poses(fields, scan);
  scan.times = fields.times();
  if (!fields.ok()) return CarmenBroken{fields.reason(), true};
  if (beams == 0) return CarmenBroken{"the scan has no beams", true};
  return scan;
}

CarmenLine parse_new_laser(CarmenTag tag, Fields fields) {
  CarmenScan scan;
  scan.tag = tag;
  CarmenBeams beams;
  const double type = fields.number("the laser's type");
  beams.laser_type = std::abs(type) < 100.0 ? static_cast<int>(type) : -1;
  beams.start_angle_rad = fields.finite("the start angle");
  beams.field_of_view_rad = fields.finite("the field of view");
  beams.resolution_rad = fields.finite("the resolution");
  beams.max_range_m = fields.number("the maximum range");
  scan.beams = beams;
  fields.skip(2);  // accuracy, remission mode
  const std::int64_t count = fields.count("the number of beams");
  scan.raw_ranges_m = fields.ranges(count);
  fields.skip(fields.count("the number of remissions"));
  if (tag < CarmenTag::kRawLaser1) {
    read_poses(fields, scan);
    fields.skip(5);  // velocities and safety distances
  }
  scan.times = fields.times();
  if (!fields.ok()) return CarmenBroken{fields.reason(), true};
  if (count == 0) return CarmenBroken{"the scan has no beams", true};
  return scan;
}

CarmenLine parse_odometry(Fields fields) {
  CarmenOdometry odometry;
  odometry.odom_T_robot = fields.pose("the robot's pose");
  fields.skip(3);  // velocities and acceleration
  odometry.times = fields.times();
  if (!fields.ok()) return CarmenBroken{fields.reason()};
  return odometry;
}

CarmenLine parse_truth(Fields fields) {
  CarmenTruth truth;
  truth.world_T_robot = fields.pose("the true pose");
  fields.pose("the robot's pose");
  truth.times = fields.times();
  if (!fields.ok()) return CarmenBroken{fields.reason()};
  return truth;
}

CarmenLine parse_param(Words words) {
  CarmenParam param;
  param.name = words.next();
  param.value = words.next();
  if (param.name.empty()) return CarmenBroken{"PARAM without a name"};
  return param;
}

/// Binary rubbish makes tags of any bytes; only what could be a tag is worth counting as one.
bool looks_like_a_tag(std::string_view word) {
  for (const char c : word) {
    const bool fits =
        (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || (c >= 'a' && c <= 'z');
    if (!fits) return false;
  }
  return word.size() <= 40;
}

}  // namespace

CarmenLine parse_carmen_line(std::string_view text) {
  Words words(text);
  const std::string_view tag = words.next();
  if (tag.empty() || tag.front() == '#') return CarmenOther{};
  if (const auto laser = find_word<CarmenTag>(tag)) {
    const bool is_old = laser < CarmenTag::kRobotLaser1;
    return is_old ? parse_old_laser(*laser, Fields(words)) : parse_new_laser(*laser, Fields(words));
  }
  if (tag == "ODOM") return parse_odometry(Fields(words));
  if (tag == kCarmenTruth) return parse_truth(Fields(words));
  if (tag == "PARAM") return parse_param(words);
  if (!looks_like_a_tag(tag)) {
    return CarmenBroken{"the line doesn't begin with a CARMEN tag", false, false};
  }
  return CarmenOther{tag};
}

}  // namespace loopstone
