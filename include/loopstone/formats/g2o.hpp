#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/base/memory_budget.hpp"
#include "loopstone/base/words.hpp"
#include "loopstone/graph/pose_graph.hpp"

namespace loopstone {

/// In which order an EDGE2 line gives its information matrix. TORO's own files have xx xy yy tt xt
/// yt; files with g2o's order, xx xy xt yy yt tt, under the same tag are about, too.
enum class InformationOrder {
  kGuess,  ///< by which order makes every matrix positive definite, then by the pattern of zeros
  kG2o,
  kToro,
};

constexpr auto words_of(InformationOrder /*any*/) {
  using enum InformationOrder;
  return std::array{Word{kGuess, "guess"}, Word{kG2o, "g2o"}, Word{kToro, "toro"}};
}

/// A pose graph as a text file of g2o or TORO holds it.
struct GraphFile {
  PoseGraph graph;                ///< nodes in the order of their ids; FIX lines in graph.fixed
  std::vector<std::int64_t> ids;  ///< the file's name of each pose; need not be contiguous
  std::vector<std::int64_t> landmark_ids;  ///< of each landmark
  bool has_poses = false;  ///< false: no VERTEX lines, the poses are zeros and must be initialised
  std::map<std::string, std::int64_t>
      skipped_tags;                  ///< lines of other kinds, counted by their first word
  std::int64_t duplicate_edges = 0;  ///< edges beyond the first between the same two nodes
  std::int64_t backward_edges = 0;   ///< edges from a greater id to a smaller one
  std::vector<std::string> notes;    ///< what was guessed, in words for the user
};

/// Reads VERTEX_SE2, VERTEX_XY, EDGE_SE2, EDGE_SE2_XY, EDGE_SE2_PRIOR and FIX of g2o, VERTEX2 and
/// EDGE2 of TORO; counts what else there is. EDGE_SE2 may have all nine numbers of its information
/// matrix. Edges between neighbouring ids are kOdometry, all others kLoopClosure, since the format
/// doesn't say. Duplicate edges are kept: each is a measurement. Throws DataError with the line for
/// damage: a wrong count of numbers, a value that is not finite, an information matrix that is not
/// symmetric or not positive definite, a vertex twice or missing, an edge to itself, a held
/// landmark; and for a file without any edge or vertex.
[[nodiscard]] GraphFile parse_g2o(std::string_view text,
                                  const std::string& path_for_errors = "graph",
                                  InformationOrder edge2_order = InformationOrder::kGuess);
[[nodiscard]] GraphFile read_g2o(const std::string& path,
                                 InformationOrder edge2_order = InformationOrder::kGuess,
                                 const MemoryBudget& budget = {});

/// Throws DataError that names the parts of a graph that no measurement connects, with the ids of
/// each: where they lie to one another is unknown. Parts with a held pose or a prior of their own
/// are placed by it and do not count.
void require_connected(const GraphFile& file, const std::string& path_for_errors);

/// g2o's lines for all that the graph holds; ids as given, or 0, 1, 2... (landmarks after the
/// poses). Numbers read back as the same doubles.
[[nodiscard]] std::string format_g2o(const PoseGraph& graph);
[[nodiscard]] std::string format_g2o(const GraphFile& file);
void write_g2o(const std::string& path, const PoseGraph& graph);
void write_g2o(const std::string& path, const GraphFile& file);

}  // namespace loopstone
