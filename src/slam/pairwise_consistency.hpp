#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "loopstone/slam/loop_closure.hpp"
#include "loopstone/slam/submap_record.hpp"

namespace loopstone {

/// When closures are believed.
struct PairwiseConsistencyNumbers {
  double harmless_m = 0.25;
  double harmless_rad = 0.04;
  double agrees_chi2 = 11.345;
  double notices_chi2 = 9.0;
  double path_rest_m = 0.05;
  double path_share = 0.01;
  double path_rest_rad = 0.01;
  double path_rad_per_m = 0.002;
  double travel_most_m = 40.0;
  double shared_overlap = 0.75;
  double shared_agreement = 0.85;
};
inline constexpr PairwiseConsistencyNumbers kPairwiseConsistency{};

template <typename Visitor>
void visit_numbers(const PairwiseConsistencyNumbers& n, Visitor&& visit) {
  visit("harmless_m", n.harmless_m,
        "chosen: a correction this small can't spoil a map, true or not; half a door");
  visit("harmless_rad", n.harmless_rad, "chosen: the same of the heading, 2.3 degrees");
  visit("agrees_chi2", n.agrees_chi2,
        "derived: chi-square of three degrees of freedom, exceeded by one in a hundred");
  visit("notices_chi2", n.notices_chi2,
        "derived: three standard deviations, by which a second closure must tell the correction "
        "from none");
  visit("path_rest_m", n.path_rest_m,
        "chosen: standard deviation that the path between the closures' ends adds at rest");
  visit("path_share", n.path_share, "chosen: the same per metre of that path");
  visit("path_rest_rad", n.path_rest_rad, "chosen: as path_rest_m, of the heading");
  visit("path_rad_per_m", n.path_rad_per_m, "chosen: as path_share, of the heading");
  visit("travel_most_m", n.travel_most_m,
        "chosen: over more travel between the closures' ends agreement says little");
  visit("shared_overlap", n.shared_overlap,
        "chosen: neighbours along the path hold scans of each other, and what deceives one "
        "deceives the other; closures between such pairs must each overlap so much");
  visit("shared_agreement", n.shared_agreement, "chosen: and agree so well");
}

/// Whether a closure says what the map says already, in the directions that it holds: it may stand
/// on its own.
[[nodiscard]] bool bends_nothing(const LoopClosure& closure, std::span<const SubmapRecord> submaps);

/// Whether a closure is where the map puts it already, in every direction.
[[nodiscard]] bool is_foretold(const LoopClosure& closure, std::span<const SubmapRecord> submaps);

/// What a closure does to its newer end, map frame, were it followed.
[[nodiscard]] Pose2 map_move_of(const LoopClosure& closure, std::span<const SubmapRecord> submaps);

/// By how much a closure insists on moving its newer end [m], map frame: its correction, less what
/// it does not hold.
[[nodiscard]] Eigen::Vector2d map_pull_of(const LoopClosure& closure,
                                          std::span<const SubmapRecord> submaps);

/// Whether two closures between the same stretches of the path ask for the same correction: the
/// loop of both and of the path between their ends closes, and would not without the correction.
/// Two false closures seldom err alike, unless they are of the same scans: closures of submaps that
/// are neighbours on both sides count as two only where each overlaps by three quarters and agrees
/// to 85 %.
/// Of places in drives that nothing ties, no correction is the one that there would be without the
/// second closure: there it is enough that the loop closes.
/// Source: Mangelson et al. 2018, "Pairwise consistent measurement set maximization for robust
/// multi-robot map merging".
[[nodiscard]] bool are_consistent(const LoopClosure& a, const LoopClosure& b,
                                  std::span<const SubmapRecord> submaps, bool are_adrift = false);

/// Which of the closures that wait may stand: those that bend nothing, and those with which
/// another one, standing or waiting, is consistent. One that fits elsewhere as well and bends
/// nothing stands only where the map foretells it. Returns their places among the closures.
[[nodiscard]] std::vector<std::size_t> consistent_ones(std::span<const LoopClosure> closures,
                                                       std::span<const SubmapRecord> submaps);

/// Of consistent closures those that are to be settled first: of such as tie two drives that
/// nothing ties yet the best two that agree, since to settle one asks every place of the map. Where
/// they stand, the others have but to fit.
[[nodiscard]] std::vector<std::size_t> first_ties(std::span<const LoopClosure> closures,
                                                  std::vector<std::size_t> consistent,
                                                  std::span<const SubmapRecord> submaps);

}  // namespace loopstone
