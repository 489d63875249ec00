#include "localization/scan_weigher.hpp"

#include <algorithm>
#include <vector>

#include "localization/map_tables.hpp"
#include "loopstone/base/thinned.hpp"
#include "loopstone/registration/field_match.hpp"

namespace loopstone {

namespace {

/// Beams of one scan are not independent: furniture and the map's errors touch many at once. So
/// many count as one.
constexpr double kBeamsAsOne = 6.0;
/// Between places the same errors of the map come back with every scan, so far fewer readings are
/// independent: in corridors that look alike, on a map drawn years before, 40 made the wrong one
/// certain within eight metres, and 90 did not.
constexpr double kBeamsAsOneOfPlace = 90.0;

}  // namespace

ScanWeigher::ScanWeigher(const LocalizationMap& map, ScanModel model, Threads threads)
    : map_(map), model_(model), threads_(threads), beam_sensor_(map.tables().caster) {}

void ScanWeigher::log_likelihoods(const LocalizationScan& scan, std::span<const Pose2> map_T_robot,
                                  std::span<double> out) {
  const LikelihoodFieldModel& field = map_.tables().weigher;
  switch (model_) {
    case ScanModel::kBeam:
      beam_sensor_.log_likelihoods(scan, map_T_robot, out, threads_);
      break;
    case ScanModel::kBeamSkipping:
      (void)field.log_likelihoods_skipping(map_T_robot, scan.weighed, out, {}, threads_);
      break;
    case ScanModel::kLikelihoodField:
      field.log_likelihoods(map_T_robot, scan.weighed, out, threads_);
      break;
  }
  for (double& value : out) value /= kBeamsAsOne;
}

double ScanWeigher::independent_readings(const LocalizationScan& scan) {
  return static_cast<double>(scan.weighed.size()) / kBeamsAsOne;
}

double ScanWeigher::best_evidence(const LocalizationScan& scan,
                                  std::span<const Pose2> map_T_robot) const {
  std::vector<double> values(map_T_robot.size());
  map_.tables().judge.log_likelihoods(map_T_robot, scan.weighed, values, threads_);
  return *std::max_element(values.begin(), values.end()) / kBeamsAsOneOfPlace;
}

double ScanWeigher::evidence_of(const LocalizationScan& scan, const PlaceBelief& place) const {
  constexpr std::size_t kParticles = 200;
  constexpr std::size_t kPoints = 120;
  std::vector<Pose2> poses = thinned(place.particles.states(), kParticles);
  poses.push_back(place.moments.pose);
  const MatchResult match = match_to_field(thinned(scan.points_robot, kPoints),
                                           map_.tables().search.field(), place.moments.pose, {}, 1);
  if (has_supported_pose(match.status)) poses.push_back(match.target_T_source);
  return best_evidence(scan, poses);
}

void ScanWeigher::learn_from(const LocalizationScan& scan, const Pose2& map_T_robot) {
  if (model_ == ScanModel::kBeam) beam_sensor_.learn_from(scan, map_T_robot);
}

}  // namespace loopstone
