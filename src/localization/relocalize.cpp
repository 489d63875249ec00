#include "loopstone/localization/relocalize.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "localization/confidence.hpp"
#include "localization/place_search.hpp"
#include "localization/pose_evidence.hpp"
#include "localization/scan_weigher.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/geometry/pose_distance.hpp"

namespace loopstone {

namespace {

/// A scan as it is held against the map.
struct View {
  LocalizationScan scan;
  Pose2 robot_T_then;
};

bool is_finite(const TakenScan& taken) {
  return taken.robot_T_lidar.vector().allFinite() && taken.robot_T_then.vector().allFinite() &&
         taken.velocity.allFinite();
}

/// Those that have returns enough and tell something that those before did not: the one to search
/// with first.
std::vector<View> views_of(std::span<const TakenScan> scans) {
  std::vector<View> views;
  std::size_t most = 0;
  for (const TakenScan& taken : scans) {
    if (!is_finite(taken))
      throw UsageError("a laser's mount, a robot's motion or its velocity is not finite");
    View view{
        view_for_localization(taken.scan, taken.robot_T_lidar, taken.velocity, kRelocalize.beams),
        taken.robot_T_then};
    most = std::max(most, view.scan.points_robot.size());
    const Pose2 from = taken.robot_T_then * taken.robot_T_lidar;
    const bool is_news = std::ranges::none_of(views, [&](const View& known) {
      return is_within(known.robot_T_then * known.scan.robot_T_lidar(), from, kRelocalize.news_m,
                       kRelocalize.news_rad);
    });
    if (is_news && view.scan.points_robot.size() >= kLeastReturns) views.push_back(std::move(view));
  }
  if (views.empty()) {
    throw UsageError(
        fmt::format("the scan has {} returns within its range; fewer than {} don't tell a place",
                    most, kLeastReturns));
  }
  const auto richest = std::ranges::max_element(
      views, {}, [](const View& view) { return view.scan.points_robot.size(); });
  std::rotate(views.begin(), richest, richest + 1);
  return views;
}

/// A place, and what the views say of it.
struct Place {
  PlaceCandidate candidate;
  double log_mass = 0.0;  ///< against the other places
};

BeamFit mean_of(std::span<const BeamFit> fits) {
  BeamFit mean;
  for (double BeamFit::*field : {&BeamFit::explained, &BeamFit::violations, &BeamFit::unexpected,
                                 &BeamFit::known, &BeamFit::silent}) {
    for (const BeamFit& fit : fits) mean.*field += fit.*field / static_cast<double>(fits.size());
  }
  return mean;
}

void judge_by(std::span<const View> views, const LocalizationMap& map, const ScanWeigher& weigher,
              Place& place) {
  std::vector<BeamFit> fits;
  for (const View& view : views) {
    const Pose2 map_T_then = place.candidate.map_T_robot * view.robot_T_then;
    fits.push_back(fit_beams(view.scan, map, map_T_then));
    place.log_mass += weigher.best_evidence(view.scan, std::span(&map_T_then, 1));
  }
  place.candidate.fit = mean_of(fits);
}

/// What a localizer would know of the pose at its first scan.
PoseEvidence evidence_of(const PlaceCandidate& candidate) {
  const BeamFit& fit = candidate.fit;
  const FitOverWay way{fit.explained, fit.violations, fit.unexpected, fit.known, fit.silent};
  const Eigen::Matrix3d& covariance = candidate.covariance;
  return {.explained = fit.explained,
          .violations = fit.violations,
          .unexpected = fit.unexpected,
          .mass = 1.0,
          .precision = 1.0,
          .spread_m = std::sqrt(covariance(0, 0) + covariance(1, 1)),
          .spread_rad = std::sqrt(covariance(2, 2)),
          .innovation = kRelocalize.first_innovation,
          .known = fit.known,
          .silent = fit.silent,
          .lately = way,
          .along = way};
}

/// Belief in the places: by how well they explain the scans, and by how probably scans fit so from
/// a right pose. The last one alone must not decide between places that fit: it is near 1 for all
/// of them.
/// \param rest  belief in places that were not looked into
void share_belief(std::span<Place> places, double rest, Relocalization& result) {
  std::vector<double> fits;
  std::vector<double> shares;
  for (const Place& place : places) {
    fits.push_back(pose_probability(evidence_of(place.candidate)));
    shares.push_back(fits.back() * std::exp(place.log_mass - places.front().log_mass));
  }
  const double sum = std::accumulate(shares.begin(), shares.end(), 0.0);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double here = sum > 0.0 ? (1.0 - rest) * shares[i] / sum * fits[i] : 0.0;
    PlaceCandidate& candidate = places[i].candidate;
    candidate.probability = here * precision_of(candidate.covariance);
    result.none_probability -= here;
    result.candidates.push_back(candidate);
  }
  result.none_probability = std::max(result.none_probability, 0.0);
  std::ranges::stable_sort(result.candidates, std::ranges::greater{}, &PlaceCandidate::probability);
}

}  // namespace

Relocalization relocalize(const LocalizationMap& map, std::span<const TakenScan> scans,
                          Threads threads) {
  const std::vector<View> views = views_of(scans);
  const PlacesFound found = find_places(views.front().scan, map, kRelocalize.search_points);
  const Pose2 then_T_robot = views.front().robot_T_then.inverse();
  std::vector<Place> places;
  for (std::size_t i = 0; i < found.proposals.size(); ++i) {
    Place place{.log_mass = found.proposals[i].log_mass};
    const PoseWithCovariance2 matched = compound(found.matched[i], {then_T_robot});
    place.candidate.map_T_robot = matched.pose;
    place.candidate.covariance = matched.covariance;
    places.push_back(place);
  }
  const ScanWeigher weigher(map, ScanModel::kLikelihoodField, {1});
  parallel_for(places.size(), threads,
               [&](std::size_t i) { judge_by(views, map, weigher, places[i]); });
  Relocalization result{.complete = found.complete};
  share_belief(places, found.complete ? 0.0 : kRestShare, result);
  return result;
}

Relocalization relocalize(const LocalizationMap& map, const LaserScan& scan,
                          const Pose2& robot_T_lidar, Threads threads) {
  const TakenScan taken{.scan = scan, .robot_T_lidar = robot_T_lidar};
  return relocalize(map, std::span(&taken, 1), threads);
}

}  // namespace loopstone
