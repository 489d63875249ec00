#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/slam/loop_closure.hpp"
#include "loopstone/slam/submap_record.hpp"

namespace loopstone {

/// What lays one part of the path on another in one go.
struct PlacementNumbers {
  double elsewhere_m = 1.0;
  double elsewhere_rad = 0.35;
  std::size_t around = 4;
  std::size_t witnesses = 8;
};
inline constexpr PlacementNumbers kPlacement{};

template <typename Visitor>
void visit_numbers(const PlacementNumbers& n, Visitor&& visit) {
  visit("elsewhere_m", n.elsewhere_m,
        "chosen: a pose this far from the found one is another place");
  visit("elsewhere_rad", n.elsewhere_rad, "chosen: or one turned by so much");
  visit("around", n.around,
        "chosen: submaps before and after those of the closures that are asked as well, as of a "
        "closure's surroundings");
  visit("witnesses", n.witnesses, "chosen: of all of these, so many, evenly spread");
}

/// Whether a pose is another place than one that was found.
/// \param share  of what makes it another
[[nodiscard]] bool is_elsewhere(const Pose2& pose, const Pose2& found, double share = 1.0);

/// Closures across one break of the path that lay what is behind it in one place: they are right
/// or wrong together.
class Placement {
 public:
  /// \param submaps  must outlive it, and closures too
  Placement(std::span<const SubmapRecord> submaps, const LoopClosure& closure)
      : submaps_(submaps), closures_{&closure} {}

  void add(const LoopClosure& closure) { closures_.push_back(&closure); }
  /// Whether a closure is between the same two pieces of the path.
  [[nodiscard]] bool concerns(const LoopClosure& closure) const;
  /// Whether such a one lays its newer submap where these do.
  [[nodiscard]] bool holds(const LoopClosure& closure) const;
  [[nodiscard]] std::span<const LoopClosure* const> closures() const { return closures_; }
  /// The one that ends nearest to a submap in sequence.
  [[nodiscard]] const LoopClosure& nearest(SubmapId newer) const;
  /// A submap of the newer piece as these lay it.
  [[nodiscard]] Pose2 map_T_submap(SubmapId newer) const;
  /// Submaps of the newer piece that can tell whether they lie well there: those of the closures,
  /// and some around.
  [[nodiscard]] std::vector<SubmapId> witnesses() const;

 private:
  std::span<const SubmapRecord> submaps_;
  std::vector<const LoopClosure*> closures_;
};

/// A submap where a closure from it would lay it. \param newer  of its newer piece
[[nodiscard]] Pose2 laid_by(const LoopClosure& closure, SubmapId newer,
                            std::span<const SubmapRecord> submaps);

}  // namespace loopstone
