#include "loopstone/formats/g2o.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <iterator>
#include <numeric>
#include <optional>
#include <unordered_map>
#include <utility>

#include "formats/atomic_file.hpp"
#include "formats/text_lines.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

struct EdgeLine {
  std::int64_t from;
  std::int64_t to;
  Pose2 from_T_to;
  Eigen::Matrix3d information;
  std::int64_t line;
};

using Words = std::vector<std::string_view>;

std::int64_t parse_id(std::string_view word, const Location& location) {
  std::int64_t id = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), id);
  if (error != std::errc{} || end != word.data() + word.size() || id < 0) {
    throw DataError(location, "a vertex id must be a whole number, 0 or more");
  }
  return id;
}

void require_words(const Words& words, std::size_t count, const char* shape,
                   const Location& location) {
  if (words.size() == count) return;
  throw DataError(location, fmt::format("expected '{}' ({} numbers), found {} numbers", shape,
                                        count - 1, words.size() - 1));
}

/// Words first, first + 1, first + 2.
Pose2 parse_pose(const Words& words, std::size_t first, const Location& location) {
  return {parse_finite(words[first], location), parse_finite(words[first + 1], location),
          wrap_angle(parse_finite(words[first + 2], location))};
}

/// The upper triangle, row by row.
Eigen::Matrix3d parse_information(const Words& words, std::size_t first, const Location& location) {
  Eigen::Matrix3d information;
  for (int row = 0; row < 3; ++row) {
    for (int column = row; column < 3; ++column) {
      information(row, column) = information(column, row) = parse_finite(words[first++], location);
    }
  }
  // The pivots of a Cholesky factorisation.
  const double pivot1 = information(0, 0);
  const double pivot2 = information(1, 1) - information(0, 1) * information(0, 1) / pivot1;
  const double rest = information(1, 2) - information(0, 1) * information(0, 2) / pivot1;
  const double pivot3 =
      information(2, 2) - information(0, 2) * information(0, 2) / pivot1 - rest * rest / pivot2;
  if (!(pivot1 > 0.0 && pivot2 > 0.0 && pivot3 > 0.0)) {
    throw DataError(location,
                    "the information matrix (I11 I12 I13 I22 I23 I33) is not positive definite; is "
                    "the order that of "
                    "TORO, or is it a covariance?");
  }
  return information;
}

class GraphParser {
 public:
  explicit GraphParser(std::string path) : path_(std::move(path)) {}

  void add_line(std::string_view line, std::int64_t number) {
    const std::string_view content = trim(line);
    if (content.empty() || content.front() == '#') return;
    const Words words = split_words(content);
    const Location location{path_, number};
    if (words[0] == "VERTEX_SE2") {
      require_words(words, 5, "VERTEX_SE2 id x y theta", location);
      const std::int64_t id = parse_id(words[1], location);
      if (!vertices_.emplace(id, parse_pose(words, 2, location)).second) {
        throw DataError(location, fmt::format("vertex {} is there twice", id));
      }
    } else if (words[0] == "EDGE_SE2") {
      require_words(words, 12, "EDGE_SE2 i j dx dy dtheta I11 I12 I13 I22 I23 I33", location);
      EdgeLine edge{parse_id(words[1], location), parse_id(words[2], location),
                    parse_pose(words, 3, location), parse_information(words, 6, location), number};
      if (edge.from == edge.to) {
        throw DataError(location, fmt::format("the edge joins vertex {} to itself", edge.from));
      }
      edges_.push_back(std::move(edge));
    } else if (words[0] == "FIX") {
      for (std::size_t i = 1; i < words.size(); ++i)
        fixed_.emplace_back(parse_id(words[i], location), number);
    } else {
      ++skipped_tags_[printable(words[0])];
    }
  }

