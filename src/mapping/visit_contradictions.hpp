#pragma once

#include <span>
#include <utility>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/mapping/visit_contradiction.hpp"
#include "mapping/judged_scans.hpp"
#include "mapping/visit_agreement.hpp"

namespace loopstone {

/// What regions of contradiction are made by.
struct VisitContradictionsNumbers {
  double apart_m = 0.3;
  double place_m = 0.5;
  int least_beams = 2;
  double least_share = 0.5;
  double least_wall_m = 1.0;
  int most_regions = 8;
  double tie_way_m = 30.0;
  double tie_wall_m = 4.0;
  double tie_share = 0.8;
  double tie_held = 0.1;
};
inline constexpr VisitContradictionsNumbers kVisitContradictions{};

template <typename Visitor>
void visit_numbers(const VisitContradictionsNumbers& n, Visitor&& visit) {
  visit("apart_m", n.apart_m,
        "derived: two visits that lie less apart can't make either of them wrong by half a metre");
  visit("place_m", n.place_m, "chosen: side of the squares in which evidence is counted");
  visit("least_beams", n.least_beams, "chosen: one beam or piece by itself may be a mixed pixel");
  visit("least_share", n.least_share,
        "chosen: of what two visits say about a place, most contradicts");
  visit("least_wall_m", n.least_wall_m, "chosen: smaller regions are not listed");
  visit("most_regions", n.most_regions, "chosen: so many are listed, the worst");
  visit("tie_way_m", n.tie_way_m,
        "derived: twice the range out to which scans are judged; farther along the path only a "
        "robot that came back sees the same walls");
  visit("tie_wall_m", n.tie_wall_m, "chosen: so much wall drawn alike by two visits is no chance");
  visit("tie_share", n.tie_share, "chosen: of what they say about each other, most agrees");
  visit("tie_held", n.tie_held,
        "chosen: the walls hold both directions, the weaker by this share: a bare corridor holds "
        "one");
}

/// First and last judged scan of each stretch; of a stretch without scans, the one before.
using StretchTimes = std::vector<std::pair<Stamp, Stamp>>;
[[nodiscard]] StretchTimes stretch_times(std::span<const JudgedScan> scans);

/// Joins what contradicts between the same two visits, place by place, to regions: places that lie
/// within a metre or so and whose stretches follow one another. The worst first, by metres of wall
/// times their share. Cost: some microseconds a meeting that contradicts. Deterministic.
[[nodiscard]] std::vector<VisitContradiction> visit_contradictions(
    std::span<const WallOffset> offsets, std::span<const BeamMeeting> meetings,
    const StretchTimes& times);

/// The pairs of stretches that agree; in order.
[[nodiscard]] std::vector<VisitTie> agreeing_visits(std::span<const WallOffset> offsets,
                                                    std::span<const BeamMeeting> meetings,
                                                    const StretchTimes& times);

}  // namespace loopstone
