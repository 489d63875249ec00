// A law of all matchers: where there is too little to align, the status says so, the pose is the
// guess, and nothing is claimed to be known about it.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "loopstone/registration/align.hpp"
#include "loopstone/registration/correlative_match.hpp"
#include "loopstone/registration/icp.hpp"
#include "loopstone/registration/surface_grid.hpp"

namespace loopstone {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
const Pose2 kGuess{0.2, -0.1, 0.3};

template <int kDimension>
void expect_nothing_known(const BasicMatchResult<kDimension>& match, std::string_view what) {
  SCOPED_TRACE(what);
  EXPECT_FALSE(has_supported_pose(match.status)) << to_string(match.status);
  for (Eigen::Index i = 0; i < match.covariance.rows(); ++i) {
    EXPECT_EQ(match.covariance(i, i), kInf) << i;
    for (Eigen::Index k = 0; k < i; ++k) EXPECT_EQ(match.covariance(i, k), 0.0);
  }
  EXPECT_TRUE(std::isfinite(match.rmse_m));
  EXPECT_EQ(match.score, 0.0);
}

void expect_no_match(const MatchResult& match, std::string_view what) {
  expect_nothing_known<2>(match, what);
  EXPECT_EQ(match.target_T_source.x, kGuess.x) << what;
  EXPECT_EQ(match.target_T_source.y, kGuess.y) << what;
  EXPECT_EQ(match.target_T_source.yaw, kGuess.yaw) << what;
}

/// Nothing, a point, and points that lie where no target is.
std::vector<std::vector<Eigen::Vector2d>> too_little() {
  std::vector<Eigen::Vector2d> far;
  for (int i = 0; i < 50; ++i) far.emplace_back(1e4 + i, 1e4 - 0.1 * i * i);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  return {{}, {{1.0, 0.0}}, {{nan, nan}, {nan, 0.0}}, far};
}

std::vector<Eigen::Vector2d> corner() {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 60; ++i) {
    points.emplace_back(0.05 * i, 0.0);
    points.emplace_back(0.0, 0.05 * i);
  }
  return points;
}

std::vector<SurfacePoint> as_surfaces(const std::vector<Eigen::Vector2d>& points) {
  std::vector<SurfacePoint> surfaces;
  for (const Eigen::Vector2d& point : points) {
    if (point.allFinite()) surfaces.push_back({point.cast<float>(), {0.0F, 1.0F}});
  }
  return surfaces;
}

std::vector<Eigen::Vector3d> in_space(const std::vector<Eigen::Vector2d>& points) {
  std::vector<Eigen::Vector3d> lifted;
  for (const Eigen::Vector2d& point : points) {
    lifted.emplace_back(point.x(), point.y(), 0.3 * point.x() * point.y());
  }
  return lifted;
}

/// Four walls around free cells.
Grid<std::int8_t> room_map() {
  Grid<std::int8_t> map(GridFrame{{-3.0, -3.0}, 0.1, 60, 60}, std::int8_t{0});
  for (int i = 0; i < 60; ++i) {
    for (const Cell cell : {Cell{i, 0}, Cell{i, 59}, Cell{0, i}, Cell{59, i}}) map[cell] = 100;
  }
  return map;
}

/// A scan of so many beams, all of which see the same range.
RobotScan scan_of(int beams, double range_m) {
  RobotScan scan;
  scan.scan.angle_min_rad = -1.0;
  scan.scan.angle_increment_rad = 0.02;
  scan.scan.range_min_m = 0.1;
  scan.scan.range_max_m = 30.0;
  scan.scan.ranges_m.assign(static_cast<std::size_t>(beams), static_cast<float>(range_m));
  return scan;
}

TEST(NoMatch, IcpInThePlane) {
  const IcpCloud<2> target = make_icp_cloud<2>(corner());
  for (const IcpMetric metric :
       {IcpMetric::kPoint, IcpMetric::kLine, IcpMetric::kPlane, IcpMetric::kGicp}) {
    IcpOptions options;
    options.metric = metric;
    for (const auto& source : too_little()) {
      expect_no_match(match_icp(source, target, kGuess, options), to_string(metric));
    }
    expect_no_match(match_icp(corner(), make_icp_cloud<2>({}), kGuess, options), to_string(metric));
  }
}

