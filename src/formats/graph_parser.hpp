#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/edge2_order.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/g2o.hpp"

namespace loopstone {

/// Takes a graph file line by line, and puts the graph together at the end, since a line may name
/// vertices that come after it.
class GraphParser {
 public:
  GraphParser(std::string path, InformationOrder edge2_order)
      : path_(std::move(path)), edge2_order_(edge2_order) {}

  void add_line(std::string_view line, std::int64_t number);
  [[nodiscard]] GraphFile finish() &&;

 private:
  /// The words of a line, and how many; more than fit are counted.
  struct Words {
    std::array<std::string_view, 16> word{};
    std::size_t count = 0;
  };
  struct Vertex {
    std::int64_t id;
    std::int64_t line;
    Pose2 pose;
    bool is_landmark;
  };
  struct EdgeLine {
    std::int64_t from;
    std::int64_t to;
    std::int64_t line;
    Pose2 from_T_to;
    InformationNumbers numbers;  ///< upper triangle of g2o, or what an EDGE2 line has
    bool is_edge2;
  };
  struct PriorLine {
    std::int64_t id;
    std::int64_t line;
    Pose2 map_T_node;
    Eigen::Matrix3d information;
  };
  struct LandmarkLine {
    std::int64_t from;
    std::int64_t to;
    std::int64_t line;
    Eigen::Vector2d point;
    Eigen::Matrix2d information;
  };
  /// Where the node of an id lies in the graph.
  struct Node {
    std::int64_t id;
    int index;
    bool is_landmark;
  };

  [[nodiscard]] static Words split(std::string_view line);
  [[nodiscard]] Location at(std::int64_t line) const { return {path_, line}; }
  void add_vertex(const Words& words, std::int64_t line, bool is_landmark);
  void add_edge(const Words& words, std::int64_t line, bool is_edge2);
  void add_prior(const Words& words, std::int64_t line);
  void add_landmark_edge(const Words& words, std::int64_t line);
  void add_fixed(std::string_view line_text, std::int64_t line);

  void add_missing_vertices();
  void place_vertices(GraphFile& file);
  [[nodiscard]] int find(std::int64_t id, std::int64_t line, bool is_landmark) const;
  void add_edges(GraphFile& file);
  [[nodiscard]] std::string first_skipped() const;

  std::string path_;
  InformationOrder edge2_order_;
  std::vector<Vertex> vertices_{};
  std::vector<EdgeLine> edges_{};
  std::vector<PriorLine> priors_{};
  std::vector<LandmarkLine> landmark_edges_{};
  std::vector<std::pair<std::int64_t, std::int64_t>> fixed_{};  ///< id, line
  std::vector<Node> nodes_{};                                   ///< by id
  std::map<std::string, std::int64_t> skipped_tags_{};
};

}  // namespace loopstone
