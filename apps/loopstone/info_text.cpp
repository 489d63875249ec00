#include "info_text.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <ctime>

#include "loopstone/formats/log_format.hpp"
#include "loopstone/geometry/angle.hpp"
#include "terminal_text.hpp"

namespace loopstone::app {

namespace {

constexpr std::array<const char*, 8> kHistogramLabels{"below 0.5 m", "0.5 to 1 m",  "1 to 2 m",
                                                      "2 to 4 m",    "4 to 8 m",    "8 to 16 m",
                                                      "16 to 32 m",  "from 32 m on"};

/// Colours where a person reads: a terminal, unless NO_COLOR says otherwise (https://no-color.org).
class Paint {
 public:
  Paint() {
    const char* const no_colour = std::getenv("NO_COLOR");
    on_ = isatty(STDOUT_FILENO) != 0 && (no_colour == nullptr || *no_colour == '\0');
  }
  [[nodiscard]] std::string bold(const std::string& text) const { return dress("1", text); }
  [[nodiscard]] std::string red(const std::string& text) const { return dress("1;31", text); }
  [[nodiscard]] std::string yellow(const std::string& text) const { return dress("33", text); }
  [[nodiscard]] std::string green(const std::string& text) const { return dress("1;32", text); }

 private:
  [[nodiscard]] std::string dress(const char* code, const std::string& text) const {
    return on_ ? fmt::format("\x1b[{}m{}\x1b[0m", code, text) : text;
  }
  bool on_ = false;
};

double percent(std::int64_t part, std::int64_t whole) {
  return whole == 0 ? 0.0 : 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

std::string size_text(std::int64_t bytes) {
  const auto value = static_cast<double>(bytes);
  if (value < 1e3) return fmt::format("{} bytes", bytes);
  return value < 1e6 ? fmt::format("{:.1f} kB", value / 1e3)
                     : fmt::format("{:.1f} MB", value / 1e6);
}

std::string duration_text(double seconds) {
  if (seconds < 60.0) return fmt::format("{:.1f} s", seconds);
  const auto whole = static_cast<std::int64_t>(seconds);
  if (whole < 3600) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return fmt::format("{} h {} min", whole / 3600, whole / 60 % 60);
}

/// The date, when the clock can be one that counts from 1970: later than 1990.
std::string start_text(Stamp stamp) {
  constexpr std::int64_t k1990_s = 631152000;
  const std::int64_t seconds = stamp.nanoseconds / 1'000'000'000;
  if (seconds < k1990_s) return fmt::format("{:.3f} s on its own clock", stamp.seconds());
  return fmt::format("{:%Y-%m-%d %H:%M:%S} UTC", fmt::gmtime(static_cast<std::time_t>(seconds)));
}

std::string timing_row(const std::string& name, const TimingSummary& timing, Stamp start) {
  const std::string rate = timing.rate_hz > 0.0 ? fmt::format("{:.1f} Hz", timing.rate_hz) : "";
  const std::string gap = timing.records < 2
                              ? ""
                              : fmt::format("{:.3f} s at +{:.1f} s", timing.largest_gap_s,
                                            (timing.largest_gap_at - start).seconds());
  return fmt::format("  {:<12}{:>10}  {:>10}   {}\n", name, timing.records, rate, gap);
}

std::string sensors_table(const LogSummary& summary, const Paint& paint) {
  std::string text = paint.bold(fmt::format("  {:<12}{:>10}  {:>10}   {}", "sensor", "records",
                                            "rate", "largest gap")) +
                     "\n";
  for (const LidarSummary& lidar : summary.lidars) {
    text += timing_row(summary.name_of(lidar), lidar.timing, *summary.first);
  }
  if (summary.odometry) text += timing_row("odometry", summary.odometry->timing, *summary.first);
  if (summary.wheels) text += timing_row("wheels", summary.wheels->timing, *summary.first);
  if (summary.imu) text += timing_row("imu", summary.imu->timing, *summary.first);
  if (summary.camera && summary.camera->depth.records > 0) {
    text += timing_row("depth", summary.camera->depth, *summary.first);
  }
  if (summary.camera && summary.camera->colour.records > 0) {
    text += timing_row("colour", summary.camera->colour, *summary.first);
  }
  return text;
}

std::string row(const char* label, const std::string& value) {
  return fmt::format("  {:<12}{}\n", label, value);
}

std::string beams_text(const BeamLayout& layout) {
  if (layout.beams == 1) return "1";
  const double last_rad =
      layout.angle_min_rad + static_cast<double>(layout.beams - 1) * layout.angle_increment_rad;
  return fmt::format("{} every {:.4g} deg, {:+.1f} to {:+.1f} deg (field of view {:.1f} deg)",
                     layout.beams, degrees(layout.angle_increment_rad),
                     degrees(layout.angle_min_rad), degrees(last_rad),
                     degrees(layout.field_of_view_rad()));
}

std::string classes_text(const RangeClasses& ranges) {
  const auto part = [&](std::int64_t count, const char* name) {
    return row("",
               fmt::format("{:>6.2f} %  {:>10}  {}", percent(count, ranges.total()), count, name));
  };
  std::string text = part(ranges.returns, "returns");
  text += part(ranges.no_return, "nothing within reach");
  text += part(ranges.bad, "bad (not a number, 0, negative)");
  if (ranges.too_near > 0) text += part(ranges.too_near, "nearer than the scanner can measure");
  if (ranges.too_far > 0) text += part(ranges.too_far, "farther than the scanner can measure");
  return text;
}

std::string histogram_text(const LidarSummary& lidar) {
  std::int64_t most = 1;
  for (const std::int64_t count : lidar.range_histogram) most = std::max(most, count);
  std::string text;
  for (std::size_t i = 0; i < lidar.range_histogram.size(); ++i) {
    const std::int64_t count = lidar.range_histogram[i];
    const auto width = static_cast<std::size_t>((count * 40 + most - 1) / most);
    text += row("", fmt::format("{:>12}  {:>6.2f} %  {}", kHistogramLabels[i],
                                percent(count, lidar.ranges.returns), std::string(width, '#')));
  }
  return text;
}

std::string lidar_text(const LogSummary& summary, const LidarSummary& lidar, const Paint& paint) {
  std::string text = "\n" + paint.bold(summary.name_of(lidar)) + "\n";
  for (const BeamLayout& layout : lidar.layouts) {
    const std::string scans =
        lidar.layouts.size() == 1 ? "" : fmt::format(" in {} scans", layout.scans);
    text += row(&layout == &lidar.layouts.front() ? "beams" : "", beams_text(layout) + scans);
  }
  text += row("limits", fmt::format("{:.2f} to {:.2f} m", lidar.range_min_m, lidar.range_max_m));
  if (lidar.time_increment_s != 0.0) {
    const auto beams = static_cast<double>(lidar.layouts.front().beams);
    text += row("sweep", fmt::format("{:.4f} s from the first to the last beam",
                                     lidar.time_increment_s * beams));
  }
  text += row("mount", lidar.robot_T_lidar
                           ? fmt::format("x {:.3f} m, y {:.3f} m, yaw {:.1f} deg (the log says so)",
                                         lidar.robot_T_lidar->x, lidar.robot_T_lidar->y,
                                         degrees(lidar.robot_T_lidar->yaw))
                           : "not in the log; --robot FILE gives it");
  text += row("ranges", fmt::format("{} beams", lidar.ranges.total()));
  text += classes_text(lidar.ranges);
  if (lidar.ranges.returns > 0) {
    const auto& p = lidar.range_percentiles_m;
    text +=
        row("returns", fmt::format("{:.2f} to {:.2f} m, half of them {:.2f} to {:.2f} m, median "
                                   "{:.2f} m",
                                   p[0], p[6], p[2], p[4], p[3]));
    text += histogram_text(lidar);
  }
  return text;
}

std::string size_text(const PictureSize& size) {
  return fmt::format("{} x {} pixels", size.width_px, size.height_px);
}

std::string camera_text(const CameraSummary& camera, const Paint& paint) {
  std::string text = "\n" + paint.bold("camera") + "\n";
  if (camera.depth.records > 0) text += row("depth", size_text(camera.depth_size));
  if (camera.colour.records > 0) text += row("colour", size_text(camera.colour_size));
  if (camera.pairs > 0) {
    text += row("pairs", fmt::format("{}; colour is taken {:+.1f} ms after depth (median), at most "
                                     "{:+.1f} ms",
                                     camera.pairs, 1e3 * camera.median_offset_s,
                                     1e3 * camera.largest_offset_s));
  }
  return text;
}

std::string motion_text(const LogSummary& summary, const Paint& paint) {
  std::string text;
  if (summary.odometry) {
    text += row("path", fmt::format("{:.1f} m and {:.0f} turns by the log's own odometry",
                                    summary.odometry->path_length_m,
                                    summary.odometry->turned_rad / (2.0 * kPi)));
  }
  if (summary.wheels) {
    const auto& counts = summary.wheels->travelled_counts;
    text += row("wheels", fmt::format("{} / {} / {} / {} counts (front right, front left, rear "
                                      "right, rear left)",
                                      counts[0], counts[1], counts[2], counts[3]));
  }
  if (summary.imu) {
    text += row("imu", fmt::format("{:.2f} m/s^2 at rest, {:.0f} % of it along z; yaw rate {:+.4f} "
                                   "rad/s most of the time",
                                   summary.imu->median_acceleration_m_s2,
                                   100.0 * summary.imu->gravity_along_z,
                                   summary.imu->median_yaw_rate_rad_s));
  }
  return text.empty() ? text : "\n" + paint.bold("motion") + "\n" + text;
}

/// Every topic of a recording, those that are used first.
std::string topics_text(const LogSummary& summary, const Paint& paint) {
  if (summary.topics.empty()) return {};
  std::vector<const TopicSummary*> topics;
  std::size_t name_width = 5;
  std::size_t type_width = 4;
  for (const TopicSummary& topic : summary.topics) {
    topics.push_back(&topic);
    name_width = std::max(name_width, topic.name.size());
    type_width = std::max(type_width, topic.type.size());
  }
  std::ranges::stable_sort(topics, {}, [](const TopicSummary* topic) {
    return topic->role == TopicRole::kNone ? kWords<TopicRole>.size()
                                           : static_cast<std::size_t>(topic->role);
  });
  std::string text = "\n" +
                     paint.bold(fmt::format("  {:<{}}  {:<{}}  {:>9}  {:>9}  used as", "topic",
                                            name_width, "type", type_width, "messages", "rate")) +
                     "\n";
  for (const TopicSummary* topic : topics) {
    const std::string rate =
        topic->rate_hz > 0.0 ? fmt::format("{:.1f} Hz", topic->rate_hz) : std::string();
    const bool used = topic->role != TopicRole::kNone;
    std::string use = used ? std::string(to_string(topic->role)) : "-";
    if (!topic->remark.empty()) use += (used ? "; " : " ") + topic->remark;
    text += terminal_text(fmt::format("  {:<{}}  {:<{}}  {:>9}  {:>9}  {}", topic->name, name_width,
                                      topic->type, type_width, topic->messages, rate, use)) +
            "\n";
  }
  for (const std::string& choice : summary.choices) {
    text += (&choice == &summary.choices.front() ? "\n  " : "  ") + terminal_text(choice) + "\n";
  }
  return text;
}

std::string findings_text(const LogSummary& summary, const Paint& paint) {
  std::string text;
  for (const Finding& finding : summary.findings) {
    const std::string mark = finding.severity == Severity::kError     ? paint.red("  error    ")
                             : finding.severity == Severity::kWarning ? paint.yellow("  warning  ")
                                                                      : "  note     ";
    text += mark + terminal_text(finding.text) + "\n";
  }
  return text.empty() ? text : "\n" + text;
}

}  // namespace

std::string info_text(const std::string& path, const LogSummary& summary) {
  const Paint paint;
  const LogFormat* const format = find_log_format(summary.format);
  std::string text =
      fmt::format("{}  {} log, {}\n", paint.bold(terminal_text(path)),
                  format != nullptr ? format->title : summary.format, size_text(summary.bytes));
  if (summary.first) {
    text += fmt::format("{}, from {}\n\n", duration_text(summary.duration_s()),
                        start_text(*summary.first));
    text += sensors_table(summary, paint);
  }
  text += topics_text(summary, paint);
  for (const LidarSummary& lidar : summary.lidars) text += lidar_text(summary, lidar, paint);
  if (summary.camera) text += camera_text(*summary.camera, paint);
  text += motion_text(summary, paint);
  text += findings_text(summary, paint);
  const std::string verdict = summary.verdict();
  const Severity worst = summary.worst();
  text += "\n" +
          (worst == Severity::kError     ? paint.red(verdict)
           : worst == Severity::kWarning ? paint.yellow(verdict)
                                         : paint.green(verdict)) +
          "\n";
  return text;
}

}  // namespace loopstone::app
