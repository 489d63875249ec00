#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/graph/pose_graph.hpp"

namespace loopstone {

/// A pose graph as a g2o text file holds it.
struct GraphFile {
  PoseGraph graph;                ///< nodes in the order of their ids
  std::vector<std::int64_t> ids;  ///< the file's name of each node; need not be contiguous
  bool has_poses = false;  ///< false: no VERTEX lines, the poses are zeros and must be initialised
  std::vector<NodeId> fixed;  ///< named by FIX lines
  std::map<std::string, std::int64_t>
      skipped_tags;  ///< lines of other kinds, counted by their first word
};

/// Reads VERTEX_SE2, EDGE_SE2 and FIX; counts what else there is. Edges between neighbouring ids are kOdometry, all others
/// kLoopClosure, since the format doesn't say. Throws DataError with the line for damage: a wrong count of numbers, a value that is not
/// finite, an information matrix that is not positive definite, a vertex twice or missing, an edge to itself; and
/// for a file without any edge or vertex.
[[nodiscard]] GraphFile parse_g2o(std::string_view text,
                                  const std::string& path_for_errors = "graph");
[[nodiscard]] GraphFile read_g2o(const std::string& path);

/// VERTEX_SE2 and EDGE_SE2 lines; ids as given, or 0, 1, 2... Numbers read back as the same doubles.
[[nodiscard]] std::string format_g2o(const PoseGraph& graph);
[[nodiscard]] std::string format_g2o(const GraphFile& file);
void write_g2o(const std::string& path, const PoseGraph& graph);
void write_g2o(const std::string& path, const GraphFile& file);

}  // namespace loopstone
