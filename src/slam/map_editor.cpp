#include "loopstone/slam/map_editor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <type_traits>
#include <utility>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/mapping/map_touch_up.hpp"
#include "loopstone/slam/wall_axes.hpp"
#include "slam/edit_closures.hpp"
#include "slam/edit_state.hpp"
#include "slam/finish_steps.hpp"
#include "slam/map_finish.hpp"
#include "slam/stopwatch.hpp"

namespace loopstone {

namespace {

MapShift shift_between(std::span<const Pose2> before, std::span<const Pose2> after) {
  MapShift shift;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const double moved_m = (after[i].translation() - before[i].translation()).norm();
    shift.mean_m += moved_m / static_cast<double>(before.size());
    shift.largest_m = std::max(shift.largest_m, moved_m);
    shift.largest_rad =
        std::max(shift.largest_rad, std::abs(wrap_angle(after[i].yaw - before[i].yaw)));
  }
  return shift;
}

int revoked_in(const std::vector<LoopClosure>& closures) {
  return static_cast<int>(
      std::ranges::count(closures, ClosureState::kRevoked, &LoopClosure::state));
}

/// The worst of what the graph says of itself: how its loops close, and what ties its breaks.
Verdict graph_verdict(const MapResult& result) {
  Verdict worst = Verdict::kUnknown;
  for (const QualityMeasure& measure : judge_map(result).measures) {
    if (measure.name == "reduced_chi2" || measure.name == "break_tie_m" ||
        measure.name == "certified_shift_m")
      worst = std::max(worst, measure.verdict);
  }
  return worst;
}

}  // namespace

std::vector<NumberGroup> edit_numbers() {
  return {number_group("map_editor", kMapEditor), number_group("wall_axes", kWallAxes)};
}

std::string_view kind_of(const MapEdit& edit) {
  constexpr std::array<std::string_view, std::variant_size_v<decltype(edit.what)>> kKinds{
      "delete_closure", "add_closure", "ignore",   "crop",  "erase",
      "straighten",     "origin",      "keep_out", "speed", "as_edited"};
  return kKinds[edit.what.index()];
}

class MapEditor::Impl {
 public:
  Impl(SettledMap map, Threads threads) : map_(std::move(map)), path_(map_), threads_(threads) {
    base_.settled = std::exchange(map_.settled, {});
    const MapResult placed = place_keys(map_, base_.settled, {}, threads_);
    placed_ = placed.graph.poses;
    const Calibration& found = placed.calibration;
    if (found.is_corrected)
      told_T_path_ = found.robot_T_lidar() * found.robot_T_lidar_given.inverse();
    base_.reference = std::make_shared<const EditReference>(EditReference{placed_, {}});
    judge(base_);
  }

  const EditReport& add(const MapEdit& edit);
  [[nodiscard]] EditPreview preview() const;
  [[nodiscard]] EditedMap draw(const ProgressCallback& progress,
                               const std::stop_token& cancel) const;

  struct Step {
    MapEdit edit{};
    EditReport report{};
    EditState state{};
  };
  std::vector<Step> steps{};
  [[nodiscard]] const SettledMap& map() const { return map_; }
  [[nodiscard]] const std::vector<Pose2>& map_T_keys() const { return placed_; }

 private:
  [[nodiscard]] const EditState& state() const {
    return steps.empty() ? base_ : steps.back().state;
  }
  void judge(EditState& state) const;
  [[nodiscard]] bool apply(const MapEdit& edit, EditState& state, EditReport& report) const;
  void take_frame(const StraightenMap& edit, EditState& state, EditReport& report) const;
  void take_origin(const SetOrigin& edit, const PathPlace& at, EditState& state,
                   EditReport& report) const;
  void take_reference(EditState& state) const;
  [[nodiscard]] std::vector<Pose2> previewed(const EditState& state) const;
  [[nodiscard]] Pose2 new_T_map(const EditState& state, std::span<const Pose2> map_T_keys) const;
  [[nodiscard]] const std::vector<std::vector<SurfacePoint>>& surfaces() const;
  [[nodiscard]] WallAxes axes_of(const EditState& state, std::span<const Pose2> map_T_keys) const;
  [[nodiscard]] FinishCalls calls_for(const EditState& state) const;

