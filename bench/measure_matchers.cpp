// This project's scan matchers over a file of pairs, structures included, see answers.hpp:
//   measure_matchers FILE MATCHER COUNT        without arguments: the names of the matchers

#include <array>

#include "answers.hpp"
#include "loopstone/registration/correlative_match.hpp"
#include "loopstone/registration/grid_matcher.hpp"
#include "loopstone/registration/icp.hpp"
#include "loopstone/registration/scan_matcher.hpp"
#include "loopstone/registration/surface_grid.hpp"
#include "loopstone/sensor/scan_points.hpp"

namespace loopstone::bench {
namespace {

Answer answer_of(const MatchResult& match) {
  return {match.target_T_source, match.status == MatchStatus::kConverged, match.covariance};
}

/// The directions of the beams are computed once, as long as the scanner stays the same.
BeamTable& beams() {
  static BeamTable table;
  return table;
}

Answer scan_matcher(const PairToMatch& input) {
  const ScanView target = view_scan(input.pair.target, Pose2{}, Tangent2::Zero(), beams());
  const ScanView source = view_scan(input.pair.source, Pose2{}, Tangent2::Zero(), beams());
  return answer_of(match_scans(source, target, input.pair.guess));
}

Matcher icp_matcher(IcpMetric metric) {
  return [=](const PairToMatch& input) {
    IcpOptions options;
    options.metric = metric;
    return answer_of(
        match_icp(input.source, make_icp_cloud<2>(input.target), input.pair.guess, options));
  };
}

/// The window of match_scans; a few hundred points of the source are enough for a search.
Answer correlative_matcher(const PairToMatch& input) {
  const ScanMatchOptions like;
  const SearchWindow window{input.pair.guess, like.search_half_xy_m, like.search_half_yaw_rad};
  const MaxPyramid target = make_correlative_target(input.target, window.half_xy_m);
  const std::size_t step = input.source.size() / 300 + 1;
  Points source;
  for (std::size_t i = 0; i < input.source.size(); i += step) source.push_back(input.source[i]);
  return answer_of(match_correlative(source, target, window).match);
}

/// One scan as the whole map, as at the start of a submap, without a prior.
Answer grid_matcher(const PairToMatch& input) {
  const std::array<double, 2> resolutions_m{0.1, 0.3};
  SurfaceGrid grid(resolutions_m);
  grid.insert(surface_points(input.pair.target, Pose2{}, Tangent2::Zero(), {}, beams()), Pose2{});
  const auto source = surface_points(input.pair.source, Pose2{}, Tangent2::Zero(), {}, beams());
  return answer_of(match_to_grid(source, grid, input.pair.guess, {}, {}, 1));
}

std::vector<NamedMatcher> all_matchers() {
  return {{"match_scans", scan_matcher},
          {"match_correlative", correlative_matcher},
          {"icp_point", icp_matcher(IcpMetric::kPoint)},
          {"icp_line", icp_matcher(IcpMetric::kLine)},
          {"icp_plane", icp_matcher(IcpMetric::kPlane)},
          {"icp_gicp", icp_matcher(IcpMetric::kGicp)},
          {"match_to_grid", grid_matcher}};
}

}  // namespace
}  // namespace loopstone::bench

int main(int argc, char** argv) {
  return loopstone::bench::answer_main(argc, argv, loopstone::bench::all_matchers());
}
