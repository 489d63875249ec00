#include "formats/carmen_reader.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <utility>

#include "formats/carmen_line.hpp"
#include "formats/carmen_scan.hpp"
#include "formats/carmen_survey.hpp"
#include "formats/line_reader.hpp"
#include "formats/order_stamps.hpp"
#include "formats/skip_tally.hpp"
#include "formats/stamp_order.hpp"
#include "loopstone/base/hypotenuse.hpp"

namespace loopstone {
namespace {

/// How far the robot went over a row of its poses.
class PathLength {
 public:
  void add(const SensorMessage& message) {
    const Pose2& pose = std::get<OdometryPose>(message).odom_T_robot;
    if (last_) length_m_ += hypotenuse(pose.x - last_->x, pose.y - last_->y);
    last_ = pose;
  }
  [[nodiscard]] double length_m() const { return length_m_; }

 private:
  std::optional<Pose2> last_;
  double length_m_ = 0.0;
};

/// By the survey's rate; it has one when it needs one.
OrderStamps stamps_by_order(const CarmenSurvey& survey) {
  const bool is_needed = survey.stamps == StampUse::kOrder;
  return {is_needed ? Duration::from_seconds(1.0 / survey.scan_rate_hz) : Duration{1},
          survey.any_scan};
}

class CarmenReader final : public LogReader {
 public:
  /// \param truth  gets the true poses; may be absent
  CarmenReader(const ReadableBytes& log, LogOptions options,
               std::vector<StampedPose2>* truth = nullptr)
      : path_(log.name),
        options_(std::move(options)),
        survey_(survey_of(log)),
        lines_(log.read()),
        order_(
            survey_.scans_carry_odometry, survey_.early_stamp,
            [this](const OrderedRecord& record, const std::string& reason) {
              skip(record.line, reason, std::holds_alternative<LaserScan>(record.message));
            },
            options_.live ? StampOrder::kNone : StampOrder::kWindow),
        order_stamps_(stamps_by_order(survey_)),
        truth_(truth) {}

  std::optional<SensorMessage> next() override {
    for (;;) {
      if (auto record = by_order() ? order_stamps_.pop() : order_.pop()) {
        if (record->is_truth) {
          take_truth(std::get<OdometryPose>(record->message));
          continue;
        }
        if (record->is_part_of_a_scan) path_by_stamp_.add(record->message);
        return std::move(record->message);
      }
      if (at_end_) return std::nullopt;
      std::optional<LineReader::Line> line;
      try {
        line = lines_.next();
      } catch (const ReadingStopped&) {
        at_end_ = true;
        return std::nullopt;
      }
      if (!line) {
        at_end_ = true;
        order_.close();
        order_stamps_.close();
      } else if (line->too_long) {
        skip(line->number, "the line is longer than any scan", false);
      } else {
        take(*line);
      }
    }
  }
  ReadProgress progress() const override {
    return {lines_.source().bytes_done(), lines_.source().bytes_total()};
  }
  std::string format() const override { return "carmen"; }
  const SkippedRecords& skipped() const override { return tally_.skipped(); }

  RobotModel robot(RobotModel base) const override {
    for (int lidar = 0; lidar < kCarmenLidars; ++lidar) {
      const auto mount = carmen_mount(survey_, lidar);
      const auto index = static_cast<std::size_t>(lidar);
      // Other lasers than the front one are only known to exist when they were seen.
      if (!mount || (lidar > 0 && !survey_.mounts[index])) continue;
      if (base.lidars.size() <= index) base.lidars.resize(index + 1);
      base.lidars[index].robot_T_lidar = *mount;
      if (lidar > 0) base.lidars[index].name = name_of(lidar);
    }
    return base;
  }

  std::vector<std::string> notes() const override;
  std::vector<std::string> warnings() const override;

 private:
  std::string rate_text() const;

  CarmenSurvey survey_of(const ReadableBytes& log) const {
    CarmenSurvey survey = survey_carmen(log, options_.stamps);
    if (!survey.any_record && survey.first_refusal) {
      throw DataError({path_, survey.first_refusal->line},
                      survey.first_refusal->reason +
                          " (no line of this CARMEN log can be used; this is the first)");
    }
    if (!survey.any_record) {
      throw DataError(
          {path_},
          "holds no line of a CARMEN log (FLASER, RLASER, ROBOTLASER1, RAWLASER1, ODOM, "
          "PARAM, ...); if it is another format, convert it first");
    }
    return survey;
  }

  void skip(std::int64_t line, const std::string& reason, bool is_scan) {
    const LogProblem problem{{{path_, line}, reason}, is_scan};
    if (options_.strict) throw DataError(problem.location, reason);
    tally_.add(problem);
    if (options_.on_problem) options_.on_problem(problem);
  }

