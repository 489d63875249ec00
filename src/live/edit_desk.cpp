#include "loopstone/live/edit_desk.hpp"

#include <charconv>
#include <cmath>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <stop_token>
#include <thread>
#include <unordered_map>
#include <utility>
#include <vector>

#include "live/snapshot_contents.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/edits_file.hpp"
#include "loopstone/formats/options_file.hpp"
#include "loopstone/geometry/polygon.hpp"
#include "loopstone/sensor/scan_points.hpp"
#include "loopstone/slam/map_editor.hpp"
#include "loopstone/slam/map_snapshot.hpp"

namespace loopstone {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kEdits = "/api/edits";
constexpr std::string_view kNodes = "/api/nodes/";
constexpr std::string_view kScan = "/scan";

HttpAnswer answer_of(const Json& json, int status = 200) {
  return {.status = status, .body = json.dump(-1, ' ', false, Json::error_handler_t::replace)};
}
HttpAnswer refusal(int status, std::string_view reason) {
  return answer_of({{"error", reason}}, status);
}

Json json_of(const MapShift& shift) {
  return {
      {"mean_m", shift.mean_m}, {"largest_m", shift.largest_m}, {"largest_rad", shift.largest_rad}};
}

Json json_of(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

Json json_of(const std::optional<LoopClosure>& closure) {
  if (!closure) return nullptr;
  return {{"score", closure->score},
          {"second_score", json_of(closure->second_score)},
          {"overlap", closure->overlap},
          {"agreement", closure->agreement},
          {"chi2", json_of(closure->chi2)}};
}

Json json_of(const Polygon2& polygon) {
  Json points = Json::array();
  for (const Eigen::Vector2d& point : polygon.corners) {
    points.push_back(point.x());
    points.push_back(point.y());
  }
  return points;
}

/// The words of a verdict; none as long as nothing was judged.
std::string word_of(Verdict verdict) {
  return verdict == Verdict::kUnknown ? std::string() : std::string(to_string(verdict));
}

/// All submaps with their scans, as the last steps of a run had them.
MapSnapshot snapshot_of(const SettledMap& map) {
  MapSnapshot snapshot;
  const auto submaps = map.chain.submaps();
  for (std::size_t i = 0; i < submaps.size(); ++i)
    snapshot.submaps.push_back(snapshot_of(submaps[i], i));
  return snapshot;
}

/// What a view shows of a map before it is drawn, as a result that has nothing else.
MapResult result_of(const EditPreview& preview, const std::vector<Stamp>& stamps) {
  MapResult result;
  result.node_stamps = stamps;
  result.loop_closures = preview.closures;
  for (std::size_t i = 0; i < stamps.size(); ++i)
    result.trajectory.append(stamps[i], preview.map_T_keys[i]);
  result.graph.poses = preview.map_T_keys;
  return result;
}

}  // namespace

class EditDesk::Impl {
 public:
  Impl(const SettledMap& map, std::span<const MapEdit> before, ViewBoard& board,
       EditDeskOptions options)
      : board_(board),
        options_(std::move(options)),
        snapshot_(snapshot_of(map)),
        editor_(map, options_.threads),
        drawer_(map, options_.threads),
        before_(before.size()) {
    for (const KeyScan& key : map.chain.keys()) {
      stamps_.push_back(key.stamp);
      scan_of_node_.push_back(key.scan);
    }
    for (const SubmapSnapshot& submap : snapshot_.submaps) {
      for (const auto& scan : *submap.scans) scans_[scan->index] = scan;
    }
    for (const MapEdit& edit : before) editor_.add(edit);
    if (before_ > 0) editor_.add({.what = MapAsEdited{}});
    first_ = editor_.size();
    preview_ = editor_.preview();
    thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  }

