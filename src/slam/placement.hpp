#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/slam/loop_closure.hpp"
#include "loopstone/slam/submap_record.hpp"

namespace loopstone {

/// Who is asked about what is laid in one go.
struct PlacementNumbers {
  std::size_t around = 4;
  std::size_t witnesses = 8;
};
inline constexpr PlacementNumbers kPlacement{};

template <typename Visitor>
void visit_numbers(const PlacementNumbers& n, Visitor&& visit) {
  visit("around", n.around,
        "chosen: submaps before and after those of the closures that are asked as well, as of a "
        "closure's surroundings");
  visit("witnesses", n.witnesses, "chosen: of all of these, so many, evenly spread");
}

/// Whether a pose is another place than one that was found.
/// \param share  of what makes it another
[[nodiscard]] bool is_elsewhere(const Pose2& pose, const Pose2& found, double share = 1.0);

/// A closure across a break of the path, before it stands.
struct AskedClosure {
  LoopClosure closure;
  Eigen::Matrix3d known;  ///< covariance of the motion between its ends without it: known_motions()
};

/// Closures across one break of the path that lay what is behind it in one place: they are right
/// or wrong together.
class Placement {
 public:
  /// \param submaps  must outlive it, and what was asked too
  Placement(std::span<const SubmapRecord> submaps, const AskedClosure& asked)
      : submaps_(submaps), asked_{&asked} {}

  void add(const AskedClosure& asked) { asked_.push_back(&asked); }
  /// Whether a closure is between the same two pieces of the path.
  [[nodiscard]] bool concerns(const LoopClosure& closure) const;
  /// Whether such a one lays its newer submap where these do.
  [[nodiscard]] bool holds(const LoopClosure& closure) const;
  [[nodiscard]] std::span<const AskedClosure* const> asked() const { return asked_; }
  /// The one that ends nearest to a submap in sequence.
  [[nodiscard]] const AskedClosure& nearest(SubmapId newer) const;
  /// A submap of the newer piece as these lay it.
  [[nodiscard]] Pose2 map_T_submap(SubmapId newer) const;
  /// Submaps of the newer piece that can tell whether they lie well there: those of the closures,
  /// and some around.
  [[nodiscard]] std::vector<SubmapId> witnesses() const;

 private:
  std::span<const SubmapRecord> submaps_;
  std::vector<const AskedClosure*> asked_;
};

/// A submap where a closure would lay it. \param newer  of its newer piece
[[nodiscard]] Pose2 laid_by(const LoopClosure& closure, SubmapId newer,
                            std::span<const SubmapRecord> submaps);

}  // namespace loopstone
