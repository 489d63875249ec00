#pragma once

#include "loopstone/slam/motion_predictor.hpp"

namespace loopstone {

/// What the front end decides by.
struct FrontEndNumbers {
  int min_points = 20;
  int most_lost = 5;
  double lost_m = 2.0;
  double crowd_rest_s = 5.0;
  double led = 4.0;
  double led_along_m = 5e-4;
  double drives_m = 0.02;
  double turns_rad = 0.02;
  double leap_m = 0.15;
  double contradicted_share = 0.25;
  double score_per_chi2 = 0.004;
  double most_chi2 = 25.0;
  double most_guess_chi2 = 7.8;
  double outvoted = 0.01;
  double tells_nothing = 0.1;
  double same_score = 0.02;
  double score_drop = 0.1;
  double score_memory = 50.0;
  double free_window = 2.0;
  double bend_m = 0.01;
  double bend_rad = 0.005;
  int straightenings = 3;
  double skipped = 2.5;
  double companion_s = 0.2;
  float companion_guess = 0.1F;
};
inline constexpr FrontEndNumbers kFrontEnd{};

// Over 60 lines: a list, a number each.
template <typename Visitor>
void visit_numbers(const FrontEndNumbers& n, Visitor&& visit) {
  visit("min_points", n.min_points,
        "chosen: a scan with fewer says too little to be aligned or mapped");
  visit("most_lost", n.most_lost,
        "chosen: scans in a row that contradict the map are left out of it; after so many, half a "
        "second at ten scans a second, the place itself must have changed");
  visit("lost_m", n.lost_m,
        "chosen: how far a robot is looked for that was lost: it was seen a few scans ago");
  visit("crowd_rest_s", n.crowd_rest_s,
        "chosen: so long after people were last seen to stand about it the robot is not alone yet");
  visit("led", n.led,
        "chosen: weight of odometry that leads through a crowd: what of a scan goes with the robot "
        "says that it stands, and pulls half as far");
  visit("led_along_m", n.led_along_m,
        "chosen: so little that along what is seen beyond a crowd odometry alone leads");
  visit("drives_m", n.drives_m,
        "chosen: a robot whose odometry goes so far from scan to scan drives: a fifth of a metre a "
        "second");
  visit("turns_rad", n.turns_rad, "chosen: or turns by so much");
  visit(
      "leap_m", n.leap_m,
      "chosen: farther than wheels slip from scan to scan, or a late stamp lets the robot seem to "
      "go");
  visit("contradicted_share", n.contradicted_share,
        "chosen: of a scan of which no more lies where free space was seen, most is new");
  visit("score_per_chi2", n.score_per_chi2,
        "derived: a scan is worth 50 independent points, and that one is explained speaks for a "
        "match by ln(0.93 / 0.07) when one in fourteen never is: 0.5 / (50 * 2.6)");
  visit("most_chi2", n.most_chi2,
        "derived: 5 standard deviations, squared; beyond them the guess was an error, however far");
  visit("most_guess_chi2", n.most_guess_chi2,
        "derived: chi-square, 3 degrees of freedom, 0.05: a match farther from its guess shows "
        "that the guess was wrong");
  visit("outvoted", n.outvoted,
        "chosen: the weight that a wrong guess keeps; ten times its standard deviation, so that it "
        "holds only what nothing else does");
  visit(
      "tells_nothing", n.tells_nothing,
      "chosen: where a laser tells less than so much of what a guess says, it did not outvote it: "
      "its own standard deviation is three times as large");
  visit("same_score", n.same_score,
        "chosen: scores that differ by less say the same: a point in fifty");
  visit("score_drop", n.score_drop,
        "chosen: a scan that explains so much less than usual is searched for, or shows another "
        "place");
  visit("score_memory", n.score_memory,
        "chosen: scans over which the usual score is learned, some seconds");
  visit("free_window", n.free_window,
        "chosen: without odometry the window of a search is so many times wider: the robot may "
        "have turned back as well as gone on");
  visit("bend_m", n.bend_m,
        "chosen: a sweep bent by more by a wrong velocity is straightened anew: the laser's noise");
  visit("bend_rad", n.bend_rad, "chosen: as bend_m, of a point two metres off");
  visit("straightenings", n.straightenings,
        "derived: each takes away what the sweep is of the time between scans, half of the error "
        "or more: an eighth is left");
  visit(
      "skipped", n.skipped,
      "chosen: so many of the usual times between scans without one are a gap where nothing tells "
      "of the motion");
  visit("companion_s", n.companion_s,
        "chosen: what another laser saw so long ago still helps: two sweeps of a scanner that "
        "turns ten times a second");
  visit("companion_guess", n.companion_guess,
        "chosen: its weight where no odometry tells the motion since: what is guessed must not "
        "hold the robot back from moving otherwise");
}

/// What the front end decides by after the laser has not held the pose for a while.
struct FrontEndRejoinNumbers {
  double blind_s = kMotionPredictor.longest_coast_s;
  double blind_steps = kMotionPredictor.longest_coast_steps;
  double usual_memory = 20.0;
  double fits_chi2 = 11.3;
  double tight_m = 0.15;
  double drove_m = 0.1;
  double ride_m = 10.0;
  double short_m = 0.5;
  double short_rad = 0.5;
  double around_m = 10.0;
  double partly_score = 0.5;
  double partly_known = 0.6;
  double partly_agreement = 0.65;
  double partly_prior_m = 0.25;
  double ambiguous = 0.85;
  double elsewhere_m = 1.0;
  double elsewhere_rad = 0.35;
  double unknown_m = 10.0;
  double unknown_rad = 1.8;
  double window_sigmas = 2.0;
  double carried_m = 3.0;
  double carried_s = 3.0;
  double carried_along_m = 1.5;
  double turned_rad = 0.35;
  double likely_value = 0.65;
  double found_m = 0.3;
  double faced_rad = 0.05;
  double along_ratio = 2.0;
  double beside_m = 0.05;
  double along_rad = 0.01;
  double new_counts = 0.85;
  double rival = 0.6;
  double alike = 0.03;
  double usually_off = 0.5;
  double usual_turn_rad = 0.8;
  double reach_rest_m = 0.3;
  double reach_rest_rad = 0.1;
};
inline constexpr FrontEndRejoinNumbers kFrontEndRejoin{};

// Over 60 lines: a list, a number each.
template <typename Visitor>
void visit_numbers(const FrontEndRejoinNumbers& n, Visitor&& visit) {
  visit("blind_s", n.blind_s,
        "derived: without a scan for so long the motion is not followed but bridged: "
        "longest_coast_s of the prediction");
  visit("blind_steps", n.blind_steps,
        "derived: but not before so many of the usual times between scans: longest_coast_steps of "
        "the prediction");
  visit("usual_memory", n.usual_memory,
        "chosen: scans over which the usual time between them is learned");
  visit("fits_chi2", n.fits_chi2,
        "derived: chi-square, 3 degrees of freedom, 0.01: a scan nearer to where odometry says "
        "fits there");
  visit(
      "tight_m", n.tight_m,
      "derived: a cell and a half of a submap: a pose less certain does not go on in the same one");
  visit("drove_m", n.drove_m,
        "chosen: wheels that went so far while scans contradicted the map were on the ground");
  visit("ride_m", n.ride_m,
        "chosen: how far odometry alone leads on in a map that scans contradict: as far as a robot "
        "is looked for");
  visit("short_m", n.short_m,
        "chosen: after so little motion a scan shows what the one before showed");
  visit("short_rad", n.short_rad, "chosen: as short_m: most of what is seen is the same");
  visit("around_m", n.around_m, "chosen: no robot is looked for farther away: as far as loops are");
  visit(
      "partly_score", n.partly_score,
      "chosen: twice min_score of a search: of what is found although part of the scan shows what "
      "nobody saw before");
  visit("partly_known", n.partly_known, "chosen: the part that was seen before, no less");
  visit("partly_agreement", n.partly_agreement, "chosen: and how much of it lies on what was seen");
  visit("ambiguous", n.ambiguous,
        "chosen: share of the best score that no second place may reach, as of loop closures");
  visit("elsewhere_m", n.elsewhere_m, "chosen: a second place is so far away, as of loop closures");
  visit("elsewhere_rad", n.elsewhere_rad, "chosen: or turned by so much, 20 degrees");
  visit("unknown_m", n.unknown_m,
        "chosen: one standard deviation where nothing tells how the robot moved: as around_m");
  visit("unknown_rad", n.unknown_rad, "derived: of a heading that may be any: pi / sqrt(3)");
  visit("window_sigmas", n.window_sigmas,
        "chosen: half of the window in which a robot is looked for: 95 % along one axis");
  visit("carried_m", n.carried_m,
        "chosen: a robot that somebody carried: no less, one standard deviation; across a room");
  visit("carried_s", n.carried_s, "chosen: nobody lifts a robot, walks and puts it down in less");
  visit("carried_along_m", n.carried_along_m,
        "chosen: half of carried_m: so far, in two standard deviations, a robot may be off along a "
        "corridor that it may have been carried along");
  visit("along_ratio", n.along_ratio,
        "chosen: what is known so much better beside an axis than along it is known beside walls");
  visit("beside_m", n.beside_m,
        "chosen: there gaps of simulated drives along corridors ended right to 6 cm, 57 of 57");
  visit("along_rad", n.along_rad, "chosen: and faced right to 0.3 degrees, 56 of 57");
  visit("reach_rest_m", n.reach_rest_m,
        "chosen: how much farther than it can have driven a robot is looked for");
  visit("reach_rest_rad", n.reach_rest_rad, "chosen: as reach_rest_m");
  visit("new_counts", n.new_counts,
        "chosen: what of a scan shows places that nobody saw counts as what is explained usually; "
        "else a place seen before would win that only looks like a new one");
  visit("rival", n.rival,
        "chosen: share of the best score of a search that another place must reach to be asked");
  visit("alike", n.alike, "chosen: places that explain a scan so nearly alike do so equally well");
  visit("usually_off", n.usually_off, "chosen: two sigmas to where it stopped, four to turn back");
  visit("usual_turn_rad", n.usual_turn_rad,
        "chosen: more than a robot turns while nobody sees it, mostly: half of a right angle");
  visit("turned_rad", n.turned_rad,
        "derived: of a heading that was expected and explains the scan, when the robot turned by a "
        "right angle once in twenty times: sqrt(0.05) pi / 2");
  visit("likely_value", n.likely_value,
        "chosen: after gaps of simulated drives 25 of 26 places that do not explain all of a scan "
        "were right from there on, 4 of 6 below");
  visit("found_m", n.found_m,
        "chosen: there those 25 were nearer, one standard deviation all the same");
  visit(
      "faced_rad", n.faced_rad,
      "chosen: the headings of all 342 places there that no other faced differently were right to "
      "twice as much");
}

}  // namespace loopstone
