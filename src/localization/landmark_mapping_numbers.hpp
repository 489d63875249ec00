#pragma once

namespace loopstone {

/// How things seen are followed, recognised and judged.
struct LandmarkMappingNumbers {
  double forget_m = 3.0;
  double forget_sigma_m = 0.5;
  double stray_m = 0.01;
  double least_sigma_m = 0.005;
  double gate_chi2 = 13.8;
  double batch_m = 4.0;
  double density_reach_m = 6.0;
  double again_m = 1.5;
  double odds = 20.0;
  double together_share = 0.1;
  int most_nodes = 500;
  double resolve_sigmas = 3.0;
  int rounds = 3;
  int weight_rounds = 4;
  double misfit_chi2 = 13.8;
  double wander_m = 0.05;
  double wander_sigmas = 4.0;
  double through_share = 0.5;
  double radius_least_m = 0.01;
  double radius_step_m = 0.02;
  double least_noise = 0.05;
  double round_chi2 = 10.0;
};
inline constexpr LandmarkMappingNumbers kLandmarkMapping{};

template <typename Visitor>
void visit_numbers(const LandmarkMappingNumbers& n, Visitor&& visit) {
  visit("forget_m", n.forget_m,
        "chosen: what was not seen for so far is looked for again as if it were new");
  visit("forget_sigma_m", n.forget_sigma_m,
        "chosen: the same of what is known no better than this: landmarks stand 1 m apart");
  visit(
      "stray_m", n.stray_m,
      "chosen: a thing seems to move by so much from one pose to the next, as round ones do whose "
      "surface is seen");
  visit("least_sigma_m", n.least_sigma_m, "chosen: nothing is followed more narrowly");
  visit("gate_chi2", n.gate_chi2,
        "derived: chi-square of two degrees of freedom, exceeded by 1e-3 of true pairs");
  visit("batch_m", n.batch_m,
        "chosen: what comes into view along so much path is recognised together: a constellation");
  visit("density_reach_m", n.density_reach_m,
        "chosen: how dense landmarks stand is counted so far around");
  visit("again_m", n.again_m,
        "chosen: two landmarks of the solved map that may be one stand no farther apart");
  visit("odds", n.odds,
        "chosen: a pairing is taken when it is so many times as probable as the best without it");
  visit("together_share", n.together_share,
        "chosen: two things that were seen at once more often, by share of the sightings of the "
        "one seen less, are two: clutter is rarer");
  visit("most_nodes", n.most_nodes,
        "chosen: pairings tried; where more are possible the drift is too wide to tell");
  visit("resolve_sigmas", n.resolve_sigmas,
        "chosen: a pair this far apart moves the map, so that it is solved before the next");
  visit("rounds", n.rounds,
        "chosen: of looking once more for landmarks that stand in the map twice, and of dropping");
  visit("weight_rounds", n.weight_rounds,
        "chosen: of weighing sightings anew; weights change little after three");
  visit("misfit_chi2", n.misfit_chi2,
        "chosen: a thing whose median sighting is off by more (the gate) does not stay in place");
  visit("wander_m", n.wander_m,
        "chosen: the two halves of a visit see a thing no farther apart; poses are better known");
  visit("wander_sigmas", n.wander_sigmas, "chosen: nor so many standard deviations");
  visit("through_share", n.through_share,
        "chosen: a landmark that was seen through more often than this was not there for long");
  visit("radius_least_m", n.radius_least_m, "chosen: thinner ones count as flat");
  visit("radius_step_m", n.radius_step_m,
        "chosen: radii are tried so far apart, and then by a tenth of it about the best");
  visit("least_noise", n.least_noise,
        "chosen: sightings are no better than this share of the variance that they are told to "
        "have");
  visit("round_chi2", n.round_chi2,
        "chosen: a landmark is round when that explains so much chi-square: three sigmas");
}

}  // namespace loopstone
