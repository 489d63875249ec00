#pragma once

namespace loopstone {

/// Where good ends and where bad begins.
struct VerdictLimits {
  double doubtful;
  double bad;
};

/// What the verdict decides by.
struct MapVerdictNumbers {
  VerdictLimits doubled_share{0.03, 0.15};
  VerdictLimits entropy_gain_nats{0.693, 1.099};
  VerdictLimits crossed_share{0.15, 0.30};
  VerdictLimits missed_share{0.10, 0.25};
  VerdictLimits reduced_chi2{1.5, 4.0};
  VerdictLimits revoked_share{0.05, 0.30};
  VerdictLimits degenerate_share{0.05, 0.50};
  VerdictLimits break_tie_m{0.10, 2.0};
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
  visit("degenerate_share_doubtful", n.degenerate_share.doubtful,
        "chosen: the map's length rests on odometry there");
  visit("degenerate_share_bad", n.degenerate_share.bad, "chosen: the map mostly rests on odometry");
  visit("break_tie_doubtful_m", n.break_tie_m.doubtful, "chosen: two cells of a map of 5 cm");
  visit("break_tie_bad_m", n.break_tie_m.bad, "chosen: what doubles a corridor");
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
