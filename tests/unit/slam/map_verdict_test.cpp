#include "loopstone/slam/map_verdict.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/slam/map_result.hpp"

namespace loopstone {
namespace {

/// A map without fault: every figure measured, every figure fine.
MapResult fine_map() {
  MapResult result;
  result.quality = {.scans = 500,
                    .visits = 40,
                    .returns = 50000,
                    .sensor_noise_m = 0.01,
                    .local_spread_m = 0.005,
                    .walls_compared = 5000,
                    .wall_offset_m = 0.01,
                    .wall_offset_worst_m = 0.04,
                    .doubled_share = 0.004,
                    .wall_thickness_m = 0.016,
                    .entropy_points = 1000,
                    .entropy_nats = -3.0,
                    .entropy_gain_nats = 0.3,
                    .beams_tested = 20000,
                    .crossed_share = 0.02,
                    .held_out_returns = 9000,
                    .held_out_agreement = 0.97};
  result.graph_quality.loops = 20;
  result.graph_quality.closures = 20;
  result.graph_quality.reduced_chi2 = 0.4;
  result.graph_quality.certificate = Certificate{.status = CertificateStatus::kCertified};
  result.graph_quality.certified_shift_m = 0.01;
  result.statistics.path_length_m = 200.0;
  result.statistics.degenerate_travel_m = 2.0;
  return result;
}

Verdict verdict_of(const MapVerdict& verdict, const std::string& name) {
  const auto found = std::find_if(verdict.measures.begin(), verdict.measures.end(),
                                  [&](const auto& measure) { return measure.name == name; });
  EXPECT_NE(found, verdict.measures.end()) << name;
  return found == verdict.measures.end() ? Verdict::kUnknown : found->verdict;
}

TEST(MapVerdict, IsGoodWhenAllIs) {
  const MapVerdict verdict = judge_map(fine_map());
  EXPECT_EQ(verdict.overall, Verdict::kGood);
  EXPECT_EQ(verdict.measures.size(), 11U);
  for (const QualityMeasure& measure : verdict.measures) {
    EXPECT_EQ(measure.verdict, Verdict::kGood) << measure.name;
    EXPECT_FALSE(measure.sentence.empty()) << measure.name;
    EXPECT_FALSE(measure.title.empty()) << measure.name;
  }
  EXPECT_EQ(verdict.sentence.substr(0, 4), "Good");
}

/// One figure spoiled, and what becomes of it.
struct Spoiled {
  const char* name;
  void (*spoil)(MapResult&, double);
  double doubtful;
  double bad;
};

TEST(MapVerdict, FollowsEachFigureByItself) {
  const std::vector<Spoiled> cases{
      {"wall_thickness_m", [](MapResult& r, double v) { r.quality.doubled_share = v; }, 0.12, 0.4},
      {"entropy_gain_nats", [](MapResult& r, double v) { r.quality.entropy_gain_nats = v; }, 0.9,
       1.5},
      {"free_space_violations", [](MapResult& r, double v) { r.quality.crossed_share = v; }, 0.2,
       0.5},
      {"held_out_agreement", [](MapResult& r, double v) { r.quality.held_out_agreement = v; }, 0.75,
       0.4},
      {"reduced_chi2", [](MapResult& r, double v) { r.graph_quality.reduced_chi2 = v; }, 2.0, 9.0},
  };
  for (const Spoiled& spoiled : cases) {
    for (const bool bad : {false, true}) {
      MapResult result = fine_map();
      spoiled.spoil(result, bad ? spoiled.bad : spoiled.doubtful);
      const MapVerdict verdict = judge_map(result);
      const Verdict expected = bad ? Verdict::kBad : Verdict::kDoubtful;
      EXPECT_EQ(verdict_of(verdict, spoiled.name), expected) << spoiled.name;
      EXPECT_EQ(verdict.overall, expected) << spoiled.name;
      const auto good =
          std::count_if(verdict.measures.begin(), verdict.measures.end(),
                        [](const auto& measure) { return measure.verdict == Verdict::kGood; });
      EXPECT_EQ(good, 10) << spoiled.name;
    }
  }
}

TEST(MapVerdict, AMapIsNoBetterThanWhatTiesItsPieces) {
  PathBreak gap{.bridge = BreakBridge::kOdometry};
  gap.covariance.diagonal() << 0.25, 0.25, 0.01;
  double possible_m = 0.8;
  const auto judged = [&](BreakBridge bridge, int closures, double tie_sigma_m) {
    MapResult result = fine_map();
    result.ties.possible_beside.m = possible_m;
    gap.bridge = bridge;
    gap.closures = closures;
    gap.tie_sigma_m = tie_sigma_m;
    result.breaks = {gap};
    return verdict_of(judge_map(result), "break_tie_m");
  };
  EXPECT_EQ(judged(BreakBridge::kLaser, 0, 0.5), Verdict::kGood);
  EXPECT_EQ(judged(BreakBridge::kOdometry, 0, 0.5), Verdict::kDoubtful);
  EXPECT_EQ(judged(BreakBridge::kOdometry, 0, 3.0), Verdict::kBad);
  EXPECT_EQ(judged(BreakBridge::kOdometry, 1, 0.05), Verdict::kDoubtful) << "a single closure";
  EXPECT_EQ(judged(BreakBridge::kOdometry, 3, 0.05), Verdict::kGood);
  EXPECT_EQ(judged(BreakBridge::kNothing, 0, 0.05), Verdict::kDoubtful) << "a guess";
  EXPECT_EQ(judged(BreakBridge::kNothing, 0, 3.0), Verdict::kBad);
  EXPECT_EQ(judged(BreakBridge::kNothing, 1, 0.05), Verdict::kDoubtful) << "a single closure";
  EXPECT_EQ(judged(BreakBridge::kNothing, 4, 0.05), Verdict::kGood) << "it can't have gone far";
  gap.covariance.diagonal() << 2.25, 2.25, 0.01;
  EXPECT_EQ(judged(BreakBridge::kNothing, 4, 0.05), Verdict::kDoubtful) << "a likeness of places";
  gap.covariance.diagonal() << 0.25, 0.25, 0.01;
  possible_m = 0.3;
  gap.odometry_m = 3.0;
  EXPECT_EQ(judged(BreakBridge::kOdometry, 0, 0.5), Verdict::kGood) << "no place moves by so much";
  gap.odometry_m = 0.0;
  gap.covariance.diagonal() << 2.25, 0.01, 0.01;
  EXPECT_EQ(judged(BreakBridge::kOdometry, 0, 1.5), Verdict::kDoubtful)
      << "it may have been carried along walls that agree all the same";
  EXPECT_EQ(judged(BreakBridge::kOdometry, 2, 0.05), Verdict::kGood) << "it was not";
  gap.covariance.diagonal() << 0.25, 0.25, 0.01;
  EXPECT_EQ(judged(BreakBridge::kNothing, 0, 0.05), Verdict::kDoubtful);
  gap.ends_log = true;
  EXPECT_EQ(judged(BreakBridge::kOdometry, 0, 0.5), Verdict::kDoubtful) << "no key scan follows it";
  gap.ends_log = false;
  possible_m = 0.8;
  gap.cause = BreakCause::kCarried;
  EXPECT_EQ(judged(BreakBridge::kNothing, 4, 0.05), Verdict::kDoubtful) << "a likeness of places";
  EXPECT_EQ(judged(BreakBridge::kNothing, 0, 3.0), Verdict::kBad);
  EXPECT_EQ(judged(BreakBridge::kLaser, 0, 0.0), Verdict::kDoubtful)
      << "found again by the scan, which is a likeness of places, too";
}

TEST(MapVerdict, APathThatRodeOnOdometryMayBeOffThoughBothSidesAreTied) {
  MapResult result = fine_map();
  for (int i = 0; i < 100; ++i) result.trajectory.append(Stamp::from_seconds(i), Pose2{});
  PathBreak gap{.from = Stamp::from_seconds(20.0), .to = Stamp::from_seconds(50.0)};
  gap.tie_sigma_m = 0.0;
  gap.covariance.diagonal() << 0.09, 0.09, 0.0001;
  const auto judged = [&] {
    result.breaks = {gap};
    return judge_map(result);
  };
  EXPECT_EQ(judged().overall, Verdict::kGood);
  gap.covariance(0, 0) = 0.64;
  EXPECT_EQ(verdict_of(judged(), "break_tie_m"), Verdict::kDoubtful);
  const std::vector<QualityMeasure> measures = judged().measures;
  EXPECT_TRUE(std::any_of(measures.begin(), measures.end(), [](const QualityMeasure& measure) {
    return measure.sentence.find("the path may be off by 80 cm") != std::string::npos;
  }));
  gap.covariance(0, 0) = 0.09;
  gap.covariance(2, 2) = 0.01;
  EXPECT_EQ(verdict_of(judged(), "break_tie_m"), Verdict::kDoubtful) << "turned";
  gap.to = Stamp::from_seconds(21.9);
  EXPECT_EQ(judged().overall, Verdict::kGood) << "no scan was taken meanwhile";
}

VisitContradiction drawn_twice() {
  return {.low = {10.0, -2.0},
          .high = {14.0, 1.0},
          .first_from = Stamp::from_seconds(20.0),
          .first_to = Stamp::from_seconds(40.0),
          .second_from = Stamp::from_seconds(300.0),
          .second_to = Stamp::from_seconds(330.0),
          .wall_m = 8.0,
          .share = 0.6,
          .apart_m = 5.4};
}

TEST(MapVerdict, TheWorstRegionDecidesAndIsNamed) {
  MapResult result = fine_map();
  result.trajectory.append(Stamp::from_seconds(10.0), Pose2{});
  result.quality.contradictions = {drawn_twice()};
  const MapVerdict verdict = judge_map(result);
  EXPECT_EQ(verdict_of(verdict, "contradicted_wall_m"), Verdict::kDoubtful);
  EXPECT_EQ(verdict.overall, Verdict::kDoubtful);
  for (const char* words : {"x 12.0, y -0.5", "4 x 3 m", "from 10.0 to 30.0 s",
                            "from 290.0 to 320.0 s", "8 m of wall", "5.4 m"})
    EXPECT_NE(verdict.sentence.find(words), std::string::npos) << words << verdict.sentence;
  result.quality.contradictions.front().wall_m = 20.0;
  EXPECT_EQ(judge_map(result).overall, Verdict::kBad);
}

TEST(MapVerdict, WhatMovedBetweenVisitsIsNoContradiction) {
  MapResult result = fine_map();
  result.quality.contradictions = {drawn_twice(), drawn_twice()};
  result.quality.contradictions[0].share = 0.1;  // doors and chairs, among walls that agree
  result.quality.contradictions[1].wall_m = 1.5;
  EXPECT_EQ(judge_map(result).overall, Verdict::kGood);
  // Or what two visits that lie close together along the path say of one another.
  result.quality.contradictions = {drawn_twice()};
  result.ties.contradictions_m = {0.1};
  EXPECT_EQ(judge_map(result).overall, Verdict::kGood);
  result.ties.contradictions_m = {0.4};
  EXPECT_EQ(judge_map(result).overall, Verdict::kDoubtful);
}

TEST(MapVerdict, APartThatHangsLooselyIsToldWithWhatItCouldMove) {
  MapResult result = fine_map();
  result.trajectory.append(Stamp{}, Pose2{});
  const auto judged = [&](double sigma_m, double sigma_rad) {
    result.ties.loose = {{.from = Stamp::from_seconds(50.0),
                          .to = Stamp::from_seconds(90.0),
                          .path_m = 30.0,
                          .where = {3.0, 4.0},
                          .sigma_m = sigma_m,
                          .sigma_rad = sigma_rad}};
    result.ties.possible = result.ties.possible_beside = {2.0 * sigma_m, 2.0 * sigma_rad};
    return judge_map(result);
  };
  EXPECT_EQ(judged(0.1, 0.002).overall, Verdict::kGood);
  EXPECT_EQ(judged(0.1, 0.03).overall, Verdict::kDoubtful) << "turned";
  const MapVerdict verdict = judged(0.4, 0.002);
  EXPECT_EQ(verdict_of(verdict, "loose_part_m"), Verdict::kDoubtful);
  for (const char* words : {"30 m of the path from 50.0 to 90.0 s", "x 3.0, y 4.0", "1.2 m"})
    EXPECT_NE(verdict.sentence.find(words), std::string::npos) << words << verdict.sentence;
}

TEST(MapVerdict, APartThatLosesNextToNothingMakesNoMapDoubtful) {
  MapResult result = fine_map();
  result.trajectory.append(Stamp{}, Pose2{});
  result.ties.possible = result.ties.possible_beside = {.m = 0.6, .rad = 0.002};
  EXPECT_EQ(judge_map(result).overall, Verdict::kGood);
  result.ties.loose.assign(2, {.sigma_m = 0.02, .sigma_rad = 0.001});
  EXPECT_EQ(judge_map(result).overall, Verdict::kGood);
  result.ties.loose.assign(4, {.sigma_m = 0.02, .sigma_rad = 0.001});
  EXPECT_EQ(judge_map(result).overall, Verdict::kDoubtful) << "all together";
}

TEST(MapVerdict, ABareCorridorIsDoubtfulOnlyWhereItsLengthIs) {
  MapResult result = fine_map();
  result.statistics.degenerate_travel_m = 150.0;
  result.ties.open = {{.path_m = 60.0, .sigma_m = 0.1}};
  EXPECT_EQ(judge_map(result).overall, Verdict::kGood);
  result.ties.open.front().sigma_m = 0.3;
  EXPECT_EQ(judge_map(result).overall, Verdict::kGood) << "best aligned it is half of that";
  result.ties.possible.m = 0.6;
  const MapVerdict told = judge_map(result);
  EXPECT_EQ(told.overall, Verdict::kGood) << "as long as wheels measure";
  for (const char* words : {"Good", "60 m of the path", "too long or too short by 90 cm"})
    EXPECT_NE(told.sentence.find(words), std::string::npos) << words << ": " << told.sentence;
  result.ties.loose = {{.path_m = 60.0, .sigma_m = 0.3}};
  EXPECT_EQ(judge_map(result).overall, Verdict::kGood) << "beside its length it loses nothing";
  result.ties.possible_beside.m = 0.6;
  EXPECT_EQ(judge_map(result).overall, Verdict::kDoubtful);
  result.ties.possible_beside.m = 0.1;
  result.ties.open.front().sigma_m = 1.5;
  EXPECT_EQ(verdict_of(judge_map(result), "degenerate_travel_share"), Verdict::kDoubtful)
      << "worse than wheels";
  result.ties.open.insert(result.ties.open.begin(), {.path_m = 200.0, .sigma_m = 2.0});
  EXPECT_EQ(judge_map(result).overall, Verdict::kDoubtful) << "one of them";
}

TEST(MapVerdict, AMapOfAPartOfTheLogIsNotGood) {
  for (const auto& [share, expected] :
       {std::pair{0.01, Verdict::kGood}, {0.2, Verdict::kDoubtful}, {0.8, Verdict::kBad}}) {
    MapVerdict verdict = judge_map(fine_map());
    judge_left_out(verdict, share);
    EXPECT_EQ(verdict.overall, expected) << share;
    EXPECT_EQ(verdict_of(verdict, "log_left_out_share"), expected) << share;
  }
  MapVerdict none;
  judge_left_out(none, 0.9);
  EXPECT_TRUE(none.measures.empty()) << "of a map that was not judged";
}

TEST(MapVerdict, AMapOfASuspectLaserIsNotGood) {
  MapResult result = fine_map();
  result.trajectory.append(Stamp{0}, Pose2{});
  result.statistics.odometry_translation_scale = 0.97;
  EXPECT_EQ(verdict_of(judge_map(result), "sensor_faults"), Verdict::kGood);
  result.statistics.odometry_translation_scale = 0.91;
  EXPECT_EQ(verdict_of(judge_map(result), "sensor_faults"), Verdict::kDoubtful);
}

TEST(MapVerdict, ScansThatWereNotUsedAreToldAndLeaveTheMapAsGoodAsItIs) {
  MapResult result = fine_map();
  result.trajectory.append(Stamp{}, Pose2{});
  result.laser_episodes = {{.fault = LaserFault::kCovered,
                            .from = Stamp::from_seconds(30.0),
                            .to = Stamp::from_seconds(60.0),
                            .scans = 178}};
  const MapVerdict verdict = judge_map(result);
  EXPECT_EQ(verdict.overall, Verdict::kGood);
  EXPECT_TRUE(std::ranges::any_of(verdict.measures, [](const QualityMeasure& measure) {
    return measure.name == "sensor_faults" && measure.value == 1.0 &&
           measure.sentence.find("covered in part") != std::string::npos;
  }));
  result.statistics.odometry_translation_scale = 0.91;
  EXPECT_EQ(judge_map(result).overall, Verdict::kDoubtful) << "the laser, or odometry";
}

TEST(MapVerdict, WhenLaserAndOdometryContradictForAWhileEitherMayBeWrong) {
  MapResult result = fine_map();
  result.trajectory.append(Stamp{}, Pose2{});
  result.odometry_episodes = {
      {.from = Stamp::from_seconds(160.0), .to = Stamp::from_seconds(168.0), .over = true}};
  EXPECT_EQ(verdict_of(judge_map(result), "sensor_faults"), Verdict::kDoubtful);
  result.odometry_episodes[0].fault = OdometryFault::kStuck;
  EXPECT_EQ(judge_map(result).overall, Verdict::kGood) << "odometry's own fault";
  result.odometry_episodes[0] = {.to = Stamp::from_seconds(300.0), .over = true};
  EXPECT_EQ(judge_map(result).overall, Verdict::kGood) << "an odometer that is broken stays so";
}

TEST(MapVerdict, WhatIsNotProvenIsDoubtfulNotBad) {
  MapResult result = fine_map();
  result.graph_quality.certificate =
      Certificate{.status = CertificateStatus::kGapOpen, .cost = 7.0, .optimality_gap = 1.7};
  EXPECT_EQ(judge_map(result).overall, Verdict::kDoubtful);
  result = fine_map();
  result.graph_quality.certified_shift_m = 3.0;
  EXPECT_EQ(judge_map(result).overall, Verdict::kDoubtful);
  result = fine_map();
}

TEST(MapVerdict, ManyRevokedClosuresAreSuspicious) {
  MapResult result = fine_map();
  result.graph_quality.closures_revoked = 3;
  EXPECT_EQ(verdict_of(judge_map(result), "reduced_chi2"), Verdict::kDoubtful);
  result.graph_quality.closures_revoked = 15;
  EXPECT_EQ(verdict_of(judge_map(result), "reduced_chi2"), Verdict::kBad);
}

TEST(MapVerdict, AFigureThatIsNoNumberIsNotGood) {
  MapResult result = fine_map();
  result.quality.crossed_share = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(judge_map(result).overall, Verdict::kBad);
}

TEST(MapVerdict, WithoutASecondVisitNothingIsKnown) {
  const MapVerdict empty = judge_map(MapResult{});
  EXPECT_EQ(empty.overall, Verdict::kUnknown);
  for (const QualityMeasure& measure : empty.measures)
    EXPECT_EQ(measure.verdict, Verdict::kUnknown) << measure.name;

  MapResult once;
  once.quality = {.scans = 100, .visits = 20, .returns = 10000, .sensor_noise_m = 0.01};
  once.statistics.path_length_m = 80.0;
  EXPECT_EQ(judge_map(once).overall, Verdict::kUnknown)
      << "no degenerate travel is no evidence for a good map";
  once.ties.open = {{.path_m = 20.0, .sigma_m = 0.6}};
  once.ties.possible.m = 0.7;
  EXPECT_EQ(judge_map(once).overall, Verdict::kDoubtful);
}

TEST(MapVerdict, NoShareIsAboveOne) {
  MapResult result = fine_map();
  result.statistics.degenerate_travel_m = 1.2 * result.statistics.path_length_m;
  for (const QualityMeasure& measure : judge_map(result).measures) {
    if (measure.name == "degenerate_travel_share") {
      EXPECT_EQ(measure.value, 1.0);
    }
  }
}

/// A square of four nodes; the last edge closes the loop.
MapResult square(double wrong_m) {
  MapResult result;
  const Pose2 side{1.0, 0.0, kPi / 2.0};
  Pose2 pose;
  for (int i = 0; i < 4; ++i) {
    result.graph.poses.push_back(pose);
    pose = pose * side;
    if (i > 0) result.graph.edges.push_back({NodeId{i - 1}, NodeId{i}, side});
  }
  result.graph.edges.push_back({NodeId{3}, NodeId{0}, Pose2{1.0 + wrong_m, 0.0, kPi / 2.0},
                                Eigen::Matrix3d::Identity(), EdgeKind::kLoopClosure});
  return result;
}

GraphQuality assess_square(const MapResult& result) {
  return assess_graph(result.graph, result.graph.poses, result.loop_closures);
}

TEST(GraphQuality, ABoundThatRoundingKeepsOpenIsAProof) {
  MapResult result = fine_map();
  Certificate open{.status = CertificateStatus::kGapOpen, .cost = 7.0, .optimality_gap = 0.0007};
  result.graph_quality.certificate = open;
  EXPECT_TRUE(result.graph_quality.is_proven());
  EXPECT_EQ(verdict_of(judge_map(result), "certified_shift_m"), Verdict::kGood);
  open.optimality_gap = 0.7;
  result.graph_quality.certificate = open;
  EXPECT_TRUE(result.graph_quality.is_proven()) << "less than one edge's standard deviation";
  open.optimality_gap = 1.5;
  result.graph_quality.certificate = open;
  EXPECT_FALSE(result.graph_quality.is_proven());
  EXPECT_EQ(verdict_of(judge_map(result), "certified_shift_m"), Verdict::kDoubtful);
  open.status = CertificateStatus::kNotOptimal;
  open.optimality_gap = 0.0;
  result.graph_quality.certificate = open;
  EXPECT_FALSE(result.graph_quality.is_proven());
}

TEST(GraphQuality, CountsLoopsAndTheirError) {
  MapResult result = square(0.3);
  const GraphQuality quality = assess_square(result);
  EXPECT_EQ(quality.loops, 1);
  EXPECT_NEAR(quality.reduced_chi2, 0.3 * 0.3 / 3.0, 1e-9);
  result.graph.edges.pop_back();
  const GraphQuality open = assess_square(result);
  EXPECT_EQ(open.loops, 0);
  EXPECT_EQ(open.reduced_chi2, 0.0);
  EXPECT_FALSE(open.certificate.has_value());
  EXPECT_EQ(assess_graph({}, {}, {}).loops, 0);
}

TEST(GraphQuality, CertifiesTheSolutionAndTellsHowFarTheMapIsFromIt) {
  const GraphQuality exact = assess_square(square(0.0));
  ASSERT_TRUE(exact.certificate.has_value());
  EXPECT_TRUE(exact.certificate->certified());
  EXPECT_NEAR(exact.certified_shift_m, 0.0, 1e-6);
  // A solution in another valley: once around the other way.
  MapResult wound = square(0.0);
  for (std::size_t i = 0; i < wound.graph.poses.size(); ++i) {
    wound.graph.poses[i] = {0.3 * static_cast<double>(i), 0.0, -0.5 * kPi * static_cast<double>(i)};
  }
  const GraphQuality moved = assess_square(wound);
  ASSERT_TRUE(moved.certificate.has_value());
  EXPECT_TRUE(moved.certificate->certified());
  EXPECT_GT(moved.certified_shift_m, 0.15);
}

TEST(GraphQuality, TellsWhatTheAdjustmentMoved) {
  const MapResult solved = square(0.0);
  MapResult adjusted = square(0.0);
  adjusted.graph.poses[2].x += 0.4;
  const GraphQuality quality =
      assess_graph(solved.graph, adjusted.graph.poses, solved.loop_closures);
  EXPECT_NEAR(quality.certified_shift_m, 0.0, 1e-6) << "no fault of the graph's";
  EXPECT_GT(quality.adjusted_shift_m, 0.15);
  EXPECT_LT(quality.adjusted_shift_m, 0.45);
}

TEST(GraphQuality, AClosureThatWasInTheGraphAndIsNoMoreWasRevoked) {
  MapResult result;
  LoopClosure accepted;
  accepted.state = ClosureState::kStanding;
  accepted.chi2 = 2.0;
  LoopClosure rejected;
  LoopClosure revoked;
  revoked.state = ClosureState::kRevoked;
  revoked.chi2 = 40.0;
  result.loop_closures = {accepted, rejected, revoked, accepted};
  const GraphQuality quality = assess_square(result);
  EXPECT_EQ(quality.closures, 3);
  EXPECT_EQ(quality.closures_revoked, 1);
}

}  // namespace
}  // namespace loopstone
