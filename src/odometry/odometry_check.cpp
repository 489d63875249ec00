#include "loopstone/odometry/odometry_check.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/base/sound_state.hpp"

namespace loopstone {

namespace {

constexpr auto kMostPieces = static_cast<std::size_t>(kOdometryCheck.pieces);
constexpr double kStands2 = kOdometryCheck.stands * kOdometryCheck.stands;
constexpr double kExplained2 = kOdometryCheck.explained * kOdometryCheck.explained;

}  // namespace

double MotionAgreement::tolerance(double laser_length, double slack) const {
  return rest_ + kOdometryCheck.share * laser_length + slack;
}

void MotionAgreement::add(Stamp from, Stamp to, const Eigen::Vector2d& odometry,
                          const Eigen::Vector2d& laser, double slack) {
  if (state_.is_open && (to - state_.open.from).seconds() > kOdometryCheck.longest_piece_s)
    state_.is_open = false;
  const double off = (odometry - laser).norm();
  if (off > kOdometryCheck.jump * std::max(tolerance(laser.norm(), slack), laser.norm())) {
    // One by itself is not the way odometry is wrong; one after the other they are.
    const bool again =
        state_.last_jump && (to - *state_.last_jump).seconds() < kOdometryCheck.jumps_apart_s;
    if (state_.trusted) ++state_.jumps;
    state_.last_jump = to;
    state_.is_open = false;
    if (!again) return;
    state_.open = {from, odometry, laser};
    close(off, 0.0, true);
    return;
  }
  if (!state_.is_open) {
    state_.open = {from};
    state_.open_slack = 0.0;
    state_.is_open = true;
  }
  state_.open.odometry += odometry;
  state_.open.laser += laser;
  state_.open_slack += slack;
  if (std::max(state_.open.odometry.norm(), state_.open.laser.norm()) < piece_) return;
  close((state_.open.odometry - state_.open.laser).norm(),
        tolerance(state_.open.laser.norm(), state_.open_slack), false);
}

void MotionAgreement::close(double error, double tolerance, bool jump) {
  state_.is_open = false;
  state_.open.wrong = error > tolerance;
  state_.open.right = error <= kOdometryCheck.clearly_right * tolerance;
  state_.open.jump = jump;
  if (!state_.open.wrong) {
    state_.right.ol += state_.open.odometry.dot(state_.open.laser);
    state_.right.ll += state_.open.laser.squaredNorm();
    ++state_.right_count;
  }
  state_.pieces.push_back(state_.open);
  if (state_.pieces.size() > kMostPieces) state_.pieces.pop_front();
  const auto count = std::count_if(state_.pieces.begin(), state_.pieces.end(),
                                   [](const Piece& piece) { return piece.wrong; });
  state_.wrong_in_a_row = state_.open.wrong ? state_.wrong_in_a_row + 1 : 0;
  if (state_.trusted && (count >= kOdometryCheck.wrong_to_distrust ||
                         state_.wrong_in_a_row >= kOdometryCheck.wrong_in_a_row)) {
    state_.trusted = false;
    // What looked like jumps was the fault.
    state_.jumps -= static_cast<int>(std::count_if(state_.pieces.begin(), state_.pieces.end(),
                                                   [](const Piece& piece) { return piece.jump; }));
  }
  const auto right = std::count_if(state_.pieces.begin(), state_.pieces.end(),
                                   [](const Piece& piece) { return piece.right; });
  if (!state_.trusted && right >= kOdometryCheck.right_to_trust) state_.trusted = true;
}

MotionAgreement::Moments MotionAgreement::wrong_moments() const {
  Moments sums;
  for (const Piece& piece : state_.pieces) {
    if (!piece.wrong) continue;
    sums.oo += piece.odometry.squaredNorm();
    sums.ol += piece.odometry.dot(piece.laser);
    sums.ll += piece.laser.squaredNorm();
  }
  return sums;
}

OdometryFault MotionAgreement::fault() const {
  const Moments sums = wrong_moments();
  if (sums.oo < kStands2 * sums.ll) return OdometryFault::kStuck;
  if (sums.ll < kStands2 * sums.oo) return OdometryFault::kSpinning;
  const double unexplained = sums.oo - sums.ol * sums.ol / sums.ll;
  if (unexplained > kExplained2 * sums.oo) return OdometryFault::kWrong;
  return sums.ol < 0.0 ? OdometryFault::kMirrored : OdometryFault::kScaled;
}

double MotionAgreement::ratio() const {
  const Moments sums = wrong_moments();
  return sums.ll > 0.0 ? sums.ol / sums.ll : 0.0;
}

Stamp MotionAgreement::wrong_since() const {
  for (const Piece& piece : state_.pieces) {
    if (piece.wrong) return piece.from;
  }
  return {};
}

void MotionAgreement::assume_scale(double scale) {
  const double ll = kOdometryCheck.pieces_assumed * piece_ * piece_;
  state_.right = {scale * scale * ll, scale * ll, ll};
  state_.right_count = kOdometryCheck.pieces_assumed;
}

std::optional<double> MotionAgreement::scale() const {
  if (state_.right_count < kOdometryCheck.pieces_for_scale) return {};
  return state_.right.ol / state_.right.ll;
}

void MotionAgreement::restore(State state) {
  require_sound(state.pieces.size() <= kMostPieces, "more pieces of motion than are remembered");
  // Jumps that turn out to be the fault are taken back, now and then one too many.
  require_sound(is_count(state.wrong_in_a_row) && is_count(state.right_count) &&
                    is_count(std::max(state.jumps, ~state.jumps)),
                "pieces of motion that nobody can have counted");
  state_ = std::move(state);
}

void OdometryCheck::add(const MotionPair& pair) {
  const double travelled = hypotenuse(pair.laser.x, pair.laser.y);
  if (pair.sees_translation && pair.odometry_has_translation) {
    translation_.add(pair.from, pair.to, pair.odometry.translation(), pair.laser.translation(),
                     0.0);
  }
  if (pair.sees_translation && pair.sees_rotation && pair.odometry_has_translation)
    follow_straight(pair);
  if (pair.sees_rotation) {
    rotation_.add(pair.from, pair.to, {pair.odometry.yaw, 0.0}, {pair.laser.yaw, 0.0},
                  kOdometryCheck.heading_rad_per_m * travelled);
  }
  lag_.add({.from = pair.from,
            .to = pair.to,
            .odometry_m = pair.odometry.x,
            .odometry_rad = pair.odometry.yaw,
            .laser_m = pair.laser.x,
            .laser_rad = pair.laser.yaw,
            .sees_translation = pair.sees_translation && pair.odometry_has_translation,
            .sees_rotation = pair.sees_rotation});
  if (!trusts_translation() || !trusts_rotation())
    own_.distrusted_s += (pair.to - pair.from).seconds();
  follow(translation_, OdometryPart::kTranslation, pair.to);
  follow(rotation_, OdometryPart::kRotation, pair.to);
  follow_lag(pair.to);
}

void OdometryCheck::follow_straight(const MotionPair& pair) {
  const Eigen::Vector2d odometry = pair.odometry.translation();
  const Eigen::Vector2d laser = pair.laser.translation();
  const double length_m = odometry.norm();
  const double turn = std::max(std::abs(pair.odometry.yaw), std::abs(pair.laser.yaw));
  if (length_m < kOdometryCheck.straight_m || turn > kOdometryCheck.straight_rad_per_m * length_m)
    return;
  own_.straight.length_m += length_m;
  own_.straight.dot += odometry.dot(laser);
  own_.straight.cross += odometry.x() * laser.y() - odometry.y() * laser.x();
}

std::optional<double> OdometryCheck::laser_heading_offset_rad() const {
  if (own_.straight.length_m < kOdometryCheck.enough_straight_m) return {};
  return std::atan2(own_.straight.cross, own_.straight.dot);
}

OdometryEpisode* OdometryCheck::running(OdometryPart part) {
  for (auto& episode : own_.episodes) {
    if (episode.part == part && !episode.over) return &episode;
  }
  return nullptr;
}

void OdometryCheck::follow(const MotionAgreement& agreement, OdometryPart part, Stamp now) {
  OdometryEpisode* episode = running(part);
  // What lags disagrees now and then: that is the same fault.
  if (episode == nullptr && !agreement.trusted() && running(OdometryPart::kWhole) == nullptr) {
    own_.episodes.push_back({.part = part,
                             .fault = agreement.fault(),
                             .from = agreement.wrong_since(),
                             .noticed = now,
                             .ratio = agreement.ratio()});
    episode = &own_.episodes.back();
  }
  if (episode == nullptr) return;
  episode->to = now;
  episode->over = agreement.trusted();
}

void OdometryCheck::follow_lag(Stamp now) {
  OdometryEpisode* episode = running(OdometryPart::kWhole);
  const auto lag_s = lag_.lag_s();
  if (episode == nullptr && lag_s) {
    own_.episodes.push_back({.part = OdometryPart::kWhole,
                             .fault = OdometryFault::kLagging,
                             .from = now,
                             .noticed = now});
    episode = &own_.episodes.back();
  }
  if (episode == nullptr) return;
  if (lag_s) episode->lag_s = *lag_s;
  episode->to = now;
  episode->over = !lag_s;
}

OdometryCheck::State OdometryCheck::state() const {
  return {translation_.state(), rotation_.state(), lag_.state(), own_};
}

void OdometryCheck::restore(State state) {
  require_sound(std::isfinite(state.own.distrusted_s), "a time that is no number");
  translation_.restore(std::move(state.translation));
  rotation_.restore(std::move(state.rotation));
  lag_.restore(std::move(state.lag));
  own_ = std::move(state.own);
}

}  // namespace loopstone
