#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/graph/pose_graph.hpp"
#include "loopstone/mapping/submap.hpp"
#include "loopstone/registration/grid_matcher.hpp"
#include "loopstone/slam/loop_closer.hpp"
#include "loopstone/slam/loop_closure.hpp"
#include "loopstone/slam/submap_record.hpp"
#include "slam/placement.hpp"

namespace loopstone {

/// When another place is as good as the one that a closure found across a break of the path.
struct RivalPlacesNumbers {
  double wide_m = 0.5;
  double wide_rad = 0.3;
  double any_rad = 1.05;
  std::size_t probe_points = 350;
  double near_radii = 0.7;
  double window_sigmas = 2.5;
  double score_share = 0.6;
  double again_share = 0.8;
  double again_overlap = 0.5;
  double lead_chi2 = 4.605;
  double half_rad = 0.1;
  double unlikely_chi2 = 25.0;
  double ambiguous_chi2 = 7.815;
  double drift_per_m = 0.01;
  double drift_rad_per_m = 0.001;
  double same_share = 0.5;
  double clearly_less = 0.05;
};
inline constexpr RivalPlacesNumbers kRivalPlaces{};

template <typename Visitor>
void visit_numbers(const RivalPlacesNumbers& n, Visitor&& visit) {
  visit("wide_m", n.wide_m,
        "chosen: what the path knows to one standard deviation of this needs no asking elsewhere: "
        "half of elsewhere_m");
  visit("wide_rad", n.wide_rad,
        "chosen: as wide_m, of the heading: three of these are less than a right angle");
  visit("any_rad", n.any_rad,
        "derived: three standard deviations of a heading that may be turned by half a circle");
  visit("probe_points", n.probe_points,
        "chosen: surfaces of the newer submap that the search uses");
  visit("near_radii", n.near_radii,
        "chosen: two submaps nearer than this share of both their radii show parts of one place");
  visit("window_sigmas", n.window_sigmas,
        "chosen: as far as this from where the path puts it a place is looked for");
  visit("score_share", n.score_share,
        "chosen: another place may score this share of the found one's score: places that are "
        "alike are seen from elsewhere, and overlap less");
  visit("again_share", n.again_share,
        "chosen: a place that repeats itself scores and agrees so nearly as well on its own "
        "repetition as the closure on it");
  visit("again_overlap", n.again_overlap, "chosen: and overlaps by half");
  visit("lead_chi2", n.lead_chi2,
        "derived: a place is the likelier one by 10 to 1 when the path's chi-square of it is "
        "lower by 2 ln 10");
  visit("half_rad", n.half_rad, "chosen: alike places face the same way, give or take this");
  visit("unlikely_chi2", n.unlikely_chi2,
        "chosen: five standard deviations: what is farther from where the path leads needs more "
        "than looks");
  visit("ambiguous_chi2", n.ambiguous_chi2,
        "derived: chi-square of three degrees of freedom, exceeded by one in twenty: among several "
        "poses that fit alike the path is believed about the one where it leads");
  visit("drift_per_m", n.drift_per_m,
        "chosen: standard deviation of what no covariance of a path knows, such as a scale");
  visit("drift_rad_per_m", n.drift_rad_per_m, "chosen: the same of the heading");
  visit("same_share", n.same_share,
        "chosen: rivals nearer to one another than this share of what makes a place another are "
        "one");
  visit("clearly_less", n.clearly_less,
        "chosen: where the submaps around agree by this much less than at the place that was found "
        "there is no rival: in bare corridors the right one leads by 0.057 and more, among alike "
        "rooms by nothing");
}

/// Covariance of the motion from the older end of each closure to its newer one as the path and the
/// closures that stand have it, (x, y, yaw) in the older one's frame.
/// \param graph  of the submaps, with the closures that stand, solved
/// Empty where nothing can be said. Cost: some factorisations.
[[nodiscard]] std::vector<Eigen::Matrix3d> known_motions(const PoseGraph& graph,
                                                         std::span<const LoopClosure> closures);

/// Whether a closure is where the path may lead, with what its covariance does not know.
/// \param known     of known_motions()
/// \param travel_m  between its ends
[[nodiscard]] bool is_likely(const LoopClosure& closure, const Eigen::Matrix3d& known,
                             double travel_m, std::span<const SubmapRecord> submaps);

/// Whether what lies behind a break fits elsewhere as well, in any place of other pieces of the
/// path that what is known of the motion allows, and is not far less likely there; for each
/// closure. Those that lay it in one place are asked together: what their submaps and those around
/// show must agree clearly less with what was seen wherever else any of them fits. A corridor
/// repeats itself for any one submap of it, but for each by another step. Where the older place
/// repeats itself, it may do so once more where nobody was yet, and where the path does not know
/// the heading a place may look alike from the other side: then what lies behind the break must
/// also agree with the place that was found as submaps of one piece do.
/// \param all  closures; those that wait or were ambiguous name places, too
/// Cost: a search for each submap within reach of each end; for each place found, a small one for
/// each pair of submaps there.
[[nodiscard]] std::vector<bool> have_rival_places(
    std::span<const AskedClosure> asked, std::span<const LoopClosure> all,
    std::span<const SubmapRecord> submaps, const LoopOptions& options,
    const SubmapOptions& submap_options, const GridMatchOptions& match_options, Threads threads);

/// Whether the older submap of a closure between drives that nothing ties fits on another place of
/// its own drive as well: then the newer one may be on either, or on a third that nobody saw.
/// Cost: a search by appearance for each submap of the drive.
[[nodiscard]] bool repeats_itself(const LoopClosure& closure, std::span<const SubmapRecord> submaps,
                                  const LoopOptions& options, const SubmapOptions& submap_options,
                                  const GridMatchOptions& match_options);

}  // namespace loopstone
