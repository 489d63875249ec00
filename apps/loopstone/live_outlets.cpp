#include "live_outlets.hpp"

#include <fcntl.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <exception>
#include <nlohmann/json.hpp>
#include <utility>

#include "loopstone/base/error.hpp"
#include "loopstone/geometry/covariance.hpp"

namespace loopstone::app {

namespace {

using Json = nlohmann::ordered_json;

Json json_of(const Pose2& pose) { return Json::array({pose.x, pose.y, pose.yaw}); }

Json line_of(Stamp stamp, const Pose2& map_T_robot, const Pose2& odom_T_robot,
             const Eigen::Matrix3d& covariance, std::string_view status) {
  return {{"t", stamp.seconds()},
          {"map_T_robot", json_of(map_T_robot)},
          {"odom_T_robot", json_of(odom_T_robot)},
          {"sigma_m", largest_sigma(covariance.topLeftCorner<2, 2>())},
          {"sigma_rad", std::sqrt(std::max(covariance(2, 2), 0.0))},
          {"status", status}};
}

}  // namespace

PoseLines::PoseLines(const std::string& path, const AppContext& context)
    : path_(path), context_(context) {
  if (path.empty()) return;
  // Who reads them may go before this run does.
  std::signal(SIGPIPE, SIG_IGN);
  if (path == "-") {
    file_ = stdout;
    return;
  }
  file_ = std::fopen(path.c_str(), "w");
  if (file_ == nullptr)
    throw DataError({path}, std::string("can't be written: ") + std::strerror(errno));
}

PoseLines::~PoseLines() {
  if (file_ != nullptr && file_ != stdout) std::fclose(file_);
}

void PoseLines::tell(const MapUpdate& update) {
  if (file_ == nullptr) return;
  write(line_of(update.stamp, update.map_T_robot(), update.odom_T_robot, update.covariance,
                to_string(update.status))
            .dump());
}

void PoseLines::tell(const LocalizationEstimate& estimate) {
  if (file_ == nullptr) return;
  Json line = line_of(estimate.stamp, estimate.map_T_robot, estimate.odom_T_robot,
                      estimate.covariance, to_string(estimate.state));
  line["probability"] = estimate.probability;
  write(line.dump());
}

void PoseLines::write(const std::string& line) {
  if (std::fputs((line + "\n").c_str(), file_) >= 0 && std::fflush(file_) == 0) return;
  context_.warn(path_ + ": poses are not told any more: " + std::strerror(errno));
  if (file_ != stdout) std::fclose(file_);
  file_ = nullptr;
}

LiveRecorder::LiveRecorder(const std::string& path, const RobotModel& robot,
                           const AppContext& context)
    : path_(path), context_(context) {
  if (!path.empty()) writer_ = create_log(path, "mcap", robot);
}

template <typename Action>
void LiveRecorder::attempt(Action&& action) {
  if (!writer_) return;
  try {
    action(*writer_);
  } catch (const std::exception& error) {
    context_.warn(path_ + ": what comes is not recorded any more: " + error.what());
    writer_.reset();
  }
}

void LiveRecorder::add(const SensorMessage& message) {
  attempt([&](LogWriter& writer) { writer.write(message); });
}

void LiveRecorder::finish() {
  attempt([&](LogWriter& writer) { writer.finish(); });
  writer_.reset();
}

}  // namespace loopstone::app
