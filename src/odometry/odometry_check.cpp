#include "loopstone/odometry/odometry_check.hpp"

#include <algorithm>
#include <cmath>

namespace loopstone {

namespace {

constexpr std::size_t kPieces = 10;
constexpr int kWrongToDistrust = 7;
constexpr int kWrongInARow = 5;
constexpr int kRightToTrust = 8;
constexpr double kClearlyRight = 0.5;
/// Twice the share of a motion by which wheels may be off (one standard deviation) before anything
/// is known of them.
constexpr double kShare = 0.3;
/// Heading lost by driving straight [rad/m].
constexpr double kHeadingPerMetre = 0.03;
/// A piece that takes longer is dropped: what adds up that slowly is drift, not a wrong reading.
constexpr double kLongestPieceS = 4.0;
/// A single step that is off by so many tolerances, and so many times what the robot moved, is a
/// jump.
constexpr double kJump = 3.0;
constexpr double kJumpsApartS = 2.0;
/// One side moves less than this share of the other: it stands. Squared.
constexpr double kStands2 = 0.1 * 0.1;
/// A factor explains the disagreement when no more than this share is left (root mean square).
/// Squared.
constexpr double kExplained2 = 0.25 * 0.25;
constexpr int kPiecesForScale = 20;
/// A motion is straight when it turns by less than this a metre, and long enough to have a
/// direction.
constexpr double kStraightRadPerM = 0.2;
constexpr double kStraightM = 0.01;
constexpr double kEnoughStraightM = 10.0;

}  // namespace

std::string_view to_string(OdometryFault fault) {
  switch (fault) {
    case OdometryFault::kStuck:
      return "stuck";
    case OdometryFault::kSpinning:
      return "spinning";
    case OdometryFault::kMirrored:
      return "mirrored";
    case OdometryFault::kScaled:
      return "scaled";
    case OdometryFault::kLagging:
      return "lagging";
    case OdometryFault::kWrong:
      return "wrong";
  }
  return "unknown";
}

std::string_view to_string(OdometryPart part) {
  switch (part) {
    case OdometryPart::kTranslation:
      return "translation";
    case OdometryPart::kRotation:
      return "rotation";
    case OdometryPart::kWhole:
      return "whole";
  }
  return "unknown";
}

double MotionAgreement::tolerance(double laser_length, double slack) const {
  return rest_ + kShare * laser_length + slack;
}

void MotionAgreement::add(Stamp from, Stamp to, const Eigen::Vector2d& odometry,
                          const Eigen::Vector2d& laser, double slack) {
  if (is_open_ && (to - open_.from).seconds() > kLongestPieceS) is_open_ = false;
  const double off = (odometry - laser).norm();
  if (off > kJump * std::max(tolerance(laser.norm(), slack), laser.norm())) {
    // One by itself is not the way odometry is wrong; one after the other they are.
    const bool again = last_jump_ && (to - *last_jump_).seconds() < kJumpsApartS;
    if (trusted_) ++jumps_;
    last_jump_ = to;
    is_open_ = false;
    if (!again) return;
    open_ = {from, odometry, laser};
    close(off, 0.0, true);
    return;
  }
  if (!is_open_) {
    open_ = {from};
    open_slack_ = 0.0;
    is_open_ = true;
  }
  open_.odometry += odometry;
  open_.laser += laser;
  open_slack_ += slack;
  if (std::max(open_.odometry.norm(), open_.laser.norm()) < piece_) return;
  close((open_.odometry - open_.laser).norm(), tolerance(open_.laser.norm(), open_slack_), false);
}

void MotionAgreement::close(double error, double tolerance, bool jump) {
  is_open_ = false;
  open_.wrong = error > tolerance;
  open_.right = error <= kClearlyRight * tolerance;
  open_.jump = jump;
  if (!open_.wrong) {
    right_.ol += open_.odometry.dot(open_.laser);
    right_.ll += open_.laser.squaredNorm();
    ++right_count_;
  }
  pieces_.push_back(open_);
  if (pieces_.size() > kPieces) pieces_.pop_front();
  const auto count =
      std::count_if(pieces_.begin(), pieces_.end(), [](const Piece& piece) { return piece.wrong; });
  wrong_in_a_row_ = open_.wrong ? wrong_in_a_row_ + 1 : 0;
  if (trusted_ && (count >= kWrongToDistrust || wrong_in_a_row_ >= kWrongInARow)) {
    trusted_ = false;
    // What looked like jumps was the fault.
    jumps_ -= static_cast<int>(std::count_if(pieces_.begin(), pieces_.end(),
                                             [](const Piece& piece) { return piece.jump; }));
  }
  const auto right =
      std::count_if(pieces_.begin(), pieces_.end(), [](const Piece& piece) { return piece.right; });
  if (!trusted_ && right >= kRightToTrust) trusted_ = true;
}

MotionAgreement::Moments MotionAgreement::wrong_moments() const {
  Moments sums;
  for (const Piece& piece : pieces_) {
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
  for (const Piece& piece : pieces_) {
    if (piece.wrong) return piece.from;
  }
  return {};
}

std::optional<double> MotionAgreement::scale() const {
  if (right_count_ < kPiecesForScale) return {};
  return right_.ol / right_.ll;
}

void OdometryCheck::add(const MotionPair& pair) {
  const double travelled = std::hypot(pair.laser.x, pair.laser.y);
  if (pair.sees_translation && pair.odometry_has_translation) {
    translation_.add(pair.from, pair.to, pair.odometry.translation(), pair.laser.translation(),
                     0.0);
  }
  if (pair.sees_translation && pair.sees_rotation && pair.odometry_has_translation)
    follow_straight(pair);
  if (pair.sees_rotation) {
    rotation_.add(pair.from, pair.to, {pair.odometry.yaw, 0.0}, {pair.laser.yaw, 0.0},
                  kHeadingPerMetre * travelled);
  }
  lag_.add({.from = pair.from,
            .to = pair.to,
            .odometry_m = pair.odometry.x,
            .odometry_rad = pair.odometry.yaw,
            .laser_m = pair.laser.x,
            .laser_rad = pair.laser.yaw,
            .sees_translation = pair.sees_translation && pair.odometry_has_translation,
            .sees_rotation = pair.sees_rotation});
  if (!trusts_translation() || !trusts_rotation()) distrusted_s_ += (pair.to - pair.from).seconds();
  follow(translation_, OdometryPart::kTranslation, pair.to);
  follow(rotation_, OdometryPart::kRotation, pair.to);
  follow_lag(pair.to);
}

void OdometryCheck::follow_straight(const MotionPair& pair) {
  const Eigen::Vector2d odometry = pair.odometry.translation();
  const Eigen::Vector2d laser = pair.laser.translation();
  const double length_m = odometry.norm();
  const double turn = std::max(std::abs(pair.odometry.yaw), std::abs(pair.laser.yaw));
  if (length_m < kStraightM || turn > kStraightRadPerM * length_m) return;
  straight_.length_m += length_m;
  straight_.dot += odometry.dot(laser);
  straight_.cross += odometry.x() * laser.y() - odometry.y() * laser.x();
}

std::optional<double> OdometryCheck::laser_heading_offset_rad() const {
  if (straight_.length_m < kEnoughStraightM) return {};
  return std::atan2(straight_.cross, straight_.dot);
}

OdometryEpisode* OdometryCheck::running(OdometryPart part) {
  for (auto& episode : episodes_) {
    if (episode.part == part && !episode.over) return &episode;
  }
  return nullptr;
}

void OdometryCheck::follow(const MotionAgreement& agreement, OdometryPart part, Stamp now) {
  OdometryEpisode* episode = running(part);
  // What lags disagrees now and then: that is the same fault.
  if (episode == nullptr && !agreement.trusted() && running(OdometryPart::kWhole) == nullptr) {
    episodes_.push_back({.part = part,
                         .fault = agreement.fault(),
                         .from = agreement.wrong_since(),
                         .noticed = now,
                         .ratio = agreement.ratio()});
    episode = &episodes_.back();
  }
  if (episode == nullptr) return;
  episode->to = now;
  episode->over = agreement.trusted();
}

void OdometryCheck::follow_lag(Stamp now) {
  OdometryEpisode* episode = running(OdometryPart::kWhole);
  const auto lag_s = lag_.lag_s();
  if (episode == nullptr && lag_s) {
    episodes_.push_back({.part = OdometryPart::kWhole,
                         .fault = OdometryFault::kLagging,
                         .from = now,
                         .noticed = now});
    episode = &episodes_.back();
  }
  if (episode == nullptr) return;
  if (lag_s) episode->lag_s = *lag_s;
  episode->to = now;
  episode->over = !lag_s;
}

}  // namespace loopstone
