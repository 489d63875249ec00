#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/base/words.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/odometry/odometry_accuracy.hpp"
#include "loopstone/odometry/odometry_lag.hpp"

namespace loopstone {

/// What the comparison of odometry with the laser decides by.
struct OdometryCheckNumbers {
  double piece_m = 0.25;
  double piece_rad = 0.25;
  double rest_m = 0.045;
  double rest_rad = 0.045;
  double share = 2.0 * kOdometryAccuracy.first_share;
  double heading_rad_per_m = kOdometryAccuracy.first_rad_per_m;
  double longest_piece_s = 4.0;
  int pieces = 10;
  int wrong_to_distrust = 7;
  int wrong_in_a_row = 5;
  int right_to_trust = 8;
  double clearly_right = 0.5;
  double jump = 3.0;
  double jumps_apart_s = 2.0;
  double stands = 0.1;
  double explained = 0.25;
  int pieces_for_scale = 20;
  int pieces_assumed = 200;
  double straight_rad_per_m = 0.2;
  double straight_m = 0.01;
  double enough_straight_m = 10.0;
};
inline constexpr OdometryCheckNumbers kOdometryCheck{};

template <typename Visitor>
void visit_numbers(const OdometryCheckNumbers& n, Visitor&& visit) {
  visit("piece_m", n.piece_m,
        "chosen: long enough that a centimetre of the laser's noise is small beside it, short "
        "enough that drift is");
  visit("piece_rad", n.piece_rad, "chosen: as piece_m, of a point a metre off");
  visit("rest_m", n.rest_m,
        "chosen: disagreement that means nothing, what laser, stamps and rounding make of a robot "
        "that stands");
  visit("rest_rad", n.rest_rad, "chosen: as rest_m, of a point a metre off");
  visit("share", n.share,
        "derived: two standard deviations of wheels of which nothing is known: twice first_share "
        "of their accuracy");
  visit("heading_rad_per_m", n.heading_rad_per_m,
        "derived: what such wheels lose by driving straight: first_rad_per_m of their accuracy");
  visit("longest_piece_s", n.longest_piece_s,
        "chosen: what adds up more slowly is drift, not a wrong reading");
  visit("pieces", n.pieces, "chosen: so many are remembered, some metres of travel");
  visit("wrong_to_distrust", n.wrong_to_distrust,
        "derived: of 10 pieces; when one in twenty is wrong by chance, once in some ten million "
        "(binomial)");
  visit(
      "wrong_in_a_row", n.wrong_in_a_row,
      "derived: 0.05^5; when one in twenty is wrong by chance, once in some three million pieces");
  visit("right_to_trust", n.right_to_trust,
        "chosen: of 10 pieces; more than a fault that comes and goes leaves right");
  visit("clearly_right", n.clearly_right,
        "chosen: share of the tolerance; a fault that just passes is no reason to trust again");
  visit("jump", n.jump,
        "chosen: one step off by so many tolerances, and so many times what the robot moved, is a "
        "jump: no slip is");
  visit("jumps_apart_s", n.jumps_apart_s,
        "chosen: jumps nearer to one another than this are a way of being wrong, not accidents");
  visit("stands", n.stands, "chosen: one side that moves less than this share of the other stands");
  visit(
      "explained", n.explained,
      "chosen: a factor explains the disagreement when no larger share is left (root mean square)");
  visit("pieces_for_scale", n.pieces_for_scale,
        "chosen: some metres; before, the ratio says more of single pieces than of the wheels");
  visit(
      "pieces_assumed", n.pieces_assumed,
      "chosen: a factor that another drive told counts as so many pieces: tyres and floors change");
  visit("straight_rad_per_m", n.straight_rad_per_m,
        "chosen: a motion that turns less is straight: on a circle of 5 m or more");
  visit("straight_m", n.straight_m,
        "chosen: a shorter motion has no direction beside the laser's noise");
  visit("enough_straight_m", n.enough_straight_m,
        "chosen: over so much of it the mean direction is known to a few tenths of a degree");
}

/// What is wrong with odometry, as far as the laser can tell.
enum class OdometryFault {
  kStuck,     ///< it says that the robot stands while it moves
  kSpinning,  ///< it says that the robot moves while it stands
  kMirrored,  ///< it moves the other way
  kScaled,    ///< too far or not far enough, by a steady factor
  kLagging,   ///< right, but at another time
  kWrong,     ///< it disagrees, and in none of these ways
};

constexpr auto words_of(OdometryFault /*any*/) {
  using enum OdometryFault;
  return std::array{Word{kStuck, "stuck"},       Word{kSpinning, "spinning"},
                    Word{kMirrored, "mirrored"}, Word{kScaled, "scaled"},
                    Word{kLagging, "lagging"},   Word{kWrong, "wrong"}};
}

enum class OdometryPart { kTranslation, kRotation, kWhole };

constexpr auto words_of(OdometryPart /*any*/) {
  using enum OdometryPart;
  return std::array{Word{kTranslation, "translation"}, Word{kRotation, "rotation"},
                    Word{kWhole, "whole"}};
}

/// A time during which odometry, or a part of it, was not trusted.
struct OdometryEpisode {
  OdometryPart part = OdometryPart::kWhole;
  OdometryFault fault = OdometryFault::kWrong;
  Stamp from{};       ///< of the first motion that disagreed
  Stamp noticed{};    ///< from then on it was not used
  Stamp to{};         ///< when it had become right again, or the end
  bool over = false;  ///< it became right again
  double ratio =
      0.0;  ///< odometry's motion / the laser's, least squares; of the motions that showed it
  double lag_s = 0.0;  ///< kLagging: so late (early when negative)