  SettledMap map_;
  EditedPath path_;
  Threads threads_;
  EditState base_{};
  std::vector<Pose2> placed_{};  ///< key scans of the map without edits
  Pose2 told_T_path_{};          ///< see add_closure()
  mutable std::vector<std::vector<SurfacePoint>> surfaces_{};  ///< once somebody asked
};

/// What the graph says of itself.
void MapEditor::Impl::judge(EditState& state) const {
  MapResult result = begin_result(map_, state.settled);
  result.graph_quality = assess_graph(result.graph, result.graph.poses, state.settled.closures);
  state.quality = result.graph_quality;
  state.verdict = graph_verdict(result);
}

const std::vector<std::vector<SurfacePoint>>& MapEditor::Impl::surfaces() const {
  if (surfaces_.empty()) {
    surfaces_ =
        key_surfaces(map_.chain.submaps(), {.range_max_m = map_.options.front_end.range_max_m,
                                            .points_max = map_.options.adjustment.points_max});
  }
  return surfaces_;
}

/// Of the scans that are used.
WallAxes MapEditor::Impl::axes_of(const EditState& state, std::span<const Pose2> map_T_keys) const {
  if (state.ignored.empty()) return wall_axes(map_T_keys, surfaces());
  std::vector<std::vector<SurfacePoint>> used = surfaces();
  for (std::size_t i = 0; i < used.size(); ++i)
    if (state.ignores(path_.keys[i].scan)) used[i].clear();
  return wall_axes(map_T_keys, used);
}

/// \param map_T_keys  in the first map's frame
Pose2 MapEditor::Impl::new_T_map(const EditState& state, std::span<const Pose2> map_T_keys) const {
  Pose2 new_T_map = state.reference->shown_T_map;
  if (state.frame.straighten) {
    std::vector<Pose2> shown(map_T_keys.begin(), map_T_keys.end());
    for (Pose2& pose : shown) pose = new_T_map * pose;
    new_T_map = Pose2{0.0, 0.0, -axes_of(state, shown).map_yaw_rad} * new_T_map;
  }
  if (const auto& origin = state.frame.origin) {
    const Pose2 at = new_T_map * map_T_keys[origin->key] * origin->key_T_point;
    const double yaw_rad = state.frame.origin_turns ? at.yaw : 0.0;
    new_T_map = Pose2{at.x, at.y, yaw_rad}.inverse() * new_T_map;
  }
  return new_T_map;
}

/// Key scans as far as the graph tells, in the first map's frame: what the adjustment made of the
/// map without edits is taken along.
std::vector<Pose2> MapEditor::Impl::previewed(const EditState& state) const {
  const std::vector<Pose2>& before = base_.settled.graph.poses;
  const std::vector<Pose2>& now = state.settled.graph.poses;
  std::vector<Pose2> poses = placed_;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (now[i] == before[i]) continue;
    const Pose2 moved = now[i] * before[i].inverse();
    poses[i] = told_T_path_ * moved * told_T_path_.inverse() * poses[i];
  }
  return poses;
}

void MapEditor::Impl::take_frame(const StraightenMap&, EditState& state, EditReport& report) const {
  if (state.frame.straighten) throw EditRefusal("the map is straightened already");
  if (state.frame.origin_turns) {
    throw EditRefusal(
        "the origin's yaw turns the map already: leave out one of both, the yaw or straighten");
  }
  std::vector<Pose2> shown = previewed(state);
  for (Pose2& pose : shown) pose = state.reference->shown_T_map * pose;
  const WallAxes axes = axes_of(state, shown);
  const std::string figures =
      fmt::format("{:.0f} % of the walls run along one pair of axes, {:.0f} % along the next",
                  100.0 * axes.share, 100.0 * axes.next_share);
  if (!axes.are_clear())
    throw EditRefusal("the walls have no two directions at right angles: " + figures);
  state.frame.straighten = true;
  report.told =
      fmt::format("the map is turned by {:.2f} deg; {}", degrees(-axes.map_yaw_rad) + 0.0, figures);
}

void MapEditor::Impl::take_origin(const SetOrigin& edit, const PathPlace& at, EditState& state,
                                  EditReport& report) const {
  if (state.frame.origin) throw EditRefusal("the origin is set already");
  if (edit.yaw_rad && state.frame.straighten) {
    throw EditRefusal(
        "the map is straightened, which turns it: leave out one of both, straighten or the yaw");
  }
  state.frame.origin = anchor_point({edit.point.x(), edit.point.y(), edit.yaw_rad.value_or(0.0)},
                                    at, *state.reference, path_);
  state.frame.origin_turns = edit.yaw_rad.has_value();
  report.told = fmt::format("({:.2f}, {:.2f}) becomes (0, 0)", edit.point.x(), edit.point.y());
  if (edit.yaw_rad)
    report.told += fmt::format(", and what points to {:.2f} deg to 0", degrees(*edit.yaw_rad));
}

