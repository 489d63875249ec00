#pragma once

#include <string>
#include <utility>

#include "loopstone/slam/map_edit.hpp"
#include "slam/edit_state.hpp"

namespace loopstone {

/// What an edit of closures did: words, and the closure that it is about.
struct ClosureEdit {
  std::string told{};
  std::optional<LoopClosure> closure{};
};

/// An added closure that was refused comes with its figures.
class ClosureRefusal : public EditRefusal {
 public:
  ClosureRefusal(const std::string& why, LoopClosure refused)
      : EditRefusal(why), closure(std::move(refused)) {}
  LoopClosure closure;
};

/// Change the closures of a state and solve its graph. Throw EditRefusal; the state is of no use
/// then.
[[nodiscard]] ClosureEdit delete_closure(const DeleteClosure& edit, const EditedPath& path,
                                         EditState& state);
/// \param told_T_path  of the robot's centre: the finished map's to the one that the path is told
///                     by (correct_mount())
[[nodiscard]] ClosureEdit add_closure(const AddClosure& edit, const EditedPath& path,
                                      const Pose2& told_T_path, EditState& state);
[[nodiscard]] ClosureEdit ignore_stretch(const IgnoreStretch& edit, const EditedPath& path,
                                         EditState& state);

}  // namespace loopstone
