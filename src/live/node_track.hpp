#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "loopstone/live/view_contents.hpp"
#include "loopstone/messages/message_types.hpp"

namespace loopstone {

/// The nodes as they were told last.
class NodeTrack {
 public:
  /// Nodes as they are now: what differs from the first difference on, or nothing. What moved by
  /// less than a millimetre has not moved.
  [[nodiscard]] std::optional<msg::Trajectory> change(std::vector<ViewNode> nodes);
  [[nodiscard]] msg::Trajectory whole() const { return message_from(0); }
  [[nodiscard]] const std::vector<ViewNode>& nodes() const { return nodes_; }

 private:
  [[nodiscard]] msg::Trajectory message_from(std::size_t first) const;

  std::vector<ViewNode> nodes_{};
};

}  // namespace loopstone