  [[nodiscard]] GraphFile finish() && {
    if (vertices_.empty() && edges_.empty()) {
      throw DataError({path_}, "holds no VERTEX_SE2 and no EDGE_SE2 line" + first_skipped());
    }
    GraphFile file;
    file.has_poses = !vertices_.empty();
    if (!file.has_poses) {
      for (const EdgeLine& edge : edges_) {
        vertices_.emplace(edge.from, Pose2{});
        vertices_.emplace(edge.to, Pose2{});
      }
    }
    std::unordered_map<std::int64_t, int> index_of;
    for (const auto& [id, pose] : vertices_) {
      index_of.emplace(id, static_cast<int>(file.ids.size()));
      file.ids.push_back(id);
      file.graph.poses.push_back(pose);
    }
    const auto node = [&](std::int64_t id, std::int64_t line) {
      const auto found = index_of.find(id);
      if (found == index_of.end()) {
        throw DataError({path_, line}, fmt::format("vertex {} has no VERTEX_SE2 line", id));
      }
      return NodeId{found->second};
    };
    for (const EdgeLine& edge : edges_) {
      const NodeId from = node(edge.from, edge.line);
      const NodeId to = node(edge.to, edge.line);
      const bool neighbours = edge.to - edge.from == 1 || edge.from - edge.to == 1;
      file.graph.edges.push_back({from, to, edge.from_T_to, edge.information,
                                  neighbours ? EdgeKind::kOdometry : EdgeKind::kLoopClosure});
    }
    for (const auto& [id, line] : fixed_) file.fixed.push_back(node(id, line));
    file.skipped_tags = std::move(skipped_tags_);
    return file;
  }

 private:
  static std::string printable(std::string_view word) {
    std::string text;
    for (const char c : word.substr(0, 32)) text += c > ' ' && c <= '~' ? c : '?';
    return text;
  }

  [[nodiscard]] std::string first_skipped() const {
    if (skipped_tags_.empty()) return "; is it a g2o file?";
    return ", only lines such as '" + skipped_tags_.begin()->first +
           "'; is it a 2D graph in g2o's format?";
  }

  std::string path_;
  std::map<std::int64_t, Pose2> vertices_{};
  std::vector<EdgeLine> edges_{};
  std::vector<std::pair<std::int64_t, std::int64_t>> fixed_{};  // id, line
  std::map<std::string, std::int64_t> skipped_tags_{};
};

std::string format_graph(const PoseGraph& graph, const std::vector<std::int64_t>& ids,
                         const std::vector<NodeId>& fixed) {
  std::string text;
  text.reserve(graph.poses.size() * 80 + graph.edges.size() * 200);
  const auto out = std::back_inserter(text);
  const auto id_of = [&](NodeId node) { return ids[static_cast<std::size_t>(node.index)]; };
  for (std::size_t i = 0; i < graph.poses.size(); ++i) {
    const Pose2& pose = graph.poses[i];
    fmt::format_to(out, "VERTEX_SE2 {} {} {} {}\n", ids[i], pose.x, pose.y, pose.yaw);
  }
  for (const NodeId node : fixed) fmt::format_to(out, "FIX {}\n", id_of(node));
  for (const RelativePoseEdge& edge : graph.edges) {
    const Eigen::Matrix3d& info = edge.information;
    fmt::format_to(out, "EDGE_SE2 {} {} {} {} {} {} {} {} {} {} {}\n", id_of(edge.from),
                   id_of(edge.to), edge.from_T_to.x, edge.from_T_to.y, edge.from_T_to.yaw,
                   info(0, 0), info(0, 1), info(0, 2), info(1, 1), info(1, 2), info(2, 2));
  }
  return text;
}

}  // namespace

GraphFile parse_g2o(std::string_view text, const std::string& path_for_errors) {
  GraphParser parser(path_for_errors);
  for_each_line(text,
                [&](std::string_view line, std::int64_t number) { parser.add_line(line, number); });
  return std::move(parser).finish();
}

GraphFile read_g2o(const std::string& path) { return parse_g2o(read_whole_file(path), path); }

std::string format_g2o(const PoseGraph& graph) {
  std::vector<std::int64_t> ids(graph.poses.size());
  std::iota(ids.begin(), ids.end(), 0);
  return format_graph(graph, ids, {});
}

std::string format_g2o(const GraphFile& file) {
  return format_graph(file.graph, file.ids, file.fixed);
}

void write_g2o(const std::string& path, const PoseGraph& graph) {
  write_file_atomically(path, format_g2o(graph));
}

void write_g2o(const std::string& path, const GraphFile& file) {
  write_file_atomically(path, format_g2o(file));
}

}  // namespace loopstone
