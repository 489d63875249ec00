#include "loopstone/live/view_board.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <mutex>
#include <utility>

#include "formats/known_mounts.hpp"
#include "formats/message_scan.hpp"
#include "formats/topic_names.hpp"
#include "live/node_track.hpp"
#include "live/still.hpp"
#include "live/tile_store.hpp"
#include "live/told_list.hpp"
#include "live/view_json.hpp"
#include "live/view_topics.hpp"
#include "loopstone/report/ros_messages.hpp"
#include "report/map_messages.hpp"

namespace loopstone {
namespace {

/// Nothing for a stamp that the message has no place for.
template <typename M>
std::optional<std::string> encoded(const M& message) {
  try {
    std::string bytes;
    encode_message(WireFormat::kCdr, message, bytes);
    return bytes;
  } catch (const MessageError&) {
    return {};
  }
}

std::optional<std::size_t> id_in(std::string_view path) {
  constexpr std::string_view kClosures = "/api/closures/";
  if (!path.starts_with(kClosures)) return {};
  path.remove_prefix(kClosures.size());
  std::size_t id = 0;
  const auto [end, error] = std::from_chars(path.data(), path.data() + path.size(), id);
  if (error != std::errc{} || end != path.data() + path.size()) return {};
  return id;
}

/// Every solution of the graph moves every chi-square a little.
constexpr double kSameChi2 = 0.1;
/// Of points of an outline.
constexpr float kSameOutlineM = 0.01F;

bool is_near(const std::optional<double>& a, const std::optional<double>& b) {
  if (!a || !b) return a == b;
  return std::abs(*a - *b) <= kSameChi2 * (1.0 + std::abs(*a));
}

/// Whether what is told of a closure is the same. If so, its chi-square stays as it was told.
bool keeps_told(const ViewClosure& told, ViewClosure& now) {
  const LoopClosure& a = told.closure;
  const LoopClosure& b = now.closure;
  const bool is_same =
      told.from_node == now.from_node && told.to_node == now.to_node && told.from == now.from &&
      told.to == now.to && a.from_submap == b.from_submap && a.to_submap == b.to_submap &&
      a.state == b.state && a.reason == b.reason && a.score == b.score &&
      a.second_score == b.second_score && a.overlap == b.overlap && a.agreement == b.agreement &&
      a.covariance == b.covariance && a.by_appearance == b.by_appearance && is_near(a.chi2, b.chi2);
  if (is_same) now.closure.chi2 = a.chi2;
  return is_same;
}

/// Whether a submap lies where it was told, and as it was. If so, it stays as it was told.
bool keeps_told(const ViewSubmap& told, ViewSubmap& now) {
  const auto is_same_point = [](const Eigen::Vector2f& a, const Eigen::Vector2f& b) {
    return (a - b).lpNorm<Eigen::Infinity>() < kSameOutlineM;
  };
  const bool is_same = told.id == now.id && told.state == now.state &&
                       is_still(told.map_T_submap, now.map_T_submap) &&
                       std::ranges::equal(told.outline, now.outline, is_same_point);
  if (is_same) now = told;
  return is_same;
}

constexpr auto kKeepsTold = [](const auto& told, auto& now) { return keeps_told(told, now); };

/// A channel whose messages are sent only when they differ from the last one.
struct Told {
  ChannelId channel{};
  std::string last{};
};

}  // namespace

class ViewBoard::Impl {
 public:
  explicit Impl(ViewSink sink) : sink_(std::move(sink)) { add_channels(); }