TEST(NoMatch, IcpInSpace) {
  const IcpCloud<3> target = make_icp_cloud<3>(in_space(corner()));
  const Pose3 guess = Pose3::from_pose2(kGuess);
  for (const IcpMetric metric : {IcpMetric::kPoint, IcpMetric::kPlane, IcpMetric::kGicp}) {
    IcpOptions options;
    options.metric = metric;
    for (const auto& source : too_little()) {
      const MatchResult3 match = match_icp(in_space(source), target, guess, options);
      expect_nothing_known<3>(match, to_string(metric));
      EXPECT_EQ(match.target_T_source.translation, guess.translation);
    }
  }
}

TEST(NoMatch, Grid) {
  constexpr double kResolutionsM[] = {0.1, 0.2};
  SurfaceGrid target(kResolutionsM);
  const SurfaceGrid empty(kResolutionsM);
  target.insert(as_surfaces(corner()), {});
  for (const bool with_prior : {false, true}) {
    std::optional<PosePrior2> prior;
    if (with_prior) prior = PosePrior2{kGuess, 100.0 * Eigen::Matrix3d::Identity()};
    for (const auto& source : too_little()) {
      expect_no_match(match_to_grid(as_surfaces(source), target, kGuess, prior, {}, 1), "grid");
    }
    expect_no_match(match_to_grid(as_surfaces(corner()), empty, kGuess, prior, {}, 1), "empty");
  }
}

TEST(NoMatch, Field) {
  const MapField field(room_map());
  for (const auto& source : too_little()) {
    if (!source.empty() && !source.front().allFinite()) continue;  // asks for finite points
    expect_no_match(match_to_field(source, field, kGuess), "field");
  }
}

TEST(NoMatch, Scans) {
  BeamTable beams;
  const auto view = [&beams](const RobotScan& scan) {
    return view_scan(scan.scan, scan.robot_T_lidar, scan.velocity, beams);
  };
  const ScanView something = view(scan_of(100, 3.0));
  for (const RobotScan& scan : {scan_of(0, 0.0), scan_of(1, 3.0), scan_of(100, kInf)}) {
    expect_no_match(match_scans(view(scan), something, kGuess), "few to many");
    expect_no_match(match_scans(something, view(scan), kGuess), "many to few");
  }
}

TEST(NoMatch, Correlative) {
  const MaxPyramid target = make_correlative_target(corner(), 1.0);
  const SearchWindow window{kGuess, 0.5, 0.3};
  for (const auto& source : too_little()) {
    if (source.size() < 3) continue;  // a single point fits on any other
    if (!source.front().allFinite()) continue;
    expect_no_match(match_correlative(source, target, window).match, "correlative");
  }
}

TEST(NoMatch, CloudSearch) {
  const CloudModel<2> flat{corner()};
  const CloudModel<3> deep{in_space(corner())};
  for (const auto& source : too_little()) {
    if (source.size() > 3) continue;  // a search finds the far ones
    expect_nothing_known<2>(search_alignment<2>(source, flat).match, "plane");
    expect_nothing_known<3>(search_alignment<3>(in_space(source), deep).match, "space");
  }
}

TEST(NoMatch, AlignWhateverTheMethod) {
  const std::vector<Eigen::Vector2d> target = corner();
  for (const auto& [method, name] : kWordTable<AlignMethod>) {
    if (method == AlignMethod::kGrid) continue;  // not for points
    AlignRequest<2> request;
    request.method = method;
    request.guess = kGuess;
    const std::vector<Eigen::Vector2d> nothing;
    expect_no_match(align(nothing, target, request).match, name);
    expect_no_match(align(target, nothing, request).match, name);
    request.guess.reset();
    expect_nothing_known<2>(align(nothing, target, request).match, name);
    expect_nothing_known<2>(align(target, nothing, request).match, name);
  }
  for (const auto& [method, name] : kWordTable<AlignMethod>) {
    AlignRequest<2> request;
    request.method = method;
    request.guess = kGuess;
    expect_no_match(align(scan_of(100, kInf), scan_of(100, 3.0), request).match, name);
    expect_no_match(align(scan_of(100, 3.0), scan_of(100, kInf), request).match, name);
    expect_no_match(align(scan_of(100, kInf), room_map(), request).match, name);
  }
}

}  // namespace
}  // namespace loopstone