  static std::string name_of(int lidar) {
    return lidar == 1 ? "rear" : "laser" + std::to_string(lidar + 1);
  }

  bool by_order() const { return survey_.stamps == StampUse::kOrder; }

  void push(OrderedRecord record) {
    if (by_order()) {
      order_stamps_.push(std::move(record));
    } else {
      order_.push(std::move(record));
    }
  }

  /// The stamp of a record; nothing, and told, when it has none that can be used.
  std::optional<Stamp> stamp_of_line(const CarmenTimes& times, std::int64_t line, bool is_scan) {
    if (by_order()) return Stamp{};  // comes later
    const bool by_logger = survey_.stamps == StampUse::kRecord;
    const auto& stamp = by_logger ? times.logger : times.header;
    if (!stamp) {
      skip(line, by_logger ? "the logger's time is none" : times.header_problem, is_scan);
    }
    return stamp;
  }

  void take(const LineReader::Line& line) {
    CarmenLine parsed = parse_carmen_line(line.text);
    if (auto* scan = std::get_if<CarmenScan>(&parsed)) {
      take_scan(std::move(*scan), line.number);
    } else if (const auto* odometry = std::get_if<CarmenOdometry>(&parsed)) {
      if (const auto stamp = stamp_of_line(odometry->times, line.number, false)) {
        push({OdometryPose{*stamp, odometry->odom_T_robot}, line.number});
      }
    } else if (const auto* truth = std::get_if<CarmenTruth>(&parsed)) {
      take_truth_line(*truth, line.number);
    } else if (const auto* broken = std::get_if<CarmenBroken>(&parsed)) {
      skip(line.number, broken->reason, broken->is_scan);
    } else if (const auto* other = std::get_if<CarmenOther>(&parsed)) {
      if (!other->tag.empty() && (unread_.size() < 50 || unread_.count(std::string(other->tag)))) {
        ++unread_[std::string(other->tag)];
      }
    }
  }

  void take_scan(CarmenScan&& scan, std::int64_t line) {
    const auto stamp = stamp_of_line(scan.times, line, true);
    if (!stamp) return;
    if (is_second_report(scan, *stamp)) {
      ++second_reports_;
      return;
    }
    const OdometryPose odometry{*stamp, scan.odom_T_robot};
    const bool has_odometry = scan.has_poses;
    if (!has_odometry) note_unmounted(lidar_of(scan.tag));
    push({to_laser_scan(std::move(scan), *stamp, survey_), line});
    if (!has_odometry) return;
    path_as_recorded_.add(odometry);
    push({odometry, line, true});
  }

  void note_unmounted(int lidar) {
    if (!carmen_mount(survey_, lidar)) unmounted_[static_cast<std::size_t>(lidar)] = lidar > 0;
  }

  /// True poses have the stamps of the messages around them, but are none.
  void take_truth_line(const CarmenTruth& truth, std::int64_t line) {
    ++truth_lines_;
    if (by_order()) {
      order_stamps_.push({OdometryPose{Stamp{}, truth.world_T_robot}, line, false, true});
    } else if (truth_ != nullptr) {
      const auto stamp = stamp_of_line(truth.times, line, false);
      if (stamp) take_truth({*stamp, truth.world_T_robot});
    }
  }

  void take_truth(const OdometryPose& truth) {
    if (truth_ != nullptr) truth_->push_back({truth.stamp, truth.odom_T_robot});
  }

  struct Report {
    CarmenTag tag;
    Stamp stamp;
    std::size_t beams = 0;
    int others_since = 0;  ///< reports under other tags
  };

  /// FLASER, ROBOTLASER1 and RAWLASER1 may all report the same sweep. The tag seen first is kept,
  /// until it falls silent for some seconds while another goes on. Another number of beams at
  /// another moment is another sweep: scans whose beams change need another tag.
  bool is_second_report(const CarmenScan& scan, Stamp stamp) {
    constexpr int kReportsOfSilence = 10;
    auto& last = last_kept_[static_cast<std::size_t>(lidar_of(scan.tag))];
    const Report report{scan.tag, stamp, scan.raw_ranges_m.size()};
    if (last && report.tag != last->tag) {
      const bool same_moment = !by_order() && report.stamp == last->stamp;
      const bool is_silent = by_order() ? ++last->others_since > kReportsOfSilence
                                        : (report.stamp - last->stamp).seconds() >= 2.0;
      if ((report.beams == last->beams || same_moment) && !is_silent) return true;
    }
    last = report;
    return false;
  }