  template <typename Archive>
  void archive(Archive& a) {
    a(part, fault, from, noticed, to, over, ratio, lag_s);
  }
};

/// In words, such as "it stands still while the robot drives".
[[nodiscard]] std::string what_is_wrong(const OdometryEpisode& episode);

/// The motion from one scan to the next as both tell it, in the frame of the first.
struct MotionPair {
  Stamp from{};
  Stamp to{};
  Pose2 odometry{};
  Pose2 laser{};
  bool sees_translation = true;  ///< the laser could tell it; along a corridor it can't
  bool sees_rotation = true;
  bool odometry_has_translation = true;  ///< false: a gyro alone
};

/// One part of the motion, cut into pieces long enough that noise is small beside them. A piece is
/// wrong when both disagree by more than twice what wheels are ever granted. Odometry loses trust
/// when 5 in a row or 7 of the last 10 pieces are wrong, which happens once in some million pieces
/// when one in twenty is wrong by chance (binomial), and regains it when 8 of 10 are clearly right,
/// within half of that.
class MotionAgreement {
 public:
  /// \param piece  length of a piece [m or rad]
  /// \param rest   disagreement that means nothing: noise of the laser, stamps
  MotionAgreement(double piece, double rest) : piece_(piece), rest_(rest) {}

  /// \param slack  disagreement that this motion allows beside its own share, for example heading
  ///               lost by driving
  void add(Stamp from, Stamp to, const Eigen::Vector2d& odometry, const Eigen::Vector2d& laser,
           double slack);

  /// What another drive told of scale(), before the first motion.
  void assume_scale(double scale);

  [[nodiscard]] bool trusted() const { return state_.trusted; }
  /// What the pieces that are wrong look like.
  [[nodiscard]] OdometryFault fault() const;
  [[nodiscard]] double ratio() const;
  /// Of the oldest wrong piece that is remembered.
  [[nodiscard]] Stamp wrong_since() const;
  /// Steps so far off that nothing but a jump explains them, while the pieces around were right.
  [[nodiscard]] int jumps() const { return state_.jumps; }
  /// Odometry's motion / the laser's over all pieces that were right; nothing before there were 20
  /// of them.
  [[nodiscard]] std::optional<double> scale() const;

  struct Piece {
    Stamp from{};
    Eigen::Vector2d odometry = Eigen::Vector2d::Zero();
    Eigen::Vector2d laser = Eigen::Vector2d::Zero();
    bool wrong = false;
    bool right = false;  ///< clearly
    bool jump = false;

    template <typename Archive>
    void archive(Archive& a) {
      a(from, odometry, laser, wrong, right, jump);
    }
  };
  /// Sums of products of odometry's motion (o) and the laser's (l).
  struct Moments {
    double oo = 0.0;
    double ol = 0.0;
    double ll = 0.0;

