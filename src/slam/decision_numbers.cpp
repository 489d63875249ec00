#include "loopstone/slam/decision_numbers.hpp"

#include <string_view>

#include "loopstone/mapping/map_quality.hpp"
#include "loopstone/odometry/differential_drive.hpp"
#include "loopstone/odometry/gyro_bias.hpp"
#include "loopstone/odometry/gyro_heading.hpp"
#include "loopstone/odometry/odometer.hpp"
#include "loopstone/odometry/odometry_accuracy.hpp"
#include "loopstone/odometry/odometry_check.hpp"
#include "loopstone/odometry/odometry_lag.hpp"
#include "loopstone/odometry/scan_queue.hpp"
#include "loopstone/slam/back_end.hpp"
#include "loopstone/slam/calibration.hpp"
#include "loopstone/slam/key_chain.hpp"
#include "loopstone/slam/laser_check.hpp"
#include "loopstone/slam/loop_closer.hpp"
#include "loopstone/slam/mapper.hpp"
#include "loopstone/slam/motion_predictor.hpp"
#include "loopstone/slam/odom_frame.hpp"
#include "loopstone/slam/odometry_turns.hpp"
#include "loopstone/slam/travelling_things.hpp"
#include "mapping/judged_scans.hpp"
#include "mapping/map_entropy.hpp"
#include "mapping/visit_agreement.hpp"
#include "mapping/visit_contradictions.hpp"
#include "mapping/wall_pieces.hpp"
#include "slam/front_end_numbers.hpp"
#include "slam/graph_quality_numbers.hpp"
#include "slam/loop_candidates.hpp"
#include "slam/loop_surroundings.hpp"
#include "slam/loop_verification.hpp"
#include "slam/loose_parts_numbers.hpp"
#include "slam/map_verdict_numbers.hpp"
#include "slam/pairwise_consistency.hpp"
#include "slam/path_drift.hpp"
#include "slam/pose_search.hpp"
#include "slam/rival_places.hpp"
#include "slam/scan_edges.hpp"
#include "slam/sensor_faults.hpp"
#include "slam/surface_adjustment_numbers.hpp"
#include "slam/sweep_fit.hpp"

namespace loopstone {

namespace {

template <typename Numbers>
NumberGroup group(std::string_view name, const Numbers& numbers) {
  return number_group(name, numbers);
}

}  // namespace

std::vector<NumberGroup> decision_numbers() {
  return {
      group("mapper", kMapper),
      group("differential_drive", kDifferentialDrive),
      group("gyro_bias", kGyroBias),
      group("gyro_heading", kGyroHeading),
      group("odometer", kOdometer),
      group("scan_queue", kScanQueue),
      group("odometry_check", kOdometryCheck),
      group("odometry_lag", kOdometryLag),
      group("odometry_accuracy", kOdometryAccuracy),
      group("laser_check", kLaserCheck),
      group("travelling", kTravelling),
      group("odometry_turns", kOdometryTurns),
      group("motion_predictor", kMotionPredictor),
      group("front_end", kFrontEnd),
      group("front_end_rejoin", kFrontEndRejoin),
      group("pose_search", kPoseSearch),
      group("odom_frame", kOdomFrame),
      group("scan_edges", kScanEdges),
      group("key_chain", kKeyChain),
      group("path_drift", kPathDrift),
      group("loop_candidates", kLoopCandidates),
      group("loop_closer", kLoopCloser),
      group("loop_verification", kLoopVerification),
      group("loop_surroundings", kLoopSurroundings),
      group("rival_places", kRivalPlaces),
      group("pairwise_consistency", kPairwiseConsistency),
      group("back_end", kBackEnd),
      group("surface_adjustment", kSurfaceAdjustment),
      group("calibration", kCalibration),
      group("sweep", kSweep),
      group("judged_scans", kJudgedScans),
      group("wall_pieces", kWallPieces),
      group("visit_agreement", kVisitAgreement),
      group("visit_contradictions", kVisitContradictions),
      group("map_entropy", kMapEntropy),
      group("map_quality", kMapQuality),
      group("graph_quality", kGraphQuality),
      group("loose_parts", kLooseParts),
      group("sensor_faults", kSensorFaults),
      group("map_verdict", kMapVerdict),
  };
}

}  // namespace loopstone