/// The map as it would be drawn now is what the next edits are told on.
void MapEditor::Impl::take_reference(EditState& state) const {
  const MapResult placed = place_keys(map_, state.settled, calls_for(state), threads_);
  EditReference reference{placed.graph.poses, new_T_map(state, placed.graph.poses)};
  for (Pose2& pose : reference.map_T_keys) pose = reference.shown_T_map * pose;
  state.reference = std::make_shared<const EditReference>(std::move(reference));
  state.frame = {};
  state.crops.emplace_back();
}

/// Whether the graph has changed. Throws EditRefusal.
bool MapEditor::Impl::apply(const MapEdit& edit, EditState& state, EditReport& report) const {
  const auto take = [&report](ClosureEdit done) {
    report.told = std::move(done.told);
    report.closure = done.closure;
    return true;
  };
  const auto anchored = [&](const Polygon2& polygon) {
    state.newest = anchor_polygon(polygon, edit.anchor, *state.reference, path_);
    report.told = fmt::format("{:.1f} m2", area_of(polygon));
    return *state.newest;
  };
  return std::visit(
      [&](const auto& what) {
        using Kind = std::decay_t<decltype(what)>;
        if constexpr (std::is_same_v<Kind, DeleteClosure>) {
          return take(delete_closure(what, path_, state));
        } else if constexpr (std::is_same_v<Kind, AddClosure>) {
          return take(add_closure(what, path_, told_T_path_, state));
        } else if constexpr (std::is_same_v<Kind, IgnoreStretch>) {
          return take(ignore_stretch(what, path_, state));
        } else if constexpr (std::is_same_v<Kind, CropMap>) {
          state.crops.back().push_back(anchored(what.polygon));
          report.told = "what lies outside of " + report.told + " becomes unknown";
        } else if constexpr (std::is_same_v<Kind, EraseInside>) {
          state.erased.push_back(anchored(what.polygon));
          report.told = "what stands on " + report.told + " becomes free";
        } else if constexpr (std::is_same_v<Kind, StraightenMap>) {
          take_frame(what, state, report);
        } else if constexpr (std::is_same_v<Kind, SetOrigin>) {
          take_origin(what, edit.anchor, state, report);
        } else if constexpr (std::is_same_v<Kind, KeepOut>) {
          state.keep_out.emplace_back(what, anchored(what.polygon));
          report.told += " are not to be entered";
        } else if constexpr (std::is_same_v<Kind, LimitSpeed>) {
          if (!state.speed.empty() && state.speed.front().first.unit != what.unit)
            throw EditRefusal("speeds of one map are all told in percent, or all in m/s");
          state.speed.emplace_back(what, anchored(what.polygon));
          report.told += fmt::format(" with at most {} {}", what.limit,
                                     what.unit == SpeedUnit::kPercent ? "%" : "m/s");
        } else {
          take_reference(state);
          report.told = "what follows is told on the map with the edits so far";
        }
        return false;
      },
      edit.what);
}

const EditReport& MapEditor::Impl::add(const MapEdit& edit) {
  const Stopwatch watch;
  const EditState& before = state();
  Step step{.edit = edit, .state = before};
  step.state.newest.reset();
  EditReport& report = step.report;
  report.verdict_before = before.verdict;
  report.reduced_chi2_before = before.quality.reduced_chi2;
  try {
    if (apply(edit, step.state, report)) judge(step.state);
    report.applied = true;
  } catch (const ClosureRefusal& refusal) {
    report.closure = refusal.closure;
    report.told = refusal.what();
  } catch (const EditRefusal& refusal) {
    report.told = refusal.what();
  }
  if (!report.applied) {
    step.state = before;
    step.state.newest.reset();
  }
  report.verdict = step.state.verdict;
  report.reduced_chi2 = step.state.quality.reduced_chi2;
  report.shift = shift_between(before.settled.graph.poses, step.state.settled.graph.poses);
  report.closures_revoked =
      revoked_in(step.state.settled.closures) - revoked_in(before.settled.closures);
  report.seconds = watch.seconds();
  steps.push_back(std::move(step));
  return steps.back().report;
}

