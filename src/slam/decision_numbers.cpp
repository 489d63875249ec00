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
#include "loopstone/slam/lift_watch.hpp"
#include "loopstone/slam/loop_closer.hpp"
#include "loopstone/slam/mapper.hpp"
#include "loopstone/slam/motion_predictor.hpp"
#include "loopstone/slam/odom_frame.hpp"
#include "loopstone/slam/odometry_turns.hpp"
#include "loopstone/slam/travelling_things.hpp"
#include "loopstone/slam/untold_reach.hpp"
#include "mapping/judged_scans.hpp"
#include "mapping/map_entropy.hpp"
#include "mapping/visit_agreement.hpp"
#include "mapping/visit_contradictions.hpp"
#include "mapping/wall_pieces.hpp"
#include "slam/drive_ties.hpp"
#include "slam/front_end_numbers.hpp"
#include "slam/graph_quality_numbers.hpp"
#include "slam/loop_candidates.hpp"
#include "slam/loop_surroundings.hpp"
#include "slam/loop_verification.hpp"
#include "slam/loose_parts_numbers.hpp"
#include "slam/map_verdict_numbers.hpp"
#include "slam/pairwise_consistency.hpp"
#include "slam/path_drift.hpp"
#include "slam/placement.hpp"
#include "slam/pose_search.hpp"
#include "slam/rival_places.hpp"
#include "slam/scan_edges.hpp"
#include "slam/sensor_faults.hpp"
#include "slam/surface_adjustment_numbers.hpp"
#include "slam/sweep_fit.hpp"
#include "slam/turning_beams.hpp"

namespace loopstone {

std::vector<NumberGroup> decision_numbers() {
  return {
      number_group("mapper", kMapper),
      number_group("differential_drive", kDifferentialDrive),
      number_group("gyro_bias", kGyroBias),
      number_group("gyro_heading", kGyroHeading),
      number_group("odometer", kOdometer),
      number_group("scan_queue", kScanQueue),
      number_group("odometry_check", kOdometryCheck),
      number_group("odometry_lag", kOdometryLag),
      number_group("odometry_accuracy", kOdometryAccuracy),
      number_group("laser_check", kLaserCheck),
      number_group("travelling", kTravelling),
      number_group("odometry_turns", kOdometryTurns),
      number_group("lift_watch", kLiftWatch),
      number_group("motion_predictor", kMotionPredictor),
      number_group("front_end", kFrontEnd),
      number_group("front_end_rejoin", kFrontEndRejoin),
      number_group("untold_reach", kUntoldReach),
      number_group("turning_beams", kTurningBeams),
      number_group("pose_search", kPoseSearch),
      number_group("odom_frame", kOdomFrame),
      number_group("scan_edges", kScanEdges),
      number_group("key_chain", kKeyChain),
      number_group("path_drift", kPathDrift),
      number_group("loop_candidates", kLoopCandidates),
      number_group("loop_closer", kLoopCloser),
      number_group("loop_verification", kLoopVerification),
      number_group("loop_surroundings", kLoopSurroundings),
      number_group("drive_ties", kDriveTies),
      number_group("placement", kPlacement),
      number_group("rival_places", kRivalPlaces),
      number_group("pairwise_consistency", kPairwiseConsistency),
      number_group("back_end", kBackEnd),
      number_group("surface_adjustment", kSurfaceAdjustment),
      number_group("calibration", kCalibration),
      number_group("sweep", kSweep),
      number_group("judged_scans", kJudgedScans),
      number_group("wall_pieces", kWallPieces),
      number_group("visit_agreement", kVisitAgreement),
      number_group("visit_contradictions", kVisitContradictions),
      number_group("map_entropy", kMapEntropy),
      number_group("map_quality", kMapQuality),
      number_group("graph_quality", kGraphQuality),
      number_group("loose_parts", kLooseParts),
      number_group("sensor_faults", kSensorFaults),
      number_group("map_verdict", kMapVerdict),
  };
}

}  // namespace loopstone
