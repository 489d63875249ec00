#include "loopstone/formats/g2o.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

#include "formats/atomic_file.hpp"
#include "formats/graph_parser.hpp"
#include "formats/text_lines.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {

namespace {

std::string format_graph(const PoseGraph& graph, const std::vector<std::int64_t>& ids,
                         const std::vector<std::int64_t>& landmark_ids) {
  std::string text;
  text.reserve(graph.poses.size() * 80 + graph.edges.size() * 200);
  const auto out = std::back_inserter(text);
  const auto id_of = [&](NodeId node) { return ids[static_cast<std::size_t>(node.index)]; };
  for (std::size_t i = 0; i < graph.poses.size(); ++i) {
    const Pose2& pose = graph.poses[i];
    fmt::format_to(out, "VERTEX_SE2 {} {} {} {}\n", ids[i], pose.x, pose.y, pose.yaw);
  }
  for (std::size_t i = 0; i < graph.landmarks.size(); ++i) {
    fmt::format_to(out, "VERTEX_XY {} {} {}\n", landmark_ids[i], graph.landmarks[i].x(),
                   graph.landmarks[i].y());
  }
  for (const NodeId node : graph.fixed) fmt::format_to(out, "FIX {}\n", id_of(node));
  for (const PosePrior& prior : graph.priors) {
    const Eigen::Matrix3d& info = prior.information;
    fmt::format_to(out, "EDGE_SE2_PRIOR {} {} {} {} {} {} {} {} {} {}\n", id_of(prior.node),
                   prior.map_T_node.x, prior.map_T_node.y, prior.map_T_node.yaw, info(0, 0),
                   info(0, 1), info(0, 2), info(1, 1), info(1, 2), info(2, 2));
  }
  for (const RelativePoseEdge& edge : graph.edges) {
    const Eigen::Matrix3d& info = edge.information;
    fmt::format_to(out, "EDGE_SE2 {} {} {} {} {} {} {} {} {} {} {}\n", id_of(edge.from),
                   id_of(edge.to), edge.from_T_to.x, edge.from_T_to.y, edge.from_T_to.yaw,
                   info(0, 0), info(0, 1), info(0, 2), info(1, 1), info(1, 2), info(2, 2));
  }
  for (const LandmarkEdge& edge : graph.landmark_edges) {
    fmt::format_to(out, "EDGE_SE2_XY {} {} {} {} {} {} {}\n", id_of(edge.from),
                   landmark_ids[static_cast<std::size_t>(edge.landmark.index)],
                   edge.point_in_from.x(), edge.point_in_from.y(), edge.information(0, 0),
                   edge.information(0, 1), edge.information(1, 1));
  }
  return text;
}

/// "0, 1, 2, 5 and 93 more (97 poses)"
std::string name_part(const std::vector<std::int64_t>& ids) {
  constexpr std::size_t kShown = 4;
  std::string text;
  for (std::size_t i = 0; i < std::min(kShown, ids.size()); ++i) {
    text += (i == 0 ? "" : ", ") + std::to_string(ids[i]);
  }
  if (ids.size() > kShown) text += fmt::format(" and {} more", ids.size() - kShown);
  return text;
}

}  // namespace

GraphFile parse_g2o(std::string_view text, const std::string& path_for_errors,
                    InformationOrder edge2_order) {
  GraphParser parser(path_for_errors, edge2_order);
  for_each_line(text,
                [&](std::string_view line, std::int64_t number) { parser.add_line(line, number); });
  return std::move(parser).finish();
}

GraphFile read_g2o(const std::string& path, InformationOrder edge2_order,
                   const MemoryBudget& budget) {
  return parse_g2o(read_whole_file(path, budget.most_text_bytes()), path, edge2_order);
}

void require_connected(const GraphFile& file, const std::string& path_for_errors) {
  constexpr std::size_t kPartsNamed = 5;
  const GraphComponents components = connected_components(file.graph);
  if (components.count < 2) return;
  std::vector<std::vector<std::int64_t>> parts(static_cast<std::size_t>(components.count));
  const auto part_of = [&](std::size_t node) {
    return static_cast<std::size_t>(components.of_node[node]);
  };
  for (std::size_t i = 0; i < file.ids.size(); ++i) parts[part_of(i)].push_back(file.ids[i]);
  std::vector<bool> placed(parts.size(), false);
  for (const NodeId node : file.graph.fixed) {
    placed[part_of(static_cast<std::size_t>(node.index))] = true;
  }
  for (const PosePrior& prior : file.graph.priors) {
    placed[part_of(static_cast<std::size_t>(prior.node.index))] = true;
  }
  const auto loose = static_cast<std::size_t>(std::count(placed.begin(), placed.end(), false));
  // One loose part is fine when it is all there is; beside placed ones it is not.
  if (loose == 0) return;
  std::string named;
  for (std::size_t i = 0; i < std::min(kPartsNamed, parts.size()); ++i) {
    named += fmt::format("{}{} ({} pose{})", i == 0 ? "" : "; ", name_part(parts[i]),
                         parts[i].size(), parts[i].size() == 1 ? "" : "s");
  }
  if (parts.size() > kPartsNamed) {
    named += fmt::format("; and {} more parts", parts.size() - kPartsNamed);
  }
  throw DataError({path_for_errors}, fmt::format("falls into {} parts that nothing connects: {}",
                                                 parts.size(), named));
}

std::string format_g2o(const PoseGraph& graph) {
  std::vector<std::int64_t> ids(graph.poses.size());
  std::iota(ids.begin(), ids.end(), 0);
  std::vector<std::int64_t> landmark_ids(graph.landmarks.size());
  std::iota(landmark_ids.begin(), landmark_ids.end(), static_cast<std::int64_t>(ids.size()));
  return format_graph(graph, ids, landmark_ids);
}

std::string format_g2o(const GraphFile& file) {
  return format_graph(file.graph, file.ids, file.landmark_ids);
}

void write_g2o(const std::string& path, const PoseGraph& graph) {
  write_file_atomically(path, format_g2o(graph));
}

void write_g2o(const std::string& path, const GraphFile& file) {
  write_file_atomically(path, format_g2o(file));
}

}  // namespace loopstone
