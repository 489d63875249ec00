#pragma once

namespace loopstone {

/// Where good ends and where bad begins.
struct VerdictLimits {
  double doubtful;
  double bad;
};

/// What the verdict decides by.
struct MapVerdictNumbers {
  VerdictLimits doubled_share{0.10, 0.15};
  VerdictLimits entropy_gain_nats{0.693, 1.099};
  VerdictLimits crossed_share{0.15, 0.30};
  VerdictLimits missed_share{0.20, 0.30};
  VerdictLimits reduced_chi2{1.5, 4.0};
  VerdictLimits revoked_share{0.05, 0.30};
  VerdictLimits contradicted_wall_m{2.5, 10.0};
  double contradicted_share = 0.3;
  double contradicted_least_m = 0.15;
  double sure_sigmas = 3.0;
  double right_m = 0.5;
  double right_rad = 0.0262;
  double negligible = 0.333;
  double open_share = 0.05;
  double passing_s = 30.0;
  VerdictLimits break_tie_m{0.167, 2.0};
  double untold_m = 1.0;
  double bridged_s = 2.5;
  int bridged_scans = 3;
  VerdictLimits left_out_share{0.05, 0.5};
  double short_travel_m = 1.0;
  double certified_near_m = 0.10;
  int least_walls = 200;
  int least_beams = 500;
  int least_returns = 500;
  int least_entropy_points = 50;
};
inline constexpr MapVerdictNumbers kMapVerdict{};

template <typename Visitor>
void visit_numbers(const MapVerdictNumbers& n, Visitor&& visit) {
  constexpr const char* kShare =
      "measured by bench/quality.py: between right and spoiled maps, nearer to the right ones";
  constexpr const char* kLeast = "chosen: fewer say nothing";
  visit("doubled_share_doubtful", n.doubled_share.doubtful, kShare);
  visit("doubled_share_bad", n.doubled_share.bad, kShare);
  visit("entropy_gain_doubtful_nats", n.entropy_gain_nats.doubtful,
        "derived: ln 2, twice as blurred as single stretches of travel");
  visit("entropy_gain_bad_nats", n.entropy_gain_nats.bad, "derived: ln 3, three times as blurred");
  visit("crossed_share_doubtful", n.crossed_share.doubtful, kShare);
  visit("crossed_share_bad", n.crossed_share.bad, kShare);
  visit("missed_share_doubtful", n.missed_share.doubtful, kShare);
  visit("missed_share_bad", n.missed_share.bad, kShare);
  visit("reduced_chi2_doubtful", n.reduced_chi2.doubtful,
        "chosen: 1 is what the covariances promise");
  visit("reduced_chi2_bad", n.reduced_chi2.bad,
        "chosen: errors twice as large as the covariances promise");
  visit("revoked_share_doubtful", n.revoked_share.doubtful,
        "chosen: one closure in twenty contradicted the others");
  visit("revoked_share_bad", n.revoked_share.bad,
        "chosen: so many contradicted that those that stand may be as wrong");
  visit("contradicted_wall_doubtful_m", n.contradicted_wall_m.doubtful,
        "chosen: a door with its frame, or a person, is less");
  visit("contradicted_wall_bad_m", n.contradicted_wall_m.bad, "chosen: a room is drawn twice");
  visit("contradicted_share", n.contradicted_share,
        "measured by bench/quality.py: what moves between visits is up to a quarter of what they "
        "say about each other");
  visit("contradicted_least_m", n.contradicted_least_m,
        "chosen: where two visits can't be off to one another by more, as the path between them "
        "says, things moved meanwhile");
  visit("sure_sigmas", n.sure_sigmas, "chosen: one in 300 lies beyond");
  visit("right_m", n.right_m, "chosen: a map that is off by less is right");
  visit("negligible", n.negligible,
        "chosen: loose parts that may all together be off by less than this share of it, and of "
        "right_rad, make no right map wrong");
  visit("open_share", n.open_share,
        "chosen: of the length of a bare corridor, three standard deviations: what wheels measured "
        "with a ruler leave open; such a map is good, and says which stretch and by how much");
  visit("right_rad", n.right_rad,
        "measured by bench/covariances.py: a degree and a half, for headings drift less than their "
        "covariances say (NEES of 0.3 to 0.6)");
  visit("passing_s", n.passing_s,
        "chosen: an odometer that is broken stays so; what passes may as well have been the laser");
  visit("break_tie_doubtful_m", n.break_tie_m.doubtful,
        "derived: three of these standard deviations are right_m");
  visit("break_tie_bad_m", n.break_tie_m.bad, "chosen: what doubles a corridor");
  visit("untold_m", n.untold_m,
        "chosen: a robot of which nothing told for a moment went no farther, one standard "
        "deviation, than from one place to another that closures tell apart");
  visit("bridged_s", n.bridged_s, "chosen: what is off for less is no part of the path");
  visit("bridged_scans", n.bridged_scans, "chosen: nor are fewer scans");
  visit("left_out_share_doubtful", n.left_out_share.doubtful,
        "chosen: one scan or record in twenty could not be used");
  visit("left_out_share_bad", n.left_out_share.bad, "chosen: half of the log could not be used");
  visit("short_travel_m", n.short_travel_m,
        "chosen: less travel, or less of it degenerate, tells nothing");
  visit("certified_near_m", n.certified_near_m, "chosen: two cells of a map of 5 cm");
  visit("least_walls", n.least_walls, kLeast);
  visit("least_beams", n.least_beams, kLeast);
  visit("least_returns", n.least_returns, kLeast);
  visit("least_entropy_points", n.least_entropy_points, kLeast);
}

}  // namespace loopstone
