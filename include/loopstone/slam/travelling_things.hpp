#pragma once

#include <deque>
#include <span>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/sensor/laser_scan.hpp"
#include "loopstone/sensor/scan_points.hpp"

namespace loopstone {

/// What tells things that travel with the robot from the building.
struct TravellingNumbers {
  double short_m = 0.3;
  double long_m = 1.0;
  double every_m = 0.1;
  double margin_m = 0.1;
  double margin_share = 0.02;
  double confirmed_share = 0.005;
  double bearing_rad = 0.012;
  double fastest = 5.0;
  int fewest_beams = 4;
  float near_m = 1.5F;
  double most_share = 0.5;
  double same_m = 0.2;
  double weak_share = 0.25;
};
inline constexpr TravellingNumbers kTravelling{};

template <typename Visitor>
void visit_numbers(const TravellingNumbers& n, Visitor&& visit) {
  visit("short_m", n.short_m,
        "chosen: a scan is held against one from so far back: farther than the margin, so that "
        "what goes along with the robot is found soon");
  visit("long_m", n.long_m,
        "chosen: and against one from here, so that what is slower is found, too; odometry is off "
        "by a few centimetres by then");
  visit("every_m", n.every_m, "chosen: a scan is kept after so much travel: a third of short_m");
  visit("margin_m", n.margin_m,
        "chosen: ranges that differ by less are the same: noise, stamps, wheels, a bent wall");
  visit("margin_share", n.margin_share, "chosen: and of the range, for what leans with the laser");
  visit(
      "confirmed_share", n.confirmed_share,
      "chosen: the same where a scan before must have shown it: what goes along is off by short_m "
      "even far away");
  visit("bearing_rad", n.bearing_rad,
        "chosen: beams beside that one are asked as well: the heading may be off by so much");
  visit("fastest", n.fastest,
        "chosen: what went ahead is looked for so many times the robot's way from where it was; "
        "the line where beams meet the floor runs faster than the robot");
  visit("fewest_beams", n.fewest_beams,
        "chosen: beams beside one another that must say so; corners, and things as thin as chair "
        "legs, are met by chance");
  visit("near_m", n.near_m, "chosen: who walks along with a robot is nearer than this");
  visit("most_share", n.most_share,
        "chosen: of the returns from farther off; where more moves than that, odometry is wrong, "
        "and nothing is said");
  visit("same_m", n.same_m,
        "chosen: what goes along stays in the same direction at the same distance but for so much: "
        "as legs do");
  visit("weak_share", n.weak_share,
        "chosen: things that travel are taken out where the rest of the scan holds the robot so "
        "much less along one direction than along the other; elsewhere it outvotes them");
}

/// Finds what moves against the ground that odometry has driven over, while the building stands:
/// the line ahead where a laser that leans meets the floor or the ceiling, and people who walk
/// along. Along a bare corridor nothing else tells how far the robot went, and it would be held
/// back by what goes with it.
///
/// Scans some way back are kept. A return of the scan at hand was
///   - free before, when the beams there went on past it;
///   - hidden before, when the beams there ended short of it, at something that beams now pass
///     through, or that is as far off in the same direction now: so that has moved on.
/// Nothing is said of single beams, nor where most of a scan would move.
/// Several lasers are told apart. Cost: two passes over the returns. Deterministic.
class TravellingThings {
 public:
  /// Beams that show such things; empty when there are none.
  /// \param covered         beams that are known to show no surroundings; empty: none
  /// \param ground_T_lidar  where odometry has brought the laser since the scans before
  /// \param path_m          travelled by odometry since the recording began
  [[nodiscard]] std::vector<bool> find(const LaserScan& scan, const Pose2& ground_T_lidar,
                                       double path_m, const std::vector<bool>& covered,
                                       BeamTable& beams) const;
  /// Beams that show what was not there before, so far as the same scans tell: what moves, and
  /// what stands where beams had found nothing, or had ended nearer. What no beam had looked at is
  /// not among it. Dark and shiny surfaces come and go, so it is no proof that something moves, but
  /// nothing should be believed for it before it is seen twice. Empty: none.
  [[nodiscard]] std::vector<bool> find_new(const LaserScan& scan, const Pose2& ground_T_lidar,
                                           double path_m, const std::vector<bool>& covered,
                                           BeamTable& beams) const;
  void remember(const LaserScan& scan, const Pose2& ground_T_lidar, double path_m);
  /// Nothing tells any more how the robot moved.
  void forget() { state_.views.clear(); }

  /// A scan of a while ago.
  struct View {
    LaserScan scan{};
    Pose2 ground_T_lidar{};
    double path_m = 0.0;

    template <typename Archive>
    void archive(Archive& a) {
      a(scan, ground_T_lidar, path_m);
    }
  };
  struct State {
    std::deque<View> views{};  ///< oldest first

    template <typename Archive>
    void archive(Archive& a) {
      a(views);
    }
  };

  [[nodiscard]] const State& state() const { return state_; }
  /// Throws UsageError when nothing can have led to it.
  void restore(State state);

 private:
  State state_{};
};

/// Whether surfaces hardly hold a robot along some direction.
[[nodiscard]] bool leave_open(std::span<const SurfacePoint> surfaces);
/// The unit direction along which they hold it least.
[[nodiscard]] Eigen::Vector2d weakest_axis(std::span<const SurfacePoint> surfaces);

}  // namespace loopstone
