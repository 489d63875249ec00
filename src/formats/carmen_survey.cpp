#include "formats/carmen_survey.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "formats/carmen_line.hpp"
#include "formats/line_reader.hpp"
#include "formats/text_numbers.hpp"
#include "loopstone/sensor/robot_model.hpp"

namespace loopstone {
namespace {

// CARMEN takes 80 m for every SICK, whose codes for "no return" lie above (81.83 to 81.91 m).
constexpr double kCarmenMaxRange_m = 80.0;
constexpr int kScansInOneStretch = 240;
constexpr int kScansPerPlace = 16;
constexpr int kPlaces = 16;
constexpr std::int64_t kSmallFileBytes = std::int64_t{1} << 18;
constexpr std::size_t kMostRanges = std::size_t{1} << 19;
constexpr std::int64_t kMostBytes = std::int64_t{1} << 24;
constexpr int kMostParams = 2000;

struct Sample {
  struct Beam {
    float range_m;
    int index;
  };
  std::vector<Beam> beams{};
  std::vector<Pose2> front_mounts{};
  std::vector<Pose2> rear_mounts{};
  std::vector<Stamp> stamps{};
  std::vector<std::optional<Stamp>> logger_stamps{};
};

void add_scan(const CarmenScan& scan, Sample& sample, CarmenSurvey& survey) {
  survey.any_scan = true;
  if (scan.has_poses) {
    survey.scans_carry_odometry = true;
    auto& mounts = lidar_of(scan.tag) == 0 ? sample.front_mounts : sample.rear_mounts;
    mounts.push_back(scan.odom_T_robot.inverse() * scan.odom_T_lidar);
  }
  sample.stamps.push_back(scan.stamp);
  sample.logger_stamps.push_back(scan.logger_stamp);
  if (scan.beams) return;
  for (std::size_t i = 0; i < scan.raw_ranges_m.size() && sample.beams.size() < kMostRanges; ++i) {
    const float range_m = scan.raw_ranges_m[i];
    if (range_m > 0.0F && std::isfinite(range_m)) {
      sample.beams.push_back({range_m, static_cast<int>(i)});
    }
  }
}

/// Reads until `scans` scans or so many bytes have gone by.
void add_stretch(std::unique_ptr<ByteSource> source, bool from_middle, int scans, Sample& sample,
                 CarmenSurvey& survey) {
  LineReader lines(first_bytes(std::move(source), kMostBytes));
  int found = 0;
  for (bool first = true; found < scans; first = false) {
    const auto line = lines.next();
    if (!line) return;
    if (line->too_long || (first && from_middle)) continue;
    CarmenLine parsed = parse_carmen_line(line->text);
    if (const auto* other = std::get_if<CarmenOther>(&parsed)) {
      if (other->tag == "NEFF" || other->tag == "LASER_READING") survey.made_by_a_mapper = true;
    } else if (auto* param = std::get_if<CarmenParam>(&parsed)) {
      survey.any_record = true;
      if (survey.params.size() < kMostParams) {
        survey.params[std::move(param->name)] = std::move(param->value);
      }
    } else if (const auto* scan = std::get_if<CarmenScan>(&parsed)) {
      survey.any_record = true;
      add_scan(*scan, sample, survey);
      ++found;
    } else if (std::holds_alternative<CarmenOdometry>(parsed)) {
      survey.any_record = true;
    } else if (const auto* broken = std::get_if<CarmenBroken>(&parsed)) {
      const bool is_first = broken->has_tag && !survey.first_refusal && !from_middle;
      if (is_first) survey.first_refusal = {line->number, broken->reason};
    }
  }
}

template <typename Value>
Value median(std::vector<Value> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The mount that nearly all of the sample agrees on, if there is one.
std::optional<Pose2> common_mount(const std::vector<Pose2>& mounts) {
  if (mounts.empty()) return std::nullopt;
  std::vector<double> x;
  std::vector<double> y;
  std::vector<double> yaw;
  for (const Pose2& mount : mounts) {
    x.push_back(mount.x);
    y.push_back(mount.y);
    // Relative to the first, so that a mount of 180 degrees has its median away from the seam.
    yaw.push_back(wrap_angle(mount.yaw - mounts.front().yaw));
  }
  const Pose2 middle{median(x), median(y), wrap_angle(median(yaw) + mounts.front().yaw)};
  const auto far = std::count_if(mounts.begin(), mounts.end(), [&](const Pose2& mount) {
    return std::hypot(mount.x - middle.x, mount.y - middle.y) > 0.05 ||
           std::abs(wrap_angle(mount.yaw - middle.yaw)) > 0.05;
  });
  if (far * 10 > static_cast<std::ptrdiff_t>(mounts.size())) return std::nullopt;
  // So far from the robot there is no laser: the pose is another one, in another frame.
  if (std::max(std::abs(middle.x), std::abs(middle.y)) > kFarthestMountM) return std::nullopt;
  // The log prints six decimals; what is below that is rounding.
  const auto rounded = [](double value) { return std::round(value * 1e5) / 1e5; };
  return Pose2{rounded(middle.x), rounded(middle.y), rounded(middle.yaw)};
}

/// A value that stands alone at the top of all ranges and that many beams share means "no return"
/// (ACES: 50.00). Traps: a far wall seen while the robot stands still repeats its range too, but
/// only in a few neighbouring beams and with other ranges close below; a log where every range is
/// the same has no such code.
std::optional<double> saturation_value(std::vector<Sample::Beam> beams) {
  if (beams.size() < 200) return std::nullopt;
  std::sort(beams.begin(), beams.end(), [](const auto& a, const auto& b) {
    return std::pair(a.range_m, a.index) < std::pair(b.range_m, b.index);
  });
  const float top_m = beams.back().range_m;
  std::size_t at_top = 0;
  std::size_t just_below = 0;
  int different_beams = 0;
  int last_index = -1;
  for (auto beam = beams.rbegin(); beam != beams.rend(); ++beam) {
    if (beam->range_m == top_m) {
      ++at_top;
      if (beam->index != last_index) ++different_beams;
      last_index = beam->index;
    } else if (beam->range_m >= 0.98F * top_m) {
      ++just_below;
    } else {
      break;
    }
  }
  const bool stands_alone = at_top >= 10 && just_below * 5 <= at_top && different_beams >= 5;
  const bool is_rare_enough = at_top * 20 <= beams.size() * 19;
  if (!stands_alone || !is_rare_enough) return std::nullopt;
  return static_cast<double>(top_m);
}

template <typename Value>
bool all_equal(const std::vector<Value>& values) {
  return std::adjacent_find(values.begin(), values.end(), std::not_equal_to<>()) == values.end();
}

bool only_the_logger_had_a_clock(const Sample& sample) {
  const auto& written = sample.logger_stamps;
  return all_equal(sample.stamps) && !all_equal(written) &&
         std::all_of(written.begin(), written.end(),
                     [](const std::optional<Stamp>& stamp) { return stamp.has_value(); });
}

}  // namespace

std::optional<double> CarmenSurvey::param(const std::string& name) const {
  const auto found = params.find(name);
  if (found == params.end()) return std::nullopt;
  const auto value = parse_number(found->second);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

CarmenSurvey survey_carmen(const ReadableBytes& log) {
  CarmenSurvey survey;
  Sample sample;
  auto source = log.look(0);
  const std::int64_t total = source->bytes_total();
  const bool in_places = log.can_seek && total > kSmallFileBytes;
  add_stretch(std::move(source), false, in_places ? kScansPerPlace : kScansInOneStretch, sample,
              survey);
  const std::vector<std::optional<Stamp>> early_logger_stamps = sample.logger_stamps;
  if (!sample.stamps.empty()) survey.early_stamp = median(sample.stamps);
  for (int place = 1; in_places && place < kPlaces; ++place) {
    add_stretch(log.look(total / kPlaces * place), true, kScansPerPlace, sample, survey);
  }

  survey.stamps_are_the_loggers = only_the_logger_had_a_clock(sample);
  if (survey.stamps_are_the_loggers) survey.early_stamp = median(early_logger_stamps);
  survey.front_mount = common_mount(sample.front_mounts);
  survey.rear_mount = common_mount(sample.rear_mounts);
  survey.pose_is_corrected = (!sample.front_mounts.empty() && !survey.front_mount) ||
                             (!sample.rear_mounts.empty() && !survey.rear_mount);
  survey.no_return_m = kCarmenMaxRange_m;
  if (const auto limit_m = survey.param("robot_front_laser_max"); limit_m && *limit_m > 0.0) {
    survey.no_return_m = std::min(survey.no_return_m, *limit_m);
  }
  const auto saturated_m = saturation_value(std::move(sample.beams));
  if (saturated_m && *saturated_m < survey.no_return_m) {
    survey.no_return_m = *saturated_m;
    survey.no_return_by_histogram = true;
  }
  return survey;
}

}  // namespace loopstone
