#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/mapping/submap.hpp"
#include "loopstone/registration/grid_matcher.hpp"
#include "loopstone/slam/loop_closer.hpp"
#include "loopstone/slam/submap_record.hpp"
#include "slam/loop_surroundings.hpp"

namespace loopstone {

/// What two drives must say of one another where the map lays them on each other.
struct DriveTieNumbers {
  double near_m = 8.0;
  std::size_t submaps_max = 40;
  std::size_t beside_max = 2;
  std::size_t drives_max = 3;
  double least_overlap = 0.5;
  double more_off = 0.04;
  double usual_off = 0.04;
  double least_seen = 500.0;
  double most_empty = 0.25;
  int rounds = 2;
};
inline constexpr DriveTieNumbers kDriveTies{};

template <typename Visitor>
void visit_numbers(const DriveTieNumbers& n, Visitor&& visit) {
  visit("near_m", n.near_m, "chosen: what is farther from a submap's first scan says nothing");
  visit("submaps_max", n.submaps_max, "chosen: submaps of a drive that are asked of another one");
  visit("beside_max", n.beside_max, "chosen: each about the nearest ones, so many");
  visit("drives_max", n.drives_max,
        "chosen: of drives that were tied before, those that overlap the most are asked");
  visit("least_overlap", n.least_overlap,
        "chosen: of these, those that overlap at least by this share of the most; one of them must "
        "show the same place");
  visit("more_off", n.more_off,
        "chosen: of surfaces near others, the share that lies beside them, may be so much more "
        "than within the drive that scatters more; through one place it is 0.02 less to 0.02 more, "
        "through copies of a wing, whose walls are bent by centimetres each its own way, 0.07 to "
        "0.14 more");
  visit("usual_off", n.usual_off,
        "chosen: this share within a drive that never came back; of most drives 0.01 to 0.08");
  visit("least_seen", n.least_seen, "chosen: it never did where fewer surfaces were seen again");
  visit("most_empty", n.most_empty,
        "chosen: share of surfaces in the other's free space; of drives on different days, with "
        "things moved and people about, 0.04 to 0.2, of rooms laid on others 0.3 to 0.9");
  visit("rounds", n.rounds,
        "chosen: a drive whose ties were taken back is looked for again, in all so often");
}

/// A drive where the map lays it, with all its submaps.
struct LaidDrive {
  std::span<const SubmapRecord> submaps{};
  std::span<const Pose2> map_T_submaps{};
};

/// Pairs of submaps of two drives that show parts of one place, by the map: at most submaps_max
/// of the newer drive, spread evenly, with beside_max of the older one each. Of a drive and itself:
/// of submaps that share no scans.
[[nodiscard]] std::vector<SubmapPair> overlapping(const LaidDrive& older, const LaidDrive& newer);

/// How two drives lie on each other. Cost: some milliseconds a pair of submaps.
[[nodiscard]] SurfaceFit fit_of(const LaidDrive& older, const LaidDrive& newer,
                                std::span<const SubmapPair> overlap, const SubmapOptions& options,
                                const GridMatchOptions& match, Threads threads);

/// How much a drive scatters: of its surfaces near others that it saw again, the share that lies
/// beside them. Cost: as of two drives.
[[nodiscard]] double scatter_of(const LaidDrive& drive, const SubmapOptions& options,
                                const GridMatchOptions& match, Threads threads);

/// Whether drives that lie on each other like this show one place. A copy of a place, such as the
/// next floor's wing, is like it to within decimetres, not centimetres; and where a false tie lays
/// one drive over other rooms, walls of one stand in what was free to the other.
/// \param scatter  of the drive that scatters more
[[nodiscard]] bool shows_one_place(const SurfaceFit& fit, double scatter);

}  // namespace loopstone