    template <typename Archive>
    void archive(Archive& a) {
      a(oo, ol, ll);
    }
  };
  struct State {
    Piece open{};
    bool is_open = false;
    double open_slack = 0.0;
    std::deque<Piece> pieces{};  ///< the last few
    int wrong_in_a_row = 0;
    bool trusted = true;
    int jumps = 0;
    std::optional<Stamp> last_jump{};
    Moments right{};  ///< of the pieces that were not wrong
    int right_count = 0;

    template <typename Archive>
    void archive(Archive& a) {
      a(open, is_open, open_slack, pieces, wrong_in_a_row, trusted, jumps, last_jump, right,
        right_count);
    }
  };

  [[nodiscard]] const State& state() const { return state_; }
  /// Throws UsageError when nothing can have led to it.
  void restore(State state);

 private:
  [[nodiscard]] double tolerance(double laser_length, double slack) const;
  [[nodiscard]] Moments wrong_moments() const;
  void close(double error, double tolerance, bool jump);

  double piece_;
  double rest_;
  State state_{};
};

/// Compares odometry with the laser while the robot drives, and tells when it can't be trusted.
///
/// Translation and rotation are judged apart: a stuck wheel does not spoil the gyro's heading. What
/// the laser can't see (along a corridor) is not held against odometry.
/// Cost: some microseconds a scan. Memory: bounded. Deterministic.
class OdometryCheck {
 public:
  /// Odometry's way / the real one, as another drive told it; before the first motion.
  void assume_scale(double scale) { translation_.assume_scale(scale); }
  void add(const MotionPair& pair);

  [[nodiscard]] bool trusts_translation() const { return translation_.trusted() && !lag_.lag_s(); }
  [[nodiscard]] bool trusts_rotation() const { return rotation_.trusted() && !lag_.lag_s(); }
  /// How late odometry is; nothing while it is in time, as far as is known.
  [[nodiscard]] std::optional<double> lag_s() const { return lag_.lag_s(); }
  /// From now on it is read at another time: what is known of its lag is no more.
  void forget_lag() { lag_ = {}; }

  /// In order of their beginning; the last of a part may still go on.
  [[nodiscard]] const std::vector<OdometryEpisode>& episodes() const { return own_.episodes; }
  /// Time during which some part of odometry was not trusted.
  [[nodiscard]] double distrusted_s() const { return own_.distrusted_s; }
  [[nodiscard]] const MotionAgreement& translation() const { return translation_; }
  [[nodiscard]] const MotionAgreement& rotation() const { return rotation_; }
  /// Direction in which the laser sees the robot go while odometry goes straight ahead [rad]: of a
  /// laser that looks where its mount says, 0. Nothing before 10 m of going straight.
  [[nodiscard]] std::optional<double> laser_heading_offset_rad() const;

  /// Motions that go nearly straight, odometry's beside the laser's.
  struct Straight {
    double length_m = 0.0;
    double dot = 0.0;
    double cross = 0.0;

    template <typename Archive>
    void archive(Archive& a) {
      a(length_m, dot, cross);
    }
  };
  struct State {
    /// What the parts do not have.
    struct Own {
      std::vector<OdometryEpisode> episodes{};
      double distrusted_s = 0.0;
      Straight straight{};

      template <typename Archive>
      void archive(Archive& a) {
        a(episodes, distrusted_s, straight);
      }
    };
    MotionAgreement::State translation{};
    MotionAgreement::State rotation{};
    OdometryLag::State lag{};
    Own own{};

    template <typename Archive>
    void archive(Archive& a) {
      a(translation, rotation, lag, own);
    }
  };

  [[nodiscard]] State state() const;
  /// Throws UsageError when nothing can have led to it; then the check is of no use.
  void restore(State state);

 private:
  void follow(const MotionAgreement& agreement, OdometryPart part, Stamp now);
  void follow_lag(Stamp now);
  [[nodiscard]] OdometryEpisode* running(OdometryPart part);
  void follow_straight(const MotionPair& pair);

  MotionAgreement translation_{kOdometryCheck.piece_m, kOdometryCheck.rest_m};
  MotionAgreement rotation_{kOdometryCheck.piece_rad, kOdometryCheck.rest_rad};
  OdometryLag lag_{};
  State::Own own_{};
};

}  // namespace loopstone
