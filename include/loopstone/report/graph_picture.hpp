#pragma once

#include <string>
#include <vector>

#include "loopstone/formats/image.hpp"
#include "loopstone/graph/pose_graph.hpp"

namespace loopstone {

/// A pose graph as it is drawn: where its nodes were, and where they are.
struct GraphScene {
  const PoseGraph* graph = nullptr;  ///< its edges; poses and landmarks are those of `after`
  std::vector<Pose2> before{};
  std::vector<double> weights{};        ///< of the edges; empty: all 1
  std::string before_title = "before";  ///< what stands above the pictures
  std::string after_title = "after";
};

struct GraphPictureOptions {
  int panel_px = 1000;  ///< longer side of one of the two pictures
  /// Edges of less weight count as set aside: red and dashed.
  double set_aside_below = 0.5;
};

/// Before and after side by side: the path from its beginning to its end in colour, loop closures
/// thin, by how badly they fit (light grey to ink), those set aside red and dashed, landmarks as
/// dots. Both at one scale, unless one is much larger. 8-bit RGB.
/// Throws UsageError when there are no poses, or not as many before as after.
[[nodiscard]] Image draw_graph_picture(const GraphScene& scene,
                                       const GraphPictureOptions& options = {});

}  // namespace loopstone