  std::string path_;
  LogOptions options_;
  CarmenSurvey survey_;
  LineReader lines_;
  StampOrder order_;
  OrderStamps order_stamps_;
  std::vector<StampedPose2>* truth_;
  PathLength path_as_recorded_;  ///< of the scans' poses, in the order of the file
  PathLength path_by_stamp_;     ///< and as they come out
  std::map<std::string, std::int64_t> unread_;
  SkipTally tally_;
  std::int64_t second_reports_ = 0;
  bool at_end_ = false;
  std::int64_t truth_lines_ = 0;
  std::array<std::optional<Report>, kCarmenLidars> last_kept_{};
  std::array<bool, kCarmenLidars> unmounted_{};  ///< nothing tells where they are
};

std::string text(const char* format, double value) {
  char buffer[160];
  std::snprintf(buffer, sizeof buffer, format, value);
  return buffer;
}

std::string CarmenReader::rate_text() const {
  return text(
             "the records come in the order of the file, with stamps made up for %.3g scans a "
             "second (",
             survey_.scan_rate_hz) +
         survey_.rate_origin + ")";
}

std::vector<std::string> CarmenReader::notes() const {
  std::vector<std::string> notes;
  if (survey_.made_by_a_mapper || survey_.pose_is_corrected) {
    notes.emplace_back(
        "the poses were corrected by another mapping program: they are its result, not odometry");
  }
  if (order_.records_out_of_order() > 0) {
    notes.push_back(std::to_string(order_.records_out_of_order()) +
                    " records stood out of the order of their stamps, by up to " +
                    text("%.3f s; they were put in order", order_.largest_step_back().seconds()));
  }
  if (path_by_stamp_.length_m() > 1.1 * path_as_recorded_.length_m() + 1.0) {
    notes.push_back(text("in the order of the stamps the scans run to and fro: %.0f m instead of ",
                         path_by_stamp_.length_m()) +
                    text("%.0f m; the order of the file is right and some stamps are wrong",
                         path_as_recorded_.length_m()));
  }
  if (second_reports_ > 0) {
    notes.push_back(std::to_string(second_reports_) +
                    " scans were reported a second time under another tag; one of each is used");
  }
  if (survey_.no_return_by_histogram) {
    notes.push_back(text("ranges of %.2f m stand for 'nothing within reach'", survey_.no_return_m));
  }
  for (int lidar = 0; lidar < kCarmenLidars; ++lidar) {
    const auto name = carmen_offset_param(lidar);
    if (name && survey_.param(*name) && !carmen_laser_offset(survey_, lidar)) {
      notes.push_back("PARAM " + *name +
                      text(" is %g m, which can't be; it is not used", *survey_.param(*name)));
    }
    if (unmounted_[static_cast<std::size_t>(lidar)]) {
      notes.push_back("the log does not tell where laser " + std::to_string(lidar + 1) +
                      " sits on the robot; without a robot file it is taken to be at its centre");
    }
  }
  if (options_.stamps == StampUse::kOrder) notes.push_back(rate_text() + ", as asked for");
  if (truth_lines_ > 0) {
    notes.push_back(std::to_string(truth_lines_) + " lines of " + std::string(kCarmenTruth) +
                    " hold true poses, which are no part of the measurements");
  }
  for (const auto& [tag, count] : unread_) {
    notes.push_back(std::to_string(count) + " lines of " + tag + " are not read");
  }
  return notes;
}

std::vector<std::string> CarmenReader::warnings() const {
  std::vector<std::string> warnings;
  if (survey_.stamp_fault.empty()) return warnings;
  if (survey_.stamps == StampUse::kRecord) {
    warnings.push_back(survey_.stamp_fault +
                       ": the times at which the logger wrote them down are used instead, which "
                       "come late and unevenly");
  } else if (by_order()) {
    warnings.push_back(survey_.stamp_fault + ", and the logger's times are no better: " +
                       rate_text() + "; speeds and pauses can't be trusted");
  }
  return warnings;
}

}  // namespace

std::unique_ptr<LogReader> open_carmen_log(const ReadableBytes& log, const LogOptions& options) {
  return std::make_unique<CarmenReader>(log, options);
}

Trajectory read_carmen_truth(const ReadableBytes& log, const std::string& topic,
                             const LogOptions& options) {
  std::vector<StampedPose2> poses;
  CarmenReader reader(log, options, &poses);
  while (reader.next()) {
  }
  if (options.stop && options.stop()) throw ReadingStopped();
  const std::string there =
      poses.empty() ? "there are none in it" : "there is " + std::string(kCarmenTruth);
  if (topic != kCarmenTruth || poses.empty()) {
    throw DataError({log.name}, "holds no true poses under the name '" + topic + "'; " + there);
  }
  return Trajectory(std::move(poses));
}

std::unique_ptr<LogReader> read_carmen_log(std::string_view bytes, const LogOptions& options,
                                           const std::string& name) {
  return open_carmen_log(readable_memory(bytes, name), options);
}

}  // namespace loopstone