EditPreview MapEditor::Impl::preview() const {
  const EditState& now = state();
  EditPreview preview{.map_T_keys = previewed(now),
                      .closures = now.settled.closures,
                      .graph_quality = now.quality,
                      .verdict = now.verdict,
                      .shift = shift_between(base_.settled.graph.poses, now.settled.graph.poses)};
  const Pose2 frame = new_T_map(now, preview.map_T_keys);
  for (Pose2& pose : preview.map_T_keys) pose = frame * pose;
  for (const Step& step : steps) {
    const auto& anchored = step.state.newest;
    preview.polygons.push_back(anchored ? preview.map_T_keys[anchored->key] * anchored->key_polygon
                                        : Polygon2{});
  }
  return preview;
}

FinishCalls MapEditor::Impl::calls_for(const EditState& state) const {
  FinishCalls calls;
  if (!state.ignored.empty())
    calls.ignores = [&state](std::size_t scan) { return state.ignores(scan); };
  return calls;
}

EditedMap MapEditor::Impl::draw(const ProgressCallback& progress,
                                const std::stop_token& cancel) const {
  const EditState& now = state();
  EditedMap edited;
  FinishCalls calls = calls_for(now);
  calls.goes_on_to = [&](int stage) {
    return !cancel.stop_requested() && (!progress || progress({"drawing", stage, kFinishStages}));
  };
  calls.frame = [&](const MapResult& result) {
    return edited.new_T_map = new_T_map(now, result.graph.poses);
  };
  calls.touch_up = [&](MapResult& result) {
    const auto on_map = [&](const Anchored& anchored) {
      return result.graph.poses[anchored.key] * anchored.key_polygon;
    };
    for (const Anchored& anchored : now.erased)
      edited.cells_erased += erase(result.map, on_map(anchored), map_.options.map);
    for (const std::vector<Anchored>& group : now.crops) {
      std::vector<Polygon2> kept;
      for (const Anchored& anchored : group) kept.push_back(on_map(anchored));
      crop(result.map, kept);
    }
    for (const auto& [zone, anchored] : now.keep_out)
      edited.keep_out.push_back({zone.name, on_map(anchored)});
    for (const auto& [zone, anchored] : now.speed)
      edited.speed.push_back({zone.name, on_map(anchored), zone.limit, zone.unit});
  };
  edited.result = finish_settled(map_, now.settled, calls, threads_);
  edited.shift = shift_between(base_.settled.graph.poses, now.settled.graph.poses);
  return edited;
}

MapEditor::MapEditor(SettledMap map, Threads threads)
    : impl_(std::make_unique<Impl>(std::move(map), threads)) {}
MapEditor::~MapEditor() = default;
MapEditor::MapEditor(MapEditor&&) noexcept = default;
MapEditor& MapEditor::operator=(MapEditor&&) noexcept = default;

const EditReport& MapEditor::add(const MapEdit& edit) { return impl_->add(edit); }

bool MapEditor::undo() {
  if (impl_->steps.empty()) return false;
  impl_->steps.pop_back();
  return true;
}

void MapEditor::set_edits(std::span<const MapEdit> edits) {
  std::size_t same = 0;
  while (same < std::min(size(), edits.size()) && edit(same) == edits[same]) ++same;
  while (size() > same) undo();
  for (const MapEdit& next : edits.subspan(same)) add(next);
}

std::size_t MapEditor::size() const { return impl_->steps.size(); }
const MapEdit& MapEditor::edit(std::size_t place) const { return impl_->steps[place].edit; }
const EditReport& MapEditor::report(std::size_t place) const { return impl_->steps[place].report; }
bool MapEditor::any_refused() const {
  return std::ranges::any_of(impl_->steps,
                             [](const Impl::Step& step) { return !step.report.applied; });
}
EditPreview MapEditor::preview() const { return impl_->preview(); }
EditedMap MapEditor::draw(const ProgressCallback& progress, const std::stop_token& cancel) const {
  return impl_->draw(progress, cancel);
}
const std::vector<Pose2>& MapEditor::map_T_keys() const { return impl_->map_T_keys(); }
const SettledMap& MapEditor::map() const { return impl_->map(); }

}  // namespace loopstone
