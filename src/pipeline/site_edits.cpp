// What is corrected in a site by hand.

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/mapping/map_touch_up.hpp"
#include "loopstone/pipeline/site.hpp"
#include "pipeline/site_books.hpp"
#include "pipeline/site_corrections.hpp"

namespace loopstone {

namespace {

CellSetting setting_of(SiteEditKind kind) {
  if (kind == SiteEditKind::kWall) return CellSetting::kOccupied;
  return kind == SiteEditKind::kFree ? CellSetting::kFree : CellSetting::kUnknown;
}

/// Nothing where it is no part of the map.
std::optional<Pose2> pose_of(const SiteAnchor& anchor, std::span<const SitePlacement> placements) {
  const auto at = std::ranges::find(placements, anchor.session, &SitePlacement::session);
  if (at == placements.end() || !at->placement.is_joined) return {};
  const auto& poses = at->placement.map_T_submaps;
  const auto submap = static_cast<std::size_t>(anchor.submap);
  if (anchor.submap < 0 || submap >= poses.size()) return {};
  return poses[submap];
}

std::optional<Polygon2> place_of(const SiteEdit& edit, std::span<const SitePlacement> placements) {
  if (edit.kind == SiteEditKind::kExclude) return {};
  if (!edit.anchor) return edit.polygon;
  const auto pose = pose_of(*edit.anchor, placements);
  if (!pose) return {};
  return *pose * edit.polygon;
}

std::vector<SiteCorrection> corrections(std::vector<SiteEdit> edits,
                                        std::span<const SitePlacement> placements) {
  std::vector<SiteCorrection> corrections;
  for (SiteEdit& edit : edits) {
    auto on_map = place_of(edit, placements);
    corrections.push_back({.edit = std::move(edit), .on_map = std::move(on_map)});
  }
  return corrections;
}

/// The submap whose origin is nearest to a polygon.
struct NearestSubmap {
  std::optional<SiteAnchor> anchor{};
  double distance_m = std::numeric_limits<double>::infinity();
};

/// \param others  that must have it, too
NearestSubmap nearest_submap(const Polygon2& polygon, std::span<const SitePlacement> placements,
                             std::span<const SitePlacement> others) {
  NearestSubmap nearest;
  const Eigen::Vector2d centre = centroid_of(polygon);
  for (const SitePlacement& one : placements) {
    for (std::size_t i = 0; i < one.placement.map_T_submaps.size(); ++i) {
      const SiteAnchor anchor{one.session, static_cast<std::int64_t>(i)};
      const auto pose = pose_of(anchor, placements);
      if (!pose || !pose_of(anchor, others)) continue;
      const double distance_m = (pose->translation() - centre).norm();
      if (distance_m < nearest.distance_m) nearest = {anchor, distance_m};
    }
  }
  return nearest;
}

/// Half of its longest side and more.
double reach_of(const Polygon2& polygon) {
  double reach_m = 0.0;
  for (const Eigen::Vector2d& corner : polygon.corners)
    reach_m = std::max(reach_m, (corner - centroid_of(polygon)).norm());
  return reach_m;
}

}  // namespace

std::vector<Polygon2> walls_of(std::span<const SiteCorrection> edits) {
  std::vector<Polygon2> walls;
  for (const SiteCorrection& one : edits)
    if (one.edit.kind == SiteEditKind::kWall && one.on_map) walls.push_back(*one.on_map);
  return walls;
}

void correct(OccupancyMap& map, const OccupancyOptions& options,
             std::vector<SiteCorrection>& edits) {
  for (SiteCorrection& one : edits) {
    if (one.on_map) one.cells = set_cells(map, *one.on_map, setting_of(one.edit.kind), options);
  }
}

void settle(Grid<float>& movable, std::span<const SiteCorrection> edits) {
  for (const SiteCorrection& one : edits) {
    if (!one.on_map) continue;
    for_each_cell_touching(*one.on_map, movable.frame(), [&](Cell cell) { movable[cell] = 0.0F; });
  }
}

Site::Places Site::begin_change(const SiteWatch& watch) {
  file_.begin_change(watch.waits);
  Places places;
  // A damaged file must not keep anybody from what mends it.
  try {
    std::vector<SiteEdit> edits = file_.edits();
    if (edits.empty()) return places;
    places.placements = file_.placements();
    places.edits = corrections(std::move(edits), places.placements);
  } catch (const DataError&) {
    return {};
  }
  return places;
}

/// A polygon stays where it is on the building when what it lay on leaves the map: then it lies on
/// what is nearest to it, was there before, and still is.
void Site::keep_edits_in_place(const Places& before) {
  if (before.edits.empty()) return;
  const std::vector<SitePlacement> after = file_.placements();
  const std::vector<SiteSession> sessions = file_.sessions();
  const auto is_there = [&](const SiteAnchor& anchor) {
    return std::ranges::find(sessions, anchor.session, &SiteSession::id) != sessions.end();
  };
  for (const SiteCorrection& one : before.edits) {
    const SiteEdit& edit = one.edit;
    if (!one.on_map || (edit.anchor && pose_of(*edit.anchor, after))) continue;
    const NearestSubmap nearest = nearest_submap(*one.on_map, before.placements, after);
    if (nearest.anchor) {
      const Pose2 map_T_submap = *pose_of(*nearest.anchor, before.placements);
      file_.set_place(edit.id, nearest.anchor, map_T_submap.inverse() * *one.on_map);
    } else if (edit.anchor && !is_there(*edit.anchor)) {
      file_.set_place(edit.id, {}, *one.on_map);
    }
  }
}

std::vector<SiteCorrection> Site::corrections_on(const Kept& kept) const {
  std::vector<SitePlacement> placements;
  for (std::size_t i = 0; i < kept.sessions.size(); ++i)
    placements.push_back({kept.sessions[i].id, kept.drives.placements()[i]});
  return corrections(file_.edits(), placements);
}

std::vector<SiteCorrection> Site::edits() const {
  return corrections(file_.edits(), file_.placements());
}

SiteEdit Site::exclude(std::int64_t session, const SiteWatch& watch) {
  const Places places = begin_change(watch);
  const std::vector<SiteSession> sessions = file_.sessions();
  const SiteSession& found = find_session(sessions, session, file_.path());
  if (found.status == SessionStatus::kExcluded) {
    throw UsageError(
        fmt::format("{}: session {} is {} already", file_.path(), session, found.reason));
  }
  if (found.status == SessionStatus::kRefused || found.status == SessionStatus::kRetired) {
    throw UsageError(fmt::format("{}: session {} is {}: nothing of it is in the map", file_.path(),
                                 session, to_string(found.status)));
  }
  SiteEdit edit{.at = now_text(), .excluded = session};
  edit.id = file_.add_edit(edit);
  note("exclude", found.log, fmt::format("edit {}: is no part of the map any more", edit.id));
  rejoin(places, watch);
  file_.commit();
  return edit;
}

SiteEdit Site::include(std::int64_t session, const SiteWatch& watch) {
  const std::vector<SiteSession> sessions = file_.sessions();
  const SiteSession& found = find_session(sessions, session, file_.path());
  for (const SiteEdit& edit : file_.edits()) {
    if (edit.kind != SiteEditKind::kExclude || edit.excluded != session) continue;
    undo(edit.id, watch);
    return edit;
  }
  throw UsageError(fmt::format("{}: session {} is not left out, it is {}", file_.path(), session,
                               to_string(found.status)));
}

SiteEdit Site::set_cells(SiteEditKind kind, const Polygon2& polygon, const SiteWatch& watch) {
  if (kind == SiteEditKind::kExclude) throw UsageError("a polygon leaves no session out");
  if (const auto fault = fault_of(polygon)) throw UsageError("a polygon must " + *fault);
  const Places places = begin_change(watch);
  const std::vector<SitePlacement> placements = file_.placements();
  const NearestSubmap nearest = nearest_submap(polygon, placements, placements);
  if (!nearest.anchor)
    throw DataError({file_.path()}, "there is no map yet that could be corrected; add a session");
  constexpr double kFarM = 200.0;
  if (nearest.distance_m - reach_of(polygon) > kFarM) {
    throw UsageError(
        fmt::format("{}: the polygon lies {:.0f} m from all that was seen; corners "
                    "are metres of the map, as `loopstone site map` draws it",
                    file_.path(), nearest.distance_m));
  }
  const Pose2 map_T_submap = *pose_of(*nearest.anchor, placements);
  SiteEdit edit{.at = now_text(),
                .kind = kind,
                .anchor = nearest.anchor,
                .polygon = map_T_submap.inverse() * polygon};
  edit.id = file_.add_edit(edit);
  const Eigen::Vector2d centre = centroid_of(polygon);
  note("edit", "",
       fmt::format("edit {}: {:.2f} m2 around x {:.2f} m, y {:.2f} m are {}", edit.id,
                   area_of(polygon), centre.x(), centre.y(), to_string(kind)));
  file_.commit();
  return edit;
}

void Site::undo(std::int64_t edit, const SiteWatch& watch) {
  const Places places = begin_change(watch);
  const std::vector<SiteSession> before = file_.sessions();
  if (!file_.remove_edit(edit)) {
    throw UsageError(fmt::format("{}: there is no edit {}; `loopstone site edits` lists them",
                                 file_.path(), edit));
  }
  const std::vector<SiteSession> after = file_.sessions();
  std::string log;
  for (std::size_t i = 0; i < before.size(); ++i)
    if (before[i].status != after[i].status) log = after[i].log;
  note("undo", log, fmt::format("edit {}", edit));
  if (!log.empty()) rejoin(places, watch);
  file_.commit();
}

}  // namespace loopstone
