#pragma once

#include <Eigen/Core>
#include <deque>

#include "loopstone/odometry/odometry_accuracy.hpp"

namespace loopstone {

/// What the turns that odometry always misses are learned by.
struct OdometryTurnsNumbers {
  double piece_m = 0.5;
  double piece_rad = 0.5;
  int most_pieces = 320;
  int fewest_pieces = 20;
  double sigmas = 4.0;
  double least_rad_per_m = 0.001;
  double least_rad_per_turn = 0.005;
  double first_rad_per_m = kOdometryAccuracy.first_rad_per_m;
  double first_rad_per_turn = 0.1;
};
inline constexpr OdometryTurnsNumbers kOdometryTurns{};

template <typename Visitor>
void visit_numbers(const OdometryTurnsNumbers& n, Visitor&& visit) {
  visit("piece_m", n.piece_m,
        "chosen: long beside the laser's noise, short beside the way from one slip to the next: "
        "most pieces are without one");
  visit("piece_rad", n.piece_rad, "chosen: likewise; a stamp that is late turns a piece less");
  visit("most_pieces", n.most_pieces, "chosen: as the accuracy of odometry: floors change");
  visit("fewest_pieces", n.fewest_pieces, "chosen: fewer do not tell what is usual among them");
  visit("sigmas", n.sigmas, "chosen: less may be chance, also of neighbours that err alike");
  visit("least_rad_per_m", n.least_rad_per_m,
        "chosen: less is not corrected: a quarter of what the best wheels are granted");
  visit("least_rad_per_turn", n.least_rad_per_turn,
        "chosen: less is not corrected: two degrees a turn");
  visit("first_rad_per_m", n.first_rad_per_m,
        "derived: standard deviation of wheels of which nothing is known: first_rad_per_m of the "
        "accuracy of odometry");
  visit("first_rad_per_turn", n.first_rad_per_turn,
        "chosen: likewise: a track that is told wrong by a tenth");
}

/// The turns that odometry always misses: wheels of unequal size miss some each metre, a wrong
/// track or a gyro's scale some each radian.
///
///   turn (laser) - turn (odometry) = rad_per_m way + rad_per_turn turn (odometry) + noise
///
/// by robust least squares over pieces of the drive of half a metre or half a radian, the last 320
/// of them: slips are outliers. At an even speed a gyro's bias looks like turns missed each metre.
/// Cost: some ten microseconds a piece. Deterministic.
/// Source: Borenstein and Feng 1996, "Measurement and correction of systematic odometry errors in
/// mobile robots".
class OdometryTurns {
 public:
  /// A motion of which the laser held both ends.
  /// \param way_and_turn  of odometry, see way_and_turn()
  /// \param seen_rad      turn that the laser saw
  void add(const Eigen::Vector2d& way_and_turn, double seen_rad);
  /// The laser lost the robot, or odometry was silent: the piece that is open says nothing.
  void interrupt() { state_.open = {}; }

  /// What a motion turns more than odometry says, a metre and a radian; 0 unless it is certain, and
  /// large enough to matter.
  [[nodiscard]] Eigen::Vector2d missed() const;
  /// One standard deviation of what a motion turns more than missed() says [rad]; 0 as long as
  /// nothing is known.
  [[nodiscard]] double sigma_rad(const Eigen::Vector2d& way_and_turn) const;

  struct Piece {
    Eigen::Vector2d way_and_turn = Eigen::Vector2d::Zero();
    double missed_rad = 0.0;

    template <typename Archive>
    void archive(Archive& a) {
      a(way_and_turn, missed_rad);
    }
  };
  struct State {
    Piece open{};
    std::deque<Piece> pieces{};  ///< the last few

    template <typename Archive>
    void archive(Archive& a) {
      a(open, pieces);
    }
  };

  [[nodiscard]] const State& state() const { return state_; }
  /// Throws UsageError when it can't have been learned.
  void restore(State state);

 private:
  void fit();

  State state_{};
  // What the pieces say.
  Eigen::Vector2d missed_ = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance_ = Eigen::Matrix2d::Zero();
  bool is_certain_ = false;
};

}  // namespace loopstone
