#pragma once

namespace loopstone {

/// What loose parts of a graph are found by.
struct LoosePartsNumbers {
  double same_place_m = 3.0;
  double open_ratio = 3.0;
  double open_gap_m = 2.0;
  double open_turn_rad = 0.5;
  double off_share = 0.5;
  double open_least_m = 1.0;
  double way_m = 1.0;
  int way_steps = 10;
  int most_open = 12;
  int most_loose = 12;
  int least_loops = 3;
  double least_factor = 0.02;
  double most_factor = 25.0;
  int draws = 200;
  int most_steps = 400;
  double sure_share = 0.975;
};
inline constexpr LoosePartsNumbers kLooseParts{};

template <typename Visitor>
void visit_numbers(const LoosePartsNumbers& n, Visitor&& visit) {
  visit("same_place_m", n.same_place_m,
        "chosen: closures whose ends lie so near along the path are one recognition, right or "
        "wrong together");
  visit("open_ratio", n.open_ratio,
        "chosen: an edge that tells no more than its covariance is open where it is three times as "
        "uncertain along one direction as across");
  visit("open_gap_m", n.open_gap_m, "chosen: a door post within a corridor does not divide it");
  visit("open_turn_rad", n.open_turn_rad, "chosen: round a corner another direction is open");
  visit("off_share", n.off_share,
        "chosen: the truth lies between map and odometry, in two standard deviations");
  visit("open_least_m", n.open_least_m, "chosen: shorter ones tell nothing");
  visit("way_m", n.way_m,
        "chosen: of the path that tells which way it leads; shorter than a corridor is wide");
  visit("way_steps", n.way_steps, "chosen: bounds the search for it where the robot stands");
  visit("most_open", n.most_open, "chosen: bounds the cost; the longest are asked for");
  visit("most_loose", n.most_loose, "chosen: so many are told, the least certain");
  visit("least_loops", n.least_loops,
        "chosen: with fewer the chi-square of loops is chance, and covariances count as they are");
  visit("least_factor", n.least_factor,
        "measured by bench/quality.py: of edges that tell no drift; in clean worlds they are seven "
        "times too wide");
  visit("most_factor", n.most_factor, "chosen: five times as wrong as promised says enough");
  visit("draws", n.draws,
        "chosen: of how far the map may be off, so many tell the rarest fortieth");
  visit("most_steps", n.most_steps, "chosen: bounds the cost; a path has a bend in some metres");
  visit("sure_share", n.sure_share, "chosen: two standard deviations, both sides");
}

}  // namespace loopstone