  [[nodiscard]] std::optional<HttpAnswer> get(std::string_view path) const;
  [[nodiscard]] std::optional<HttpAnswer> post(std::string_view path, std::string_view body);
  void wait_until_drawn() const {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return drawn_ == revision_; });
  }

 private:
  [[nodiscard]] HttpAnswer add(std::string_view body);
  [[nodiscard]] HttpAnswer undo();
  [[nodiscard]] HttpAnswer save();
  [[nodiscard]] HttpAnswer scan_of(std::string_view node) const;
  [[nodiscard]] Json state() const;
  [[nodiscard]] Json json_of_edit(std::size_t place) const;
  [[nodiscard]] std::vector<MapEdit> edits(std::size_t first, bool refused_too = true) const;
  void has_changed();
  void show_graph() const;
  void run(const std::stop_token& stop);
  void show(const EditedMap& map) const;

  ViewBoard& board_;
  EditDeskOptions options_;
  MapSnapshot snapshot_;
  std::vector<Stamp> stamps_{};              ///< of the graph's nodes
  std::vector<std::size_t> scan_of_node_{};  ///< its place among all scans
  std::unordered_map<std::size_t, std::shared_ptr<const MappedScan>> scans_{};

  mutable std::mutex mutex_{};
  mutable std::condition_variable_any changed_{};
  MapEditor editor_;
  MapEditor drawer_;  ///< of the drawing thread
  std::size_t before_;
  std::size_t first_ = 0;  ///< of the clients' edits
  EditPreview preview_{};
  std::int64_t revision_ = 0;
  std::int64_t drawn_ = 0;
  std::int64_t saved_ = -1;
  MapVerdict drawn_verdict_{};
  std::string draw_failure_{};
  std::jthread thread_{};  ///< last, so that it ends first
};

std::optional<HttpAnswer> EditDesk::Impl::get(std::string_view path) const {
  if (path == kEdits) {
    const std::scoped_lock lock(mutex_);
    return answer_of(state());
  }
  if (path.starts_with(kNodes) && path.ends_with(kScan)) {
    path.remove_prefix(kNodes.size());
    path.remove_suffix(kScan.size());
    return scan_of(path);
  }
  return {};
}

std::optional<HttpAnswer> EditDesk::Impl::post(std::string_view path, std::string_view body) {
  const bool is_mine = path == kEdits || path == "/api/edits/undo" || path == "/api/edits/save";
  if (!is_mine) return {};
  const std::scoped_lock lock(mutex_);
  if (path == kEdits) return add(body);
  return path == "/api/edits/undo" ? undo() : save();
}

HttpAnswer EditDesk::Impl::add(std::string_view body) {
  const Json asked = Json::parse(body, nullptr, /*allow_exceptions=*/false);
  const auto toml = asked.is_object() ? asked.find("toml") : asked.end();
  if (!asked.is_object() || toml == asked.end() || !toml->is_string())
    return refusal(400, R"(edits are posted as {"toml": "[[edit]] ..."})");
  try {
    for (const MapEdit& edit : parse_edits(toml->get<std::string>(), "the edit")) editor_.add(edit);
  } catch (const OptionsError& error) {
    return refusal(400, error.what());
  }
  has_changed();
  return answer_of(state());
}

HttpAnswer EditDesk::Impl::undo() {
  if (editor_.size() == first_) return refusal(409, "there is no edit to be undone");
  editor_.undo();
  // What stood before it for its sake alone goes with it.
  while (editor_.size() > first_ &&
         std::holds_alternative<MapAsEdited>(editor_.edit(editor_.size() - 1).what))
    editor_.undo();
  has_changed();
  return answer_of(state());
}

HttpAnswer EditDesk::Impl::save() {
  if (!options_.save) return refusal(403, "edits can't be saved here");
  try {
    // What was refused is refused the next time, too, and then nothing would be done.
    options_.save(edits_to_toml(edits(first_, /*refused_too=*/false)));
  } catch (const std::exception& error) {
    return refusal(500, error.what());
  }
  saved_ = revision_;
  return answer_of(state());
}

HttpAnswer EditDesk::Impl::scan_of(std::string_view node) const {
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(node.data(), node.data() + node.size(), number);
  if (error != std::errc{} || end != node.data() + node.size() || number >= scan_of_node_.size())
    return refusal(404, "there is no node of this number");
  const auto found = scans_.find(scan_of_node_[number]);
  if (found == scans_.end()) return refusal(404, "the scan of this node is not at hand");
  Json points = Json::array();
  for (const Eigen::Vector2d& point :
       scan_points(found->second->scan, found->second->robot_T_lidar)) {
    points.push_back(std::round(point.x() * 1e4) * 1e-4);
    points.push_back(std::round(point.y() * 1e4) * 1e-4);
  }
  return answer_of({{"t", stamps_[number].seconds()}, {"points", std::move(points)}});
}