  void begin_anew(Stamp stamp, double resolution_m);
  void show_robot(Stamp stamp, const Pose2& map_T_robot, const Eigen::Matrix3d& covariance,
                  const LaserScan* scan, const RobotModel& robot);
  void show_particles(Stamp stamp, const std::vector<Pose2>& map_T_robot);
  void send_all_tiles(Stamp stamp);
  template <typename Map>
  void replace_tiles(Stamp stamp, const Map& map) {
    const std::scoped_lock lock(mutex_);
    tiles_.replace(map);
    send_all_tiles(stamp);
  }
  void change_tiles(Stamp stamp, const std::vector<OccupancyTile>& tiles);
  void show_nodes(Stamp stamp, std::vector<ViewNode> nodes);
  void show_closures(Stamp stamp, std::vector<ViewClosure> closures);
  void show_submaps(Stamp stamp, std::vector<ViewSubmap> submaps);
  void show_graph(Stamp stamp);
  [[nodiscard]] bool is_wanted(ChannelId channel) const {
    return !sink_.is_wanted || sink_.is_wanted(channel);
  }

  template <typename M>
  void send(ChannelId channel, Stamp stamp, const M& message) const {
    if (auto bytes = encoded(message)) sink_.publish(channel, stamp, std::move(*bytes));
  }
  void tell(Told& told, Stamp stamp, std::string text) {
    const std::scoped_lock lock(mutex_);
    tell_locked(told, stamp, std::move(text));
  }

 private:
  friend class ViewBoard;

  mutable std::mutex mutex_{};  ///< held while something is published, so that order is kept
  ViewSink sink_;

  ChannelId transforms_{};
  ChannelId mounts_channel_{};
  ChannelId pose_{};
  ChannelId grid_{};
  ChannelId path_{};
  ChannelId graph_{};
  ChannelId status_{};
  Told verdict_{};
  Told warnings_{};
  Told quality_{};
  Told texture_{};

  TileStore tiles_{};
  ToldList<ViewClosure> closures_{};
  ToldList<ViewSubmap> submaps_{};

  void add_channels();
  void tell_locked(Told& told, Stamp stamp, std::string text);
  void tell_closures(std::vector<ViewClosure> closures);
  void tell_submaps(std::vector<ViewSubmap> submaps);
  void send_scan(const LaserScan& scan, const RobotModel& robot);
  [[nodiscard]] std::optional<ViewMessage> all_tiles() const;
  [[nodiscard]] std::optional<ViewMessage> all_nodes() const;
  [[nodiscard]] std::optional<ViewMessage> all_closures() const;
  [[nodiscard]] std::optional<ViewMessage> all_submaps() const;

