#include "loopstone/slam/odometry_turns.hpp"

#include <cmath>
#include <cstddef>
#include <utility>

#include "loopstone/base/sound_state.hpp"
#include "loopstone/geometry/angle.hpp"
#include "slam/robust_fit.hpp"

namespace loopstone {

namespace {

constexpr auto kMostPieces = static_cast<std::size_t>(kOdometryTurns.most_pieces);

LinearProblem problem_of(const std::deque<OdometryTurns::Piece>& pieces) {
  const auto count = static_cast<Eigen::Index>(pieces.size());
  LinearProblem problem{
      Eigen::MatrixXd(count, 2), Eigen::VectorXd(count), 1, Eigen::Vector2d::Zero(),
      Eigen::Vector2d(kOdometryTurns.first_rad_per_m, kOdometryTurns.first_rad_per_turn)};
  for (Eigen::Index i = 0; i < count; ++i) {
    const OdometryTurns::Piece& piece = pieces[static_cast<std::size_t>(i)];
    problem.a.row(i) = piece.way_and_turn;
    problem.y[i] = piece.missed_rad;
  }
  return problem;
}

}  // namespace

void OdometryTurns::add(const Eigen::Vector2d& way_and_turn, double seen_rad) {
  state_.open.way_and_turn += way_and_turn;
  state_.open.missed_rad += wrap_angle(seen_rad - way_and_turn.y());
  if (std::abs(state_.open.way_and_turn.x()) < kOdometryTurns.piece_m &&
      std::abs(state_.open.way_and_turn.y()) < kOdometryTurns.piece_rad)
    return;
  state_.pieces.push_back(state_.open);
  if (state_.pieces.size() > kMostPieces) state_.pieces.pop_front();
  state_.open = {};
  fit();
}

void OdometryTurns::fit() {
  if (state_.pieces.size() < static_cast<std::size_t>(kOdometryTurns.fewest_pieces)) return;
  const LinearFit fit = robust_fit(problem_of(state_.pieces));
  missed_ = fit.x;
  covariance_ = fit.covariance;
  const auto is_off = [&](Eigen::Index i, double least) {
    return std::abs(missed_[i]) >
           std::max(least, kOdometryTurns.sigmas * std::sqrt(covariance_(i, i)));
  };
  is_certain_ =
      is_off(0, kOdometryTurns.least_rad_per_m) || is_off(1, kOdometryTurns.least_rad_per_turn);
}

Eigen::Vector2d OdometryTurns::missed() const {
  return is_certain_ ? missed_ : Eigen::Vector2d::Zero().eval();
}

double OdometryTurns::sigma_rad(const Eigen::Vector2d& way_and_turn) const {
  const double left_rad = (missed_ - missed()).dot(way_and_turn);
  return std::sqrt(way_and_turn.dot(covariance_ * way_and_turn) + left_rad * left_rad);
}

void OdometryTurns::restore(State state) {
  require_sound(state.pieces.size() <= kMostPieces, "more pieces of turns than are remembered");
  require_sound(state.open.way_and_turn.allFinite() && std::isfinite(state.open.missed_rad),
                "a turn that is no number");
  for (const Piece& piece : state.pieces)
    require_sound(piece.way_and_turn.allFinite() && std::isfinite(piece.missed_rad),
                  "a turn that is no number");
  *this = {};
  state_ = std::move(state);
  fit();
}

}  // namespace loopstone
