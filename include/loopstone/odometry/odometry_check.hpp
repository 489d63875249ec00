#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>
#include <string_view>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/odometry/odometry_lag.hpp"

namespace loopstone {

/// What is wrong with odometry, as far as the laser can tell.
enum class OdometryFault {
  kStuck,     ///< it says that the robot stands while it moves
  kSpinning,  ///< it says that the robot moves while it stands
  kMirrored,  ///< it moves the other way
  kScaled,    ///< too far or not far enough, by a steady factor
  kLagging,   ///< right, but at another time
  kWrong,     ///< it disagrees, and in none of these ways
};

[[nodiscard]] std::string_view to_string(OdometryFault fault);

enum class OdometryPart { kTranslation, kRotation, kWhole };

[[nodiscard]] std::string_view to_string(OdometryPart part);

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

  [[nodiscard]] bool trusted() const { return trusted_; }
  /// What the pieces that are wrong look like.
  [[nodiscard]] OdometryFault fault() const;
  [[nodiscard]] double ratio() const;
  /// Of the oldest wrong piece that is remembered.
  [[nodiscard]] Stamp wrong_since() const;
  /// Steps so far off that nothing but a jump explains them, while the pieces around were right.
  [[nodiscard]] int jumps() const { return jumps_; }
  /// Odometry's motion / the laser's over all pieces that were right; nothing before there were 20
  /// of them.
  [[nodiscard]] std::optional<double> scale() const;

  template <typename Archive>
  void archive(Archive& a) {
    a(open_, is_open_, open_slack_, pieces_, wrong_in_a_row_, trusted_, jumps_, last_jump_, right_,
      right_count_);
  }

 private:
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
  struct Moments {
    double oo = 0.0;
    double ol = 0.0;
    double ll = 0.0;

    template <typename Archive>
    void archive(Archive& a) {
      a(oo, ol, ll);
    }
  };

  [[nodiscard]] double tolerance(double laser_length, double slack) const;
  [[nodiscard]] Moments wrong_moments() const;
  void close(double error, double tolerance, bool jump);

  double piece_;
  double rest_;
  Piece open_{};
  bool is_open_ = false;
  double open_slack_ = 0.0;
  std::deque<Piece> pieces_{};
  int wrong_in_a_row_ = 0;
  bool trusted_ = true;
  int jumps_ = 0;
  std::optional<Stamp> last_jump_{};
  Moments right_{};
  int right_count_ = 0;
};

/// Compares odometry with the laser while the robot drives, and tells when it can't be trusted.
///
/// Translation and rotation are judged apart: a stuck wheel does not spoil the gyro's heading. What
/// the laser can't see (along a corridor) is not held against odometry.
/// Cost: some microseconds a scan. Memory: bounded. Deterministic.
class OdometryCheck {
 public:
  void add(const MotionPair& pair);

  [[nodiscard]] bool trusts_translation() const { return translation_.trusted() && !lag_.lag_s(); }
  [[nodiscard]] bool trusts_rotation() const { return rotation_.trusted() && !lag_.lag_s(); }

  /// In order of their beginning; the last of a part may still go on.
  [[nodiscard]] const std::vector<OdometryEpisode>& episodes() const { return episodes_; }
  /// Time during which some part of odometry was not trusted.
  [[nodiscard]] double distrusted_s() const { return distrusted_s_; }
  [[nodiscard]] const MotionAgreement& translation() const { return translation_; }
  [[nodiscard]] const MotionAgreement& rotation() const { return rotation_; }
  /// Direction in which the laser sees the robot go while odometry goes straight ahead [rad]: of a
  /// laser that looks where its mount says, 0. Nothing before 10 m of going straight.
  [[nodiscard]] std::optional<double> laser_heading_offset_rad() const;

  template <typename Archive>
  void archive(Archive& a) {
    a(translation_, rotation_, lag_, episodes_, distrusted_s_, straight_);
  }

 private:
  void follow(const MotionAgreement& agreement, OdometryPart part, Stamp now);
  void follow_lag(Stamp now);
  [[nodiscard]] OdometryEpisode* running(OdometryPart part);

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
  void follow_straight(const MotionPair& pair);

  MotionAgreement translation_{0.25, 0.045};
  MotionAgreement rotation_{0.25, 0.045};
  OdometryLag lag_{};
  std::vector<OdometryEpisode> episodes_{};
  double distrusted_s_ = 0.0;
  Straight straight_{};
};

}  // namespace loopstone