  ChannelId tiles_channel_{};
  ChannelId nodes_channel_{};
  ChannelId closures_channel_{};
  ChannelId submaps_channel_{};
  std::map<int, ChannelId> scans_{};  ///< by laser
  std::optional<ChannelId> particles_{};
  KnownMounts mounts_{};
  NodeTrack nodes_{};
  Stamp now_{};
};

void ViewBoard::Impl::add_channels() {
  using enum SendPolicy;
  const auto add = [&](ViewChannel channel) { return sink_.add_channel(std::move(channel)); };
  transforms_ = add(ros_channel<msg::TFMessage>("/tf", kDroppable));
  mounts_channel_ = add(ros_channel<msg::TFMessage>("/tf_static", kLatest));
  scans_[0] = add(ros_channel<msg::LaserScan>(scan_topic(0), kDroppable));
  pose_ = add(ros_channel<msg::PoseWithCovarianceStamped>("/pose", kDroppable));
  grid_ = add(ros_channel<msg::OccupancyGrid>("/map", kLatest));
  path_ = add(ros_channel<msg::Path>("/path", kLatest));
  graph_ = add(ros_channel<msg::MarkerArray>("/graph", kLatest));
  ViewChannel tiles = ros_channel<msg::MapTiles>("/loopstone/tiles", kChanges);
  tiles.whole = [this] { return all_tiles(); };
  tiles_channel_ = add(std::move(tiles));
  ViewChannel nodes = ros_channel<msg::Trajectory>("/loopstone/trajectory", kChanges);
  nodes.whole = [this] { return all_nodes(); };
  nodes_channel_ = add(std::move(nodes));
  status_ = add(json_channel("status", status_schema()));
  ViewChannel closures = json_channel("closures", closures_schema(), kChanges);
  closures.whole = [this] { return all_closures(); };
  closures_channel_ = add(std::move(closures));
  ViewChannel submaps = json_channel("submaps", submaps_schema(), kChanges);
  submaps.whole = [this] { return all_submaps(); };
  submaps_channel_ = add(std::move(submaps));
  verdict_.channel = add(json_channel("verdict", verdict_schema()));
  warnings_.channel = add(json_channel("warnings", warnings_schema()));
  quality_.channel = add(json_channel("quality", layer_schema()));
  texture_.channel = add(json_channel("texture", layer_schema()));
}

void ViewBoard::Impl::tell_locked(Told& told, Stamp stamp, std::string text) {
  if (text == told.last) return;
  told.last = text;
  sink_.publish(told.channel, stamp, std::move(text));
}

std::optional<ViewMessage> ViewBoard::Impl::all_tiles() const {
  const std::scoped_lock lock(mutex_);
  if (tiles_.empty()) return {};
  auto bytes = encoded(tiles_.whole());
  return bytes ? std::optional<ViewMessage>({now_, std::move(*bytes)}) : std::nullopt;
}

std::optional<ViewMessage> ViewBoard::Impl::all_nodes() const {
  const std::scoped_lock lock(mutex_);
  if (nodes_.nodes().empty()) return {};
  auto bytes = encoded(nodes_.whole());
  return bytes ? std::optional<ViewMessage>({now_, std::move(*bytes)}) : std::nullopt;
}

std::optional<ViewMessage> ViewBoard::Impl::all_closures() const {
  const std::scoped_lock lock(mutex_);
  return ViewMessage{now_, closures_json(closures_.entries(), closures_.all_places())};
}

std::optional<ViewMessage> ViewBoard::Impl::all_submaps() const {
  const std::scoped_lock lock(mutex_);
  return ViewMessage{now_, submaps_json(submaps_.entries(), submaps_.all_places())};
}

void ViewBoard::Impl::begin_anew(Stamp stamp, double resolution_m) {
  const std::scoped_lock lock(mutex_);
  tiles_.clear(resolution_m);
  send_all_tiles(stamp);
  (void)nodes_.change({});
  now_ = stamp;
  send(nodes_channel_, stamp, nodes_.whole());
  tell_closures({});
  tell_submaps({});
  tell_locked(verdict_, stamp, verdict_json({}));
  tell_locked(warnings_, stamp, warnings_json({}));
  for (Told* layer : {&quality_, &texture_}) {
    if (!layer->last.empty()) tell_locked(*layer, stamp, layer_json({}));
  }
}

void ViewBoard::Impl::show_robot(Stamp stamp, const Pose2& map_T_robot,
                                 const Eigen::Matrix3d& covariance, const LaserScan* scan,
                                 const RobotModel& robot) {
  const std::scoped_lock lock(mutex_);
  sink_.set_time(stamp);
  if (scan != nullptr) send_scan(*scan, robot);
  send(transforms_, stamp,
       msg::TFMessage{{transform_message(stamp, kMapFrame, kBaseFrame, map_T_robot)}});
  send(pose_, stamp, pose_message(stamp, map_T_robot, covariance));
}

void ViewBoard::Impl::show_particles(Stamp stamp, const std::vector<Pose2>& map_T_robot) {
  const std::scoped_lock lock(mutex_);
  // Only localisation has them.
  if (!particles_) {
    particles_ = sink_.add_channel(ros_channel<msg::PoseArray>("/particles", SendPolicy::kLatest));
  }
  msg::PoseArray message{.header = {stamp, kMapFrame}};
  message.poses.reserve(map_T_robot.size());
  for (const Pose2& pose : map_T_robot) message.poses.push_back(loopstone::to_message(pose));
  send(*particles_, stamp, message);
}

void ViewBoard::Impl::send_scan(const LaserScan& scan, const RobotModel& robot) {
  if (const auto all = mounts_.change(scan, robot)) send(mounts_channel_, scan.stamp, *all);
  const auto [channel, is_first] = scans_.try_emplace(scan.lidar);
  if (is_first) {
    channel->second = sink_.add_channel(
        ros_channel<msg::LaserScan>(scan_topic(scan.lidar), SendPolicy::kDroppable));
  }
  send(channel->second, scan.stamp, loopstone::to_message(scan, laser_frame(scan.lidar)));
}

void ViewBoard::Impl::send_all_tiles(Stamp stamp) {
  now_ = stamp;
  send(tiles_channel_, stamp, tiles_.whole());
}

void ViewBoard::Impl::change_tiles(Stamp stamp, const std::vector<OccupancyTile>& tiles) {
  const std::scoped_lock lock(mutex_);
  const msg::MapTiles message = tiles_.change(tiles);
  if (message.ids.empty()) return;
  now_ = stamp;
  send(tiles_channel_, stamp, message);
}

void ViewBoard::Impl::show_nodes(Stamp stamp, std::vector<ViewNode> nodes) {
  const std::scoped_lock lock(mutex_);
  const auto message = nodes_.change(std::move(nodes));
  if (!message) return;
  now_ = stamp;
  send(nodes_channel_, stamp, *message);
}

void ViewBoard::Impl::tell_closures(std::vector<ViewClosure> closures) {
  const std::vector<std::size_t> places = closures_.change(std::move(closures), kKeepsTold);
  if (places.empty() && !closures_.is_shorter()) return;
  sink_.publish(closures_channel_, now_, closures_json(closures_.entries(), places));
}

void ViewBoard::Impl::tell_submaps(std::vector<ViewSubmap> submaps) {
  const std::vector<std::size_t> places = submaps_.change(std::move(submaps), kKeepsTold);
  if (places.empty() && !submaps_.is_shorter()) return;
  sink_.publish(submaps_channel_, now_, submaps_json(submaps_.entries(), places));
}

void ViewBoard::Impl::show_closures(Stamp stamp, std::vector<ViewClosure> closures) {
  const std::scoped_lock lock(mutex_);
  now_ = stamp;
  tell_closures(std::move(closures));
}

void ViewBoard::Impl::show_submaps(Stamp stamp, std::vector<ViewSubmap> submaps) {
  const std::scoped_lock lock(mutex_);
  now_ = stamp;
  tell_submaps(std::move(submaps));
}

void ViewBoard::Impl::show_graph(Stamp stamp) {
  const std::scoped_lock lock(mutex_);
  std::vector<Pose2> origins;
  for (const ViewSubmap& submap : submaps_.entries()) origins.push_back(submap.map_T_submap);
  std::vector<ClosureLine> lines;
  const std::vector<ViewNode>& nodes = nodes_.nodes();
  for (const ViewClosure& one : closures_.entries()) {
    if (std::max(one.from_node, one.to_node) >= nodes.size()) continue;
    lines.push_back({one.closure.state, nodes[one.from_node].map_T_robot.translation(),
                     nodes[one.to_node].map_T_robot.translation()});
  }
  msg::MarkerArray graph = submap_markers(origins, stamp);
  for (msg::Marker& marker : closure_markers(lines, stamp).markers)
    graph.markers.push_back(std::move(marker));
  send(graph_, stamp, graph);
}

ViewBoard::ViewBoard(ViewSink sink) : impl_(std::make_unique<Impl>(std::move(sink))) {}
ViewBoard::~ViewBoard() = default;

bool ViewBoard::is_watched() const { return !impl_->sink_.is_watched || impl_->sink_.is_watched(); }
bool ViewBoard::is_standard_wanted() const {
  return impl_->is_wanted(impl_->grid_) || impl_->is_wanted(impl_->path_) ||
         impl_->is_wanted(impl_->graph_);
}
void ViewBoard::begin_anew(Stamp stamp, double resolution_m) {
  impl_->begin_anew(stamp, resolution_m);
}
void ViewBoard::show_robot(Stamp stamp, const Pose2& map_T_robot, const Eigen::Matrix3d& covariance,
                           const LaserScan* scan, const RobotModel& robot) {
  impl_->show_robot(stamp, map_T_robot, covariance, scan, robot);
}
void ViewBoard::show_particles(Stamp stamp, const std::vector<Pose2>& map_T_robot) {
  impl_->show_particles(stamp, map_T_robot);
}
void ViewBoard::show_status(const ViewStatus& status) {
  impl_->sink_.publish(impl_->status_, status.stamp, status_json(status));
}
void ViewBoard::change_tiles(Stamp stamp, const std::vector<OccupancyTile>& tiles) {
  impl_->change_tiles(stamp, tiles);
}
void ViewBoard::replace_tiles(Stamp stamp, const CellStates& cells) {
  impl_->replace_tiles(stamp, cells);
}
void ViewBoard::replace_tiles(Stamp stamp, const OccupancyMap& map) {
  impl_->replace_tiles(stamp, map);
}
double ViewBoard::known_area_m2() const {
  const std::scoped_lock lock(impl_->mutex_);
  return impl_->tiles_.known_m2();
}
void ViewBoard::show_grid(Stamp stamp, const CellStates& cells) {
  if (!cells.empty()) impl_->send(impl_->grid_, stamp, loopstone::to_message(cells, stamp));
}
void ViewBoard::show_nodes(Stamp stamp, std::vector<ViewNode> nodes) {
  impl_->show_nodes(stamp, std::move(nodes));
}
void ViewBoard::show_path(Stamp stamp, const std::vector<StampedPose2>& poses) {
  impl_->send(impl_->path_, stamp, path_message(poses, stamp));
}
void ViewBoard::show_closures(Stamp stamp, std::vector<ViewClosure> closures) {
  impl_->show_closures(stamp, std::move(closures));
}
void ViewBoard::show_submaps(Stamp stamp, std::vector<ViewSubmap> submaps) {
  impl_->show_submaps(stamp, std::move(submaps));
}
void ViewBoard::show_graph(Stamp stamp) { impl_->show_graph(stamp); }
void ViewBoard::show_verdict(Stamp stamp, const ViewVerdict& verdict) {
  impl_->tell(impl_->verdict_, stamp, verdict_json(verdict));
}
void ViewBoard::show_warnings(Stamp stamp, const std::vector<ViewWarning>& warnings) {
  impl_->tell(impl_->warnings_, stamp, warnings_json(warnings));
}
void ViewBoard::show_quality(Stamp stamp, const ViewLayer& layer) {
  impl_->tell(impl_->quality_, stamp, layer_json(layer));
}
void ViewBoard::show_texture(Stamp stamp, const ViewLayer& layer) {
  impl_->tell(impl_->texture_, stamp, layer_json(layer));
}

std::optional<HttpAnswer> ViewBoard::answer(std::string_view path) const {
  const auto id = id_in(path);
  if (!id) return {};
  const std::scoped_lock lock(impl_->mutex_);
  const std::vector<ViewClosure>& closures = impl_->closures_.entries();
  if (*id >= closures.size())
    return HttpAnswer{.status = 404, .body = R"({"error":"there is no closure of this id"})"};
  return HttpAnswer{.body = evidence_json(*id, closures[*id])};
}

ViewSink sink_of(ViewServer& server) {
  return {
      .add_channel =
          [&server](ViewChannel channel) { return server.add_channel(std::move(channel)); },
      .publish = [&server](ChannelId channel, Stamp stamp,
                           std::string bytes) { server.publish(channel, stamp, std::move(bytes)); },
      .set_time = [&server](Stamp now) { server.set_time(now); },
      .is_watched = [&server] { return server.clients() > 0; },
      .is_wanted = [&server](ChannelId channel) { return server.subscribers(channel) > 0; }};
}

}  // namespace loopstone
