#include "ros2_outlets.hpp"

#include <atomic>
#include <utility>

#include "loopstone/messages/message_codec.hpp"

namespace loopstone::app {

namespace {

constexpr TopicQuality kLatched{.is_reliable = true, .is_latched = true, .depth = 1};
constexpr TopicQuality kTransforms{.is_reliable = true, .depth = 100};
constexpr TopicQuality kReliable{.is_reliable = true, .depth = 10};
constexpr std::chrono::seconds kBetweenDiagnostics{1};
/// The last map and the last pose reach those who listen before this program leaves.
constexpr std::chrono::milliseconds kFarewell{2000};
/// Of the view's board the map alone is of use.
constexpr double kNever = 1e9;
constexpr ViewPeriods kMapAlone{
    .robot_s = kNever, .status_s = kNever, .map_s = 0.5, .closures_s = 1.0, .standard_s = 1.0};

ViewSink map_sink(const DdsOutlet& map) {
  // By their order, as the board adds them.
  struct Channels {
    std::atomic<std::uint32_t> count{0};
    std::atomic<std::uint32_t> map{~0U};
  };
  const auto channels = std::make_shared<Channels>();
  return {.add_channel =
              [channels](const ViewChannel& channel) {
                const std::uint32_t index = channels->count++;
                if (channel.topic == "/map") channels->map = index;
                return ChannelId{index};
              },
          .publish =
              [channels, &map](ChannelId channel, Stamp /*stamp*/, const std::string& bytes) {
                if (channel.index == channels->map) map.write(bytes);
              },
          .set_time = [](Stamp) {}};
}

}  // namespace

Ros2Outlets::Ros2Outlets(const DdsNode& node, RobotFrames frames)
    : node_(node),
      transforms_(std::move(frames)),
      map_(node, ros_topic<msg::OccupancyGrid>("/map", kLatched)),
      tf_(node, ros_topic<msg::TFMessage>("/tf", kTransforms)),
      pose_(node, ros_topic<msg::PoseWithCovarianceStamped>("/pose", kReliable)),
      diagnostics_(node, ros_topic<msg::DiagnosticArray>("/diagnostics", kReliable)),
      board_(map_sink(map_)) {}

void Ros2Outlets::mapping_begins(const RobotModel& robot, const OccupancyOptions& map) {
  feed_ = std::make_unique<MapFeed>(board_, robot, map, kMapAlone);
}

void Ros2Outlets::localizing_begins(const LocalizationMap& map) {
  board_.show_grid(now(), map.occupancy());
  initial_pose_ = std::make_unique<DdsInbox>(
      node_, std::vector{ros_topic<msg::PoseWithCovarianceStamped>("/initialpose", kReliable)});
}

void Ros2Outlets::add(const MapUpdate& update, const Mapper& mapper) {
  tell_place(update.stamp, update.map_T_robot(), update.odom_T_robot, update.covariance);
  bool is_news = false;
  for (msg::DiagnosticStatus& status : diagnostics_of(update))
    is_news = note(std::move(status)) || is_news;
  tell_diagnostics(is_news);
  feed_->add(update, mapper);
}

void Ros2Outlets::add(const LocalizationEstimate& estimate) {
  tell_place(estimate.stamp, estimate.map_T_robot, estimate.odom_T_robot, estimate.covariance);
  tell_diagnostics(note(diagnostic_of(estimate)));
}

void Ros2Outlets::add(const LiveNews& news) {
  const std::uint8_t level =
      news.is_trouble ? msg::DiagnosticStatus::kWarn : msg::DiagnosticStatus::kOk;
  tell_diagnostics(note({.level = level,
                         .name = "loopstone: sensors",
                         .message = news.text,
                         .hardware_id = news.source}));
}

void Ros2Outlets::catch_up(const Mapper* mapper) {
  if (feed_ && mapper != nullptr) feed_->catch_up(*mapper);
  tell_diagnostics(false);
}

std::optional<InitialPose> Ros2Outlets::take_initial_pose() {
  std::optional<InitialPose> last;
  if (!initial_pose_) return last;
  while (const auto came = initial_pose_->take(std::chrono::milliseconds{0})) {
    msg::PoseWithCovarianceStamped message;
    try {
      MessageDecoder<msg::PoseWithCovarianceStamped>(WireFormat::kCdr).decode(came->bytes, message);
    } catch (const MessageError& error) {
      tell_diagnostics(note({.level = msg::DiagnosticStatus::kWarn,
                             .name = "loopstone: initial pose",
                             .message = error.what()}));
      continue;
    }
    if (const auto initial = initial_pose_of(message)) last = initial;
  }
  return last;
}

void Ros2Outlets::end(const Mapper& mapper) { feed_->end(mapper); }

void Ros2Outlets::finish(const MapResult& result) {
  feed_->finish(result);
  map_.wait_for_readers(kFarewell);
}

void Ros2Outlets::tell_place(Stamp stamp, const Pose2& map_T_robot, const Pose2& odom_T_robot,
                             const Eigen::Matrix3d& covariance) {
  tf_.send(transforms_.at(stamp, map_T_robot, odom_T_robot));
  pose_.send(pose_message(stamp, map_T_robot, covariance));
}

bool Ros2Outlets::note(msg::DiagnosticStatus status) {
  msg::DiagnosticStatus& last = statuses_[status.name];
  const bool is_news = last.level != status.level || last.message != status.message;
  last = std::move(status);
  return is_news;
}

void Ros2Outlets::tell_diagnostics(bool is_news) {
  if (statuses_.empty()) return;
  const Clock::time_point time = Clock::now();
  if (!is_news && diagnosed_ && time - *diagnosed_ < kBetweenDiagnostics) return;
  diagnosed_ = time;
  msg::DiagnosticArray all{.header = {now(), ""}};
  for (const auto& [name, status] : statuses_) all.status.push_back(status);
  diagnostics_.send(all);
}

}  // namespace loopstone::app
