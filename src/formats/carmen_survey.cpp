#include "formats/carmen_survey.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "formats/carmen_line.hpp"
#include "formats/carmen_times.hpp"
#include "formats/line_reader.hpp"
#include "formats/text_numbers.hpp"
#include "loopstone/base/hypotenuse.hpp"
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
  std::array<std::vector<Pose2>, kCarmenLidars> mounts{};
  CarmenTimesSample times{};
};

/// A scan whose times are none of the usual kind is no evidence that this is a log of ours: stamps
/// in milliseconds are refused.
bool has_usual_times(const CarmenTimes& times) { return times.header.has_value(); }

void add_scan(const CarmenScan& scan, Sample& sample, CarmenSurvey& survey) {
  const auto lidar = static_cast<std::size_t>(lidar_of(scan.tag));
  survey.any_scan = true;
  survey.seen[lidar] = true;
  if (scan.has_poses) {
    survey.scans_carry_odometry = true;
    sample.mounts[lidar].push_back(scan.odom_T_robot.inverse() * scan.odom_T_lidar);
  }
  sample.times.add(scan);
  if (scan.beams) return;
  for (std::size_t i = 0; i < scan.raw_ranges_m.size() && sample.beams.size() < kMostRanges; ++i) {
    const float range_m = scan.raw_ranges_m[i];
    if (range_m > 0.0F && std::isfinite(range_m)) {
      sample.beams.push_back({range_m, static_cast<int>(i)});
    }
  }
}

void note_refusal(const std::string& reason, std::int64_t line, CarmenSurvey& survey) {
  if (!reason.empty() && !survey.first_refusal) survey.first_refusal = {line, reason};
}

/// Reads until `scans` scans or so many bytes have gone by.
void add_stretch(std::unique_ptr<ByteSource> source, bool from_middle, int scans, Sample& sample,
                 CarmenSurvey& survey) {
  LineReader lines(first_bytes(std::move(source), kMostBytes));
  sample.times.begin_stretch();
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
      if (has_usual_times(scan->times)) survey.any_record = true;
      if (!from_middle) note_refusal(scan->times.header_problem, line->number, survey);
      add_scan(*scan, sample, survey);
      ++found;
    } else if (const auto* odometry = std::get_if<CarmenOdometry>(&parsed)) {
      if (has_usual_times(odometry->times)) survey.any_record = true;
      if (!from_middle) note_refusal(odometry->times.header_problem, line->number, survey);
    } else if (const auto* broken = std::get_if<CarmenBroken>(&parsed)) {
      if (broken->has_tag && !from_middle) note_refusal(broken->reason, line->number, survey);
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
    return hypotenuse(mount.x - middle.x, mount.y - middle.y) > 0.05 ||
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

}  // namespace

std::optional<double> CarmenSurvey::param(const std::string& name) const {
  const auto found = params.find(name);
  if (found == params.end()) return std::nullopt;
  const auto value = parse_number(found->second);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

CarmenSurvey survey_carmen(const ReadableBytes& log, StampUse wanted) {
  CarmenSurvey survey;
  Sample sample;
  auto source = log.look(0);
  const std::int64_t total = source->bytes_total();
  const bool in_places = log.can_seek && total > kSmallFileBytes;
  add_stretch(std::move(source), false, in_places ? kScansPerPlace : kScansInOneStretch, sample,
              survey);
  for (int place = 1; in_places && place < kPlaces; ++place) {
    add_stretch(log.look(total / kPlaces * place), true, kScansPerPlace, sample, survey);
  }

  choose_stamps(sample.times, wanted, survey);
  for (std::size_t lidar = 0; lidar < survey.mounts.size(); ++lidar) {
    survey.mounts[lidar] = common_mount(sample.mounts[lidar]);
    if (!sample.mounts[lidar].empty() && !survey.mounts[lidar]) survey.pose_is_corrected = true;
  }
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
