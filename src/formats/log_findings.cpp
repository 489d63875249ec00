#include "formats/log_findings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "loopstone/base/error.hpp"
#include "loopstone/geometry/angle.hpp"

namespace loopstone {
namespace {

class Findings {
 public:
  void note(std::string text) { all_.push_back({Severity::kNote, std::move(text)}); }
  void warn(std::string text) { all_.push_back({Severity::kWarning, std::move(text)}); }
  void add(Finding finding) { all_.push_back(std::move(finding)); }
  void error(std::string text) { all_.push_back({Severity::kError, std::move(text)}); }

  std::vector<Finding> sorted() && {
    std::stable_sort(all_.begin(), all_.end(),
                     [](const Finding& a, const Finding& b) { return a.severity > b.severity; });
    return std::move(all_);
  }

 private:
  std::vector<Finding> all_;
};

double share(std::int64_t part, std::int64_t whole) {
  return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
}

void look_at_timing(const TimingSummary& timing, const std::string& name, Stamp start,
                    Findings& findings) {
  if (timing.gaps == 0) return;
  findings.note(
      fmt::format("{}: {} {} of more than half a second without a record; the largest is "
                  "{:.1f} s, {:.1f} s after the start",
                  name, timing.gaps, timing.gaps == 1 ? "gap" : "gaps", timing.largest_gap_s,
                  (timing.largest_gap_at - start).seconds()));
}

void look_at_ranges(const LidarSummary& lidar, const std::string& name, Findings& findings) {
  const RangeClasses& ranges = lidar.ranges;
  const double bad = share(ranges.bad + ranges.too_near + ranges.too_far, ranges.total());
  if (ranges.returns == 0) {
    findings.error(name + ": no beam ever saw anything; are the ranges in metres?");
    return;
  }
  if (lidar.range_percentiles_m.front() == lidar.range_percentiles_m.back() &&
      ranges.returns > 100) {
    findings.error(fmt::format("{}: all ranges are {:.2f} m; the scanner did not measure", name,
                               lidar.range_percentiles_m.front()));
    return;
  }
  if (bad > 0.2) {
    findings.warn(
        fmt::format("{}: {:.0f} % of the beams are bad (not a number, 0, negative or "
                    "outside the scanner's limits)",
                    name, 100.0 * bad));
  }
  if (share(ranges.returns, ranges.total()) < 0.3) {
    findings.warn(
        fmt::format("{}: only {:.0f} % of the beams see anything; a large open place, or "
                    "a wrong maximum range",
                    name, 100.0 * share(ranges.returns, ranges.total())));
  }
  if (lidar.range_percentiles_m[3] > 100.0) {
    findings.warn(name + ": half of the ranges are above 100 m; are they in centimetres?");
  }
  if (lidar.range_percentiles_m[5] < 0.05) {
    findings.warn(name + ": nearly all ranges are below 5 cm; are they in another unit?");
  }
}

void look_at_lidar(const LidarSummary& lidar, const std::string& name, Stamp start,
                   Findings& findings) {
  look_at_ranges(lidar, name, findings);
  look_at_timing(lidar.timing, name, start, findings);
  if (lidar.layouts.size() > 1) {
    std::string counts;
    for (const BeamLayout& layout : lidar.layouts) {
      counts += fmt::format("{}{} x {}", counts.empty() ? "" : ", ", layout.scans, layout.beams);
    }
    findings.note(name + ": scans with different beams (scans x beams: " + counts +
                  "); each is used as it is");
  }
  const double field_deg = degrees(lidar.layouts.front().field_of_view_rad());
  if (field_deg < 90.0) {
    findings.warn(
        fmt::format("{}: a field of view of {:.0f} deg is narrow for mapping", name, field_deg));
  }
  if (lidar.layouts.front().angle_increment_rad < 0.0) {
    findings.note(name + ": the beams run clockwise");
  }
  if (share(lidar.repeated_scans, lidar.timing.records) > 0.2) {
    findings.warn(
        fmt::format("{}: {} scans repeat the one before bit by bit; the recorder may be "
                    "faster than the scanner",
                    name, lidar.repeated_scans));
  }
  if (lidar.timing.records > 1 && lidar.timing.rate_hz < 1.0) {
    findings.warn(
        fmt::format("{}: {:.2f} scans a second are few; without good odometry the map "
                    "may break",
                    name, lidar.timing.rate_hz));
  }
}

void look_at_odometry(const LogSummary& summary, Findings& findings) {
  const OdometrySummary& odometry = *summary.odometry;
  if (odometry.timing.records > 10 && odometry.path_length_m < 0.01 &&
      odometry.turned_rad < radians(0.5)) {
    findings.warn(
        "odometry: the pose never changes; the robot stood still, or its odometry was "
        "not recorded");
  }
  if (odometry.jumps > 0) {
    findings.note(
        fmt::format("odometry: {} jumps of up to {:.2f} m at more than 10 m/s: wrong "
                    "stamps, or odometry that was reset",
                    odometry.jumps, odometry.largest_step_m));
  }
}

void look_at_wheels(const WheelSummary& wheels, Findings& findings) {
  constexpr std::array<const char*, 4> kNames{"front right", "front left", "rear right",
                                              "rear left"};
  const auto& counts = wheels.travelled_counts;
  const std::int64_t most = *std::max_element(counts.begin(), counts.end());
  if (most == 0 && wheels.timing.records > 10) {
    findings.warn("wheels: no wheel ever turned");
  }
  for (std::size_t wheel = 0; wheel < 4; ++wheel) {
    if (counts[wheel] * 10 < most && most > 100) {
      findings.warn(
          fmt::format("wheels: the {} encoder hardly counts ({} against {}); is it broken?",
                      kNames[wheel], counts[wheel], most));
    }
  }
}

void look_at_imu(const ImuSummary& imu, Findings& findings) {
  const double gravity_m_s2 = imu.median_acceleration_m_s2;
  if (gravity_m_s2 > 0.5 && gravity_m_s2 < 2.0) {
    findings.warn("imu: the accelerations seem to be in g, not in m/s^2");
  } else if (std::abs(gravity_m_s2 - 9.81) > 1.0) {
    findings.warn(fmt::format("imu: the acceleration at rest is {:.2f} m/s^2; 9.81 was expected",
                              gravity_m_s2));
  } else if (imu.gravity_along_z < 0.8) {
    findings.warn(
        fmt::format("imu: gravity is not along +z (z carries {:.0f} % of it): the axes "
                    "are not those of the robot, so the gyro's z is not its yaw rate",
                    100.0 * imu.gravity_along_z));
  }
  if (std::abs(imu.median_yaw_rate_rad_s) > 0.02) {
    findings.warn(
        fmt::format("imu: the gyro shows {:+.3f} rad/s about z most of the time: a large "
                    "bias, or a robot that always turns",
                    imu.median_yaw_rate_rad_s));
  }
}

void look_at_camera(const CameraSummary& camera, Findings& findings) {
  for (const PictureSize* size : {&camera.depth_size, &camera.colour_size}) {
    if (!size->problem.empty()) findings.warn("camera: " + size->problem);
  }
  const std::int64_t most = std::max(camera.depth.records, camera.colour.records);
  if (camera.depth.records == 0 || camera.colour.records == 0) {
    findings.note(fmt::format("camera: there are only {} pictures",
                              camera.depth.records == 0 ? "colour" : "depth"));
  } else if (share(camera.pairs, most) < 0.5) {
    findings.warn(
        fmt::format("camera: only {} of {} pictures find a partner of the other kind in time; do "
                    "both cameras share a clock?",
                    camera.pairs, most));
  }
}

/// The part of the scans' time that a source of motion covers.
double covered(const TimingSummary& motion, const LogSummary& summary) {
  const TimingSummary& scans = summary.lidars.front().timing;
  const double wanted_s = (scans.last - scans.first).seconds();
  const double common_s =
      (std::min(scans.last, motion.last) - std::max(scans.first, motion.first)).seconds();
  return wanted_s <= 0.0 ? 1.0 : std::max(0.0, common_s) / wanted_s;
}

void look_at_motion(const LogSummary& summary, Findings& findings) {
  const bool has_scans = !summary.lidars.empty();
  if (!summary.odometry && !summary.wheels) {
    findings.note("no odometry: the map has to be made from the laser alone");
    return;
  }
  if (!has_scans) return;
  double best = 0.0;
  if (summary.odometry) best = std::max(best, covered(summary.odometry->timing, summary));
  if (summary.wheels) best = std::max(best, covered(summary.wheels->timing, summary));
  if (best < 0.9) {
    findings.warn(
        fmt::format("odometry covers only {:.0f} % of the time of the scans; do the "
                    "sensors share a clock?",
                    100.0 * best));
  }
}

}  // namespace

std::int64_t LogSummary::scans() const {
  std::int64_t sum = 0;
  for (const LidarSummary& lidar : lidars) sum += lidar.timing.records;
  return sum;
}

std::string LogSummary::name_of(const LidarSummary& lidar) const {
  return lidars.size() == 1 ? "laser" : fmt::format("laser {}", lidar.lidar + 1);
}

Severity LogSummary::worst() const {
  Severity worst = Severity::kNote;
  for (const Finding& finding : findings) worst = std::max(worst, finding.severity);
  return worst;
}

std::string LogSummary::verdict() const {
  if (!complete) return "interrupted: only a part of the log was looked at";
  switch (worst()) {
    case Severity::kError:
      return "no map can be made of this log";
    case Severity::kWarning:
      return "a map can be made, but look at the warnings first";
    case Severity::kNote:
      break;
  }
  return "ready: loopstone map LOG -o OUT";
}

std::optional<Finding> judge(const LeftOut& left_out) {
  constexpr double kWorthAWarning = 0.05;
  constexpr double kHardlyAnythingLeft = 0.9;
  if (left_out.skipped.records == 0) return std::nullopt;
  // Scans are what a map can't do without; what else is lost makes it worse.
  const double needed = left_out.scans() > 0 ? left_out.scan_share() : left_out.record_share();
  const Severity severity = needed > kHardlyAnythingLeft        ? Severity::kError
                            : left_out.share() > kWorthAWarning ? Severity::kWarning
                                                                : Severity::kNote;
  return Finding{severity, left_out.sentence()};
}

std::optional<Finding> judge(const LeftOut& left_out, const std::string& path) {
  auto finding = judge(left_out);
  if (finding && finding->severity == Severity::kError)
    throw DataError({path}, "nothing can be made of this log: " + finding->text);
  return finding;
}

std::vector<Finding> find_suspicious(const LogSummary& summary,
                                     const std::vector<std::string>& notes,
                                     const std::vector<std::string>& warnings) {
  Findings findings;
  const SkippedRecords& skipped = summary.left_out.skipped;
  if (summary.lidars.empty() && skipped.scans > 0) {
    findings.error("no laser scan can be used: this log can't become a map");
  } else if (summary.lidars.empty()) {
    findings.error("no laser scans: this log can't become a map (odometry can be computed)");
  }
  for (const LidarSummary& lidar : summary.lidars) {
    look_at_lidar(lidar, summary.name_of(lidar), *summary.first, findings);
  }
  look_at_motion(summary, findings);
  if (summary.odometry) look_at_odometry(summary, findings);
  if (summary.wheels) {
    look_at_wheels(*summary.wheels, findings);
    look_at_timing(summary.wheels->timing, "wheels", *summary.first, findings);
  }
  if (summary.imu) {
    look_at_imu(*summary.imu, findings);
    look_at_timing(summary.imu->timing, "imu", *summary.first, findings);
  }
  if (summary.camera) look_at_camera(*summary.camera, findings);
  if (auto left_out = judge(summary.left_out)) findings.add(std::move(*left_out));
  for (const std::string& warning : warnings) findings.warn(warning);
  for (const std::string& note : notes) findings.note(note);
  return std::move(findings).sorted();
}

}  // namespace loopstone
