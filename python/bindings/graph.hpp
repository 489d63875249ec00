#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "loopstone/graph/pose_graph.hpp"

namespace loopstone::python {

/// A pose graph that can't be changed, and what a file of it told beside.
struct Graph {
  std::shared_ptr<const PoseGraph> graph{};
  std::vector<std::int64_t> ids{};  ///< of a file's nodes; empty: 0, 1, 2
  std::vector<std::int64_t> landmark_ids{};
  bool has_poses = true;  ///< they mean something
  std::vector<std::string> notes{};
};

[[nodiscard]] Graph whole_graph(std::shared_ptr<const PoseGraph> graph);

}  // namespace loopstone::python