std::vector<MapEdit> EditDesk::Impl::edits(std::size_t first, bool refused_too) const {
  std::vector<MapEdit> list;
  for (std::size_t i = first; i < editor_.size(); ++i) {
    if (refused_too || editor_.report(i).applied) list.push_back(editor_.edit(i));
  }
  return list;
}

Json EditDesk::Impl::json_of_edit(std::size_t place) const {
  const MapEdit& edit = editor_.edit(place);
  const EditReport& report = editor_.report(place);
  return {{"kind", kind_of(edit)},
          {"toml", edits_to_toml(std::span(&edit, 1))},
          {"applied", report.applied},
          {"told", report.told},
          {"seconds", report.seconds},
          {"verdict_before", word_of(report.verdict_before)},
          {"verdict", word_of(report.verdict)},
          {"shift", json_of(report.shift)},
          {"polygon",
           place < preview_.polygons.size() ? json_of(preview_.polygons[place]) : Json::array()},
          {"closure", json_of(report.closure)}};
}

Json EditDesk::Impl::state() const {
  Json list = Json::array();
  for (std::size_t i = first_; i < editor_.size(); ++i) list.push_back(json_of_edit(i));
  const bool is_drawn = drawn_ == revision_ && drawn_ > 0;
  Json state{{"edits", std::move(list)},
             {"revision", revision_},
             {"drawn", drawn_},
             {"saved", saved_},
             {"file", options_.file},
             {"command", options_.command},
             {"verdict", word_of(is_drawn ? drawn_verdict_.overall : preview_.verdict)},
             {"sentence", is_drawn ? drawn_verdict_.sentence : std::string()},
             {"shift", json_of(preview_.shift)}};
  if (!draw_failure_.empty()) state["failure"] = draw_failure_;
  return state;
}

void EditDesk::Impl::has_changed() {
  ++revision_;
  preview_ = editor_.preview();
  show_graph();
  changed_.notify_all();
}

void EditDesk::Impl::show_graph() const {
  if (stamps_.empty() || preview_.map_T_keys.size() != stamps_.size()) return;
  show_poses(board_, stamps_.back(), result_of(preview_, stamps_), snapshot_);
}

/// Draws the newest list, again and again; one that is overtaken is given up.
void EditDesk::Impl::run(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  const auto is_behind = [this] { return drawn_ < revision_; };
  while (changed_.wait(lock, stop, is_behind) && !stop.stop_requested()) {
    const std::int64_t drawing = revision_;
    const std::vector<MapEdit> list = edits(0);
    lock.unlock();
    std::optional<EditedMap> map;
    std::string failure;
    try {
      drawer_.set_edits(list);
      map = drawer_.draw([&](const Progress&) {
        const std::scoped_lock now(mutex_);
        return !stop.stop_requested() && revision_ == drawing;
      });
    } catch (const std::exception& error) {
      failure = error.what();
    }
    lock.lock();
    const bool is_newest = revision_ == drawing;
    if (is_newest && map && map->result.complete) show(*map);
    if (!failure.empty() || (map && map->result.complete)) {
      drawn_ = drawing;
      drawn_verdict_ = map ? map->result.verdict : MapVerdict{};
      draw_failure_ = failure;
      changed_.notify_all();
    }
  }
}

void EditDesk::Impl::show(const EditedMap& map) const {
  const MapResult& result = map.result;
  const Stamp stamp = result.trajectory.empty() ? Stamp{} : result.trajectory.back().stamp;
  if (!show_result(board_, stamp, result, snapshot_)) board_.show_quality(stamp, {});
  // The floor lies where it was, and is not coloured anew.
  board_.show_texture(stamp, {});
}

EditDesk::EditDesk(const SettledMap& map, std::span<const MapEdit> before, ViewBoard& board,
                   EditDeskOptions options)
    : impl_(std::make_unique<Impl>(map, before, board, std::move(options))) {}
EditDesk::~EditDesk() = default;
std::optional<HttpAnswer> EditDesk::get(std::string_view path) const { return impl_->get(path); }
std::optional<HttpAnswer> EditDesk::post(std::string_view path, std::string_view body) {
  return impl_->post(path, body);
}
void EditDesk::wait_until_drawn() const { impl_->wait_until_drawn(); }

}  // namespace loopstone
