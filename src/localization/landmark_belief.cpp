#include "loopstone/localization/landmark_belief.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "loopstone/geometry/pose_distance.hpp"

namespace loopstone {
namespace {

/// So probable it is, before a reading, that the robot was carried off since the last one: about
/// once in a day of readings ten times a second.
constexpr double kCarriedOff = 1e-6;
/// A pose given by hand is wrong now and then.
constexpr double kGivenIsWrong = 0.05;
/// Places of less weight are forgotten.
constexpr double kForgotten = 1e-9;
constexpr std::size_t kMostPlaces = 40;
/// Places so near to one another are one.
constexpr double kSameM = 0.1;
constexpr double kSameRad = 0.05;

/// exp of logs that may all be far below what a double holds, so that they add up to 1.
void normalise(std::vector<double>& logs) {
  const double most = *std::ranges::max_element(logs);
  double sum = 0.0;
  for (double& value : logs) sum += value = std::exp(value - most);
  for (double& value : logs) value /= sum;
}

}  // namespace

void LandmarkBelief::start_at(const PoseWithCovariance2& map_T_robot) {
  places_ = {{.map_T_robot = map_T_robot, .weight = 1.0 - kGivenIsWrong, .id = next_id_++}};
  rest_ = kGivenIsWrong;
}

void LandmarkBelief::predict(const PoseWithCovariance2& motion) {
  for (LandmarkPlace& place : places_) place.map_T_robot = compound(place.map_T_robot, motion);
}

void LandmarkBelief::update(std::span<const LandmarkObservation> observations) {
  if (observations.empty()) return;
  const auto seen = static_cast<double>(observations.size());
  std::vector<double> logs;
  for (LandmarkPlace& place : places_) {
    const JointAssociation joint =
        associate_jointly(place.map_T_robot, map_, observations, clutter_);
    const LandmarkPosterior posterior =
        update_by_landmarks(place.map_T_robot, map_, observations, joint.landmarks);
    place.map_T_robot = posterior.map_T_robot;
    place.explained = posterior.observations;
    place.chi2 = posterior.chi2;
    logs.push_back(std::log(place.weight) + posterior.log_evidence +
                   posterior.observations * clutter_.log_landmark() +
                   (seen - posterior.observations) * clutter_.log_clutter());
  }
  logs.push_back(std::log(std::max(rest_, kCarriedOff)) + seen * clutter_.log_anywhere());
  normalise(logs);
  for (std::size_t i = 0; i < places_.size(); ++i) places_[i].weight = logs[i];
  rest_ = logs.back();
  settle();
}

int LandmarkBelief::add(std::span<const ConstellationMatch> matches) {
  const double rest = std::max(rest_, kCarriedOff);
  int added = 0;
  std::vector<double> logs;
  for (const LandmarkPlace& place : places_) logs.push_back(std::log(place.weight));
  for (const ConstellationMatch& match : matches) {
    const bool is_known = std::ranges::any_of(places_, [&](const LandmarkPlace& place) {
      return is_within(place.map_T_robot.pose, match.map_T_robot.pose, kSameM, kSameRad);
    });
    if (is_known) continue;
    places_.push_back(
        {.map_T_robot = match.map_T_robot, .id = next_id_++, .explained = match.explained});
    logs.push_back(std::log(rest) + match.log_gain);
    ++added;
  }
  logs.push_back(std::log(rest));
  normalise(logs);
  for (std::size_t i = 0; i < places_.size(); ++i) places_[i].weight = logs[i];
  rest_ = logs.back();
  settle();
  return added;
}

/// Joins places that have become one, forgets those of no account, puts them in order.
void LandmarkBelief::settle() {
  std::ranges::stable_sort(places_, std::greater{}, &LandmarkPlace::weight);
  std::vector<LandmarkPlace> kept;
  for (const LandmarkPlace& place : places_) {
    const auto same = std::ranges::find_if(kept, [&](const LandmarkPlace& other) {
      return is_within(place.map_T_robot.pose, other.map_T_robot.pose, kSameM, kSameRad);
    });
    if (same != kept.end()) {
      same->weight += place.weight;
    } else if (kept.empty() || (place.weight >= kForgotten && kept.size() < kMostPlaces)) {
      kept.push_back(place);
    }
  }
  places_ = std::move(kept);
  double sum = rest_;
  for (const LandmarkPlace& place : places_) sum += place.weight;
  for (LandmarkPlace& place : places_) place.weight = std::max(place.weight / sum, 1e-300);
  rest_ /= sum;
}

double LandmarkBelief::mass_near(const Pose2& map_T_robot, double metres, double radians) const {
  double mass = 0.0;
  for (const LandmarkPlace& place : places_) {
    if (is_within(place.map_T_robot.pose, map_T_robot, metres, radians)) mass += place.weight;
  }
  return mass;
}

}  // namespace loopstone
