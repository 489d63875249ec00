#include "match_plane.hpp"

#include <chrono>

#include "loopstone/registration/correlative_search.hpp"
#include "loopstone/registration/surface_cells.hpp"
#include "loopstone/registration/surface_grid.hpp"
#include "match_clouds.hpp"

namespace loopstone::app {

namespace {

using Points2 = std::vector<Eigen::Vector2d>;

/// How wide --search-xy and --search-yaw are when only the other one is given.
constexpr double kDefaultSearchXyM = 1.0;
constexpr double kDefaultSearchYawRad = 0.35;
/// match_scans searches no farther.
constexpr double kScansSearchXyM = 2.0;

/// Both sides as the matchers want them.
struct Plane {
  const MatchInput& source;
  const MatchInput& target;
  Points2 source_points;
  Points2 target_points;
  MatchRequest<2> request;
  MatchSettings<2> settings;

  [[nodiscard]] SearchWindow window(const Pose2& centre) const {
    return {centre, request.search_xy_m.value_or(kDefaultSearchXyM),
            request.search_yaw_rad.value_or(kDefaultSearchYawRad)};
  }
};

Pose2 first_guess(const Plane& plane) {
  if (!plane.request.from_centroids) return plane.request.initial.value_or(Pose2{});
  return initial_guess<2>(IcpGuess::kCentroids, plane.source_points, plane.target_points);
}

ScanView view_of(const LogScan& scan) {
  BeamTable beams;
  return view_scan(scan.scan, scan.robot_T_lidar, scan.velocity, beams);
}

/// Scan against scan: a coarse search about the guess, then Gauss-Newton.
void match_two_scans(MatchOutcome<2>& outcome, const Plane& plane) {
  ScanMatchOptions options = plane.settings.scans;
  const MatchRequest<2>& request = plane.request;
  if (request.global) {
    options.search_half_xy_m = kScansSearchXyM;
    options.search_half_yaw_rad = kPi;
  }
  if (request.searches()) {
    options.search_half_xy_m = request.search_xy_m.value_or(options.search_half_xy_m);
    options.search_half_yaw_rad = request.search_yaw_rad.value_or(options.search_half_yaw_rad);
  }
  const ScanView source = view_of(*plane.source.scan);
  const ScanView target = view_of(*plane.target.scan);
  const Matcher<2> matcher = [&](const Pose2& guess) {
    return match_scans(source, target, guess, options);
  };
  match_from_starts<2>(outcome, request, {first_guess(plane)}, matcher);
  outcome.method = "scans";
}

/// Scan against the surfaces of a scan on grids.
void match_on_surfaces(MatchOutcome<2>& outcome, const Plane& plane) {
  constexpr double kResolutionsM[] = {0.1, 0.2, 0.4};
  BeamTable beams;
  const auto surfaces = [&beams](const LogScan& scan) {
    return surface_points(scan.scan, scan.robot_T_lidar, scan.velocity, SurfaceOptions{}, beams);
  };
  SurfaceGrid grid(kResolutionsM);
  grid.insert(surfaces(*plane.target.scan), Pose2{});
  const std::vector<SurfacePoint> source = surfaces(*plane.source.scan);
  const Matcher<2> matcher = [&](const Pose2& guess) {
    return match_to_grid(source, grid, guess, {}, plane.settings.grid, grid.level_count() - 1);
  };
  match_from_starts<2>(outcome, plane.request, {first_guess(plane)}, matcher);
  outcome.method = "grid";
}

/// Gauss-Newton on the distances to a map's walls.
void match_on_field(MatchOutcome<2>& outcome, const Plane& plane) {
  const MapField field(*plane.target.map, plane.settings.map.field);
  const Matcher<2> matcher = [&](const Pose2& guess) {
    return match_to_field(plane.source_points, field, guess, plane.settings.field);
  };
  match_from_starts<2>(outcome, plane.request, {first_guess(plane)}, matcher);
  outcome.method = "grid";
}

/// A best pose that others rival is no answer: the status says so.
MatchStatus status_of(const MapMatch& found, const MapMatchOptions& options) {
  if (!found.found()) return MatchStatus::kNotConverged;
  const MatchResult& best = found.poses.front();
  if (found.sure) return best.status;
  const bool rivalled =
      found.poses.size() > 1 && best.score - found.poses[1].score <= options.sure_gap;
  return rivalled && best.score >= options.sure_score ? MatchStatus::kDegenerate
                                                      : MatchStatus::kNotConverged;
}

/// Branch and bound over a window of a map, or all of it.
void search_map(MatchOutcome<2>& outcome, const Plane& plane) {
  // The search wants the laser's frame; everybody else the robot's.
  const Pose2 robot_T_lidar = plane.source.scan ? plane.source.scan->robot_T_lidar : Pose2{};
  const Pose2 lidar_T_robot = robot_T_lidar.inverse();
  Points2 points;
  for (const Eigen::Vector2d& point : plane.source_points) points.push_back(lidar_T_robot * point);

  outcome.guess = first_guess(plane);
  outcome.method = "correlative";
  const bool anywhere =
      plane.request.global || (!plane.request.initial && !plane.request.searches());
  std::optional<SearchWindow> window;
  if (!anywhere) window = plane.window(outcome.guess * robot_T_lidar);
  const MapSearch search(*plane.target.map, plane.settings.map);
  MapMatch found = match_on_map(points, search, window, plane.settings.map_match);
  for (MatchResult& match : found.poses) {
    const PoseWithCovariance2 map_T_robot =
        compound({match.target_T_source, match.covariance}, {lidar_T_robot});
    match.target_T_source = map_T_robot.pose;
    match.covariance = map_T_robot.covariance;
  }
  outcome.match =
      found.found() ? found.poses.front() : MatchResult{.target_T_source = outcome.guess};
  outcome.match.status = status_of(found, plane.settings.map_match);
  outcome.map_match = std::move(found);
}

/// Branch and bound over a window of a scan or cloud, then refinement.
void search_points(MatchOutcome<2>& outcome, const Plane& plane) {
  constexpr double kCellShare = 0.01;  // of the target's radius
  constexpr int kLevels = 7;
  constexpr double kMinScore = 0.2;
  const bool scans = plane.source.scan && plane.target.scan;
  const CloudExtent<2> target = cloud_extent<2>(plane.target_points);
  const double cell_m = scans ? 0.05 : std::max(kCellShare * target.radius_m, 1e-6);
  const MaxPyramid pyramid(surface_cells(plane.target_points, cell_m, 2.0 * cell_m), kLevels,
                           kUnknown);
  outcome.guess = first_guess(plane);
  outcome.method = "correlative";
  SearchWindow window = plane.window(outcome.guess);
  if (plane.request.global) window = {window.centre, 2.0 * target.radius_m, kPi};
  constexpr std::size_t kMostPoints = 400;
  Points2 some;
  const std::size_t step = std::max<std::size_t>(1, plane.source_points.size() / kMostPoints);
  for (std::size_t i = 0; i < plane.source_points.size(); i += step)
    some.push_back(plane.source_points[i]);
  const SearchResult found = search_branch_and_bound(some, pyramid, window, kMinScore);
  if (!found.found) {
    outcome.match = {.target_T_source = outcome.guess};
    return;
  }
  if (scans) {
    ScanMatchOptions options = plane.settings.scans;
    options.search_half_xy_m = options.search_half_yaw_rad = 0.0;
    outcome.match = match_scans(view_of(*plane.source.scan), view_of(*plane.target.scan),
                                found.target_T_source, options);
    return;
  }
  outcome.match = match_icp(plane.source_points,
                            make_icp_cloud<2>(plane.target_points, plane.settings.icp_cloud),
                            found.target_T_source, plane.settings.icp);
}

void refuse(bool wrong, const std::string& reason) {
  if (wrong) throw UsageError(reason);
}

void dispatch(MatchOutcome<2>& outcome, const Plane& plane) {
  const MatchRequest<2>& request = plane.request;
  const std::string& method = request.method;
  const bool on_map = plane.target.map.has_value();
  const bool scans = plane.source.scan && plane.target.scan;
  const bool icp = method == "gicp" || method.starts_with("icp_");
  refuse(icp && request.searches(),
         "--search-xy and --search-yaw go with --method correlative or auto; --method " + method +
             " converges from its guess");
  refuse(request.sweep_yaw > 0 && (method == "correlative" || request.global),
         "--sweep-yaw tries many starts, and a search needs none: leave one of them out");
  refuse(method == "grid" && !on_map && !scans,
         "--method grid aligns a scan to a scan or a map; use icp_line or icp_plane for clouds");
  refuse(method == "grid" && (request.global || request.searches()),
         "--method grid converges from its guess; leave it out to search");
  const bool guessed = request.initial || request.from_centroids || request.sweep_yaw > 0;
  if (on_map) {
    const bool search =
        method == "correlative" || (method == "auto" && (request.searches() || !guessed));
    if (search || request.global) return search_map(outcome, plane);
    if (method == "auto" || method == "grid") return match_on_field(outcome, plane);
  } else if (scans) {
    const bool far = request.search_xy_m.value_or(0.0) > kScansSearchXyM;
    if (method == "correlative" || far) return search_points(outcome, plane);
    if (method == "auto") return match_two_scans(outcome, plane);
    if (method == "grid") return match_on_surfaces(outcome, plane);
  } else if (method == "correlative" || (method == "auto" && request.searches())) {
    return search_points(outcome, plane);
  }
  match_clouds<2>(outcome, plane.source_points, plane.target_points, request, plane.settings);
}

template <int kDimension, typename Run>
MatchOutcome<kDimension> timed(Run run) {
  const auto start = std::chrono::steady_clock::now();
  MatchOutcome<kDimension> outcome = run();
  outcome.wall_time_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return outcome;
}

}  // namespace

MatchOutcome<2> match_in_plane(const MatchInput& source, const MatchInput& target,
                               const MatchRequest<2>& request, const AppContext& context) {
  Plane plane{source, target, source.points2(), target.points2(), request, {}};
  const double target_radius_m = cloud_extent<2>(plane.target_points).radius_m;
  const bool cloud = source.cloud.has_value() && !target.map;
  MatchSettings<2> defaults = cloud ? settings_for_radius<2>(target_radius_m) : MatchSettings<2>{};
  if (target.map) {
    // Both faces of a thin wall lie a cell or two apart: only the next cells belong to the same one.
    defaults.icp.max_pair_distance_m = 1.0;
    defaults.icp_cloud.patches.neighbours = 3;
    defaults.icp_cloud.patches.dense_radius_m = 0.0;
    defaults.icp_cloud.patches.smooth = false;
  }
  plane.settings = context.load_options(defaults);
  return timed<2>([&] {
    MatchOutcome<2> outcome;
    outcome.source = cloud_extent<2>(plane.source_points);
    dispatch(outcome, plane);
    return outcome;
  });
}

MatchOutcome<3> match_in_space(const MatchInput& source, const MatchInput& target,
                               const MatchRequest<3>& request, const AppContext& context) {
  refuse(
      request.method == "correlative" || request.method == "grid" || request.method == "icp_line",
      "--method " + request.method +
          " is for the plane; in space there are icp_point, "
          "icp_plane, gicp and --global");
  refuse(request.searches(),
         "--search-xy and --search-yaw are for the plane; in space use --global");
  refuse(request.global && request.sweep_yaw > 0,
         "--sweep-yaw tries many starts, and --global needs none: leave one of them out");
  const std::vector<Eigen::Vector3d> source_points = source.points3();
  const std::vector<Eigen::Vector3d> target_points = target.points3();
  const MatchSettings<3> settings =
      context.load_options(settings_for_radius<3>(cloud_extent<3>(target_points).radius_m));
  return timed<3>([&] {
    MatchOutcome<3> outcome;
    outcome.source = cloud_extent<3>(source_points);
    match_clouds<3>(outcome, source_points, target_points, request, settings);
    return outcome;
  });
}

}  // namespace loopstone::app
