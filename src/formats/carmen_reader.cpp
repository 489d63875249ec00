#include "formats/carmen_reader.hpp"

#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <utility>

#include "formats/carmen_line.hpp"
#include "formats/carmen_scan.hpp"
#include "formats/carmen_survey.hpp"
#include "formats/line_reader.hpp"
#include "formats/skip_tally.hpp"
#include "formats/stamp_order.hpp"

namespace loopstone {
namespace {

/// How far the robot went over a row of its poses.
class PathLength {
 public:
  void add(const SensorMessage& message) {
    const Pose2& pose = std::get<OdometryPose>(message).odom_T_robot;
    if (last_) length_m_ += std::hypot(pose.x - last_->x, pose.y - last_->y);
    last_ = pose;
  }
  [[nodiscard]] double length_m() const { return length_m_; }

 private:
  std::optional<Pose2> last_;
  double length_m_ = 0.0;
};

class CarmenReader final : public LogReader {
 public:
  CarmenReader(const ReadableBytes& log, LogOptions options)
      : path_(log.name),
        options_(std::move(options)),
        survey_(survey_of(log)),
        lines_(log.read()),
        order_(survey_.scans_carry_odometry, survey_.early_stamp,
               [this](const OrderedRecord& record, const std::string& reason) {
                 skip(record.line, reason, std::holds_alternative<LaserScan>(record.message));
               }) {}

  std::optional<SensorMessage> next() override {
    for (;;) {
      if (auto record = order_.pop()) {
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
    for (int lidar = 0; lidar < 2; ++lidar) {
      const auto mount = carmen_mount(survey_, lidar);
      const auto index = static_cast<std::size_t>(lidar);
      // A rear laser is only known to exist when it was seen.
      if (!mount || (lidar == 1 && !survey_.rear_mount)) continue;
      if (base.lidars.size() <= index) base.lidars.resize(index + 1);
      base.lidars[index].robot_T_lidar = *mount;
      if (lidar == 1) base.lidars[index].name = "rear";
    }
    return base;
  }

  std::vector<std::string> notes() const override;
  std::vector<std::string> warnings() const override;

 private:
  CarmenSurvey survey_of(const ReadableBytes& log) const {
    CarmenSurvey survey = survey_carmen(log);
    if (!survey.any_record && survey.first_refusal) {
      throw DataError({path_, survey.first_refusal->line},
                      survey.first_refusal->reason +
                          " (no line of this CARMEN log can be used; this is the first)");
    }
    if (!survey.any_record) {
      throw DataError(
          {path_},
          "holds no line of a CARMEN log (FLASER, RLASER, ROBOTLASER1, RAWLASER1, ODOM, "
          "PARAM); if it is another format, convert it first");
    }
    return survey;
  }

  void skip(std::int64_t line, const std::string& reason, bool is_scan) {
    const LogProblem problem{{{path_, line}, reason}, is_scan};
    if (options_.strict) throw DataError(problem.location, reason);
    tally_.add(problem);
    if (options_.on_problem) options_.on_problem(problem);
  }

  /// Puts the logger's time in the place of a stamp that was never set.
  template <typename Record>
  void repair_stamp(Record& record) const {
    if (survey_.stamps_are_the_loggers && record.logger_stamp) record.stamp = *record.logger_stamp;
  }

  void take(const LineReader::Line& line) {
    CarmenLine parsed = parse_carmen_line(line.text);
    if (auto* scan = std::get_if<CarmenScan>(&parsed)) {
      repair_stamp(*scan);
      take_scan(std::move(*scan), line.number);
    } else if (auto* odometry = std::get_if<CarmenOdometry>(&parsed)) {
      repair_stamp(*odometry);
      order_.push({OdometryPose{odometry->stamp, odometry->odom_T_robot}, line.number});
    } else if (const auto* broken = std::get_if<CarmenBroken>(&parsed)) {
      skip(line.number, broken->reason, broken->is_scan);
    } else if (const auto* other = std::get_if<CarmenOther>(&parsed)) {
      if (!other->tag.empty() && (unread_.size() < 50 || unread_.count(std::string(other->tag)))) {
        ++unread_[std::string(other->tag)];
      }
    }
  }

  void take_scan(CarmenScan&& scan, std::int64_t line) {
    if (is_second_report(scan)) {
      ++second_reports_;
      return;
    }
    const OdometryPose odometry{scan.stamp, scan.odom_T_robot};
    const bool has_odometry = scan.has_poses;
    order_.push({to_laser_scan(std::move(scan), survey_), line});
    if (!has_odometry) return;
    path_as_recorded_.add(odometry);
    order_.push({odometry, line, true});
  }

  struct FrontScan {
    CarmenTag tag;
    Stamp stamp;
    std::size_t beams = 0;
  };

  /// FLASER, ROBOTLASER1 and RAWLASER1 may all report the same sweep. The tag seen first is kept,
  /// until it falls silent for some seconds while another goes on. Another number of beams at
  /// another moment is another sweep: scans whose beams change need another tag.
  bool is_second_report(const CarmenScan& scan) {
    if (lidar_of(scan.tag) != 0) return false;
    const FrontScan front{scan.tag, scan.stamp, scan.raw_ranges_m.size()};
    if (last_front_ && front.tag != last_front_->tag) {
      const double silent_s = (front.stamp - last_front_->stamp).seconds();
      const bool may_be_the_same =
          front.beams == last_front_->beams || front.stamp == last_front_->stamp;
      if (may_be_the_same && silent_s < 2.0) return true;
    }
    last_front_ = front;
    return false;
  }

  std::string path_;
  LogOptions options_;
  CarmenSurvey survey_;
  LineReader lines_;
  StampOrder order_;
  PathLength path_as_recorded_;  ///< of the scans' poses, in the order of the file
  PathLength path_by_stamp_;     ///< and as they come out
  std::map<std::string, std::int64_t> unread_;
  SkipTally tally_;
  std::int64_t second_reports_ = 0;
  bool at_end_ = false;
  std::optional<FrontScan> last_front_{};  ///< that was kept
};

std::string text(const char* format, double value) {
  char buffer[160];
  std::snprintf(buffer, sizeof buffer, format, value);
  return buffer;
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
  for (int lidar = 0; lidar < 2; ++lidar) {
    const char* const name = lidar == 0 ? "robot_frontlaser_offset" : "robot_rearlaser_offset";
    if (survey_.param(name) && !carmen_laser_offset(survey_, lidar)) {
      notes.push_back("PARAM " + std::string(name) +
                      text(" is %g m, which can't be; it is not used", *survey_.param(name)));
    }
  }
  for (const auto& [tag, count] : unread_) {
    notes.push_back(std::to_string(count) + " lines of " + tag + " are not read");
  }
  return notes;
}

std::vector<std::string> CarmenReader::warnings() const {
  std::vector<std::string> warnings;
  if (survey_.stamps_are_the_loggers) {
    warnings.emplace_back(
        "all scans have the same stamp: the times at which the logger wrote them down are used "
        "instead, which come late and unevenly");
  }
  return warnings;
}

}  // namespace

std::unique_ptr<LogReader> open_carmen_log(const ReadableBytes& log, const LogOptions& options) {
  return std::make_unique<CarmenReader>(log, options);
}

std::unique_ptr<LogReader> read_carmen_log(std::string_view bytes, const LogOptions& options,
                                           const std::string& name) {
  return open_carmen_log(readable_memory(bytes, name), options);
}

}  // namespace loopstone
