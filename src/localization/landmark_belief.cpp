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
/// What a place did not explain, when it is seen again: it might have been by then.
constexpr double kStaysUnexplained = 0.5;
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

double LandmarkBelief::log_unexplained(const LandmarkAssociation& landmarks,
                                       std::span<const BlindExpectation> expected) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (landmarks[i]) continue;
    sum += expected[i].log_density +
           std::log(expected[i].is_seen_before ? kStaysUnexplained : clutter_.share);
  }
  return sum;
}

void LandmarkBelief::update(std::span<const LandmarkObservation> observations) {
  update(observations, std::vector<BlindExpectation>(observations.size(),
                                                     {.log_density = clutter_.log_anywhere()}));
}

void LandmarkBelief::update(std::span<const LandmarkObservation> observations,
                            std::span<const BlindExpectation> expected) {
  if (observations.empty()) return;
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
                   log_unexplained(joint.landmarks, expected));
  }
  double of_rest = std::log(std::max(rest_, kCarriedOff));
  for (const BlindExpectation& expectation : expected) of_rest += expectation.log_density;
  logs.push_back(of_rest);
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
    const double log_weight = std::log(rest) + match.log_gain;
    const auto known = std::ranges::find_if(places_, [&](const LandmarkPlace& place) {
      return is_within(place.map_T_robot.pose, match.map_T_robot.pose, kSameM, kSameRad);
    });
    // Or others would be favoured, which do not answer for what the known one failed to explain.
    if (known != places_.end()) {
      double& log_known = logs[static_cast<std::size_t>(known - places_.begin())];
      if (log_weight > log_known) {
        log_known = log_weight;
        known->map_T_robot = match.map_T_robot;
      }
      continue;
    }
    places_.push_back(
        {.map_T_robot = match.map_T_robot, .id = next_id_++, .explained = match.explained});
    logs.push_back(log_weight);
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
