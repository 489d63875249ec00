#include "formats/graph_parser.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "formats/text_lines.hpp"
#include "formats/text_numbers.hpp"

namespace loopstone {

namespace {

constexpr const char* kNotDefinite =
    "the information matrix ({}) is not positive definite; is its order another one, or is it a "
    "covariance?";

std::int64_t id_of(std::string_view word, const Location& location) {
  const std::optional<std::int64_t> id = parse_integer(word);
  if (!id || *id < 0) throw DataError(location, "a vertex id must be a whole number, 0 or more");
  return *id;
}

double number_of(std::string_view word, const Location& location) {
  const std::optional<double> number = parse_number(word);
  return number && std::isfinite(*number) ? *number : parse_finite(word, location);
}

void require_words(std::size_t found, std::size_t count, const char* shape,
                   const Location& location) {
  if (found == count) return;
  throw DataError(location, fmt::format("expected '{}' ({} numbers), found {} numbers", shape,
                                        count - 1, found - 1));
}

/// Words first, first + 1, first + 2.
template <typename Words>
Pose2 pose_of(const Words& words, std::size_t first, const Location& location) {
  return {number_of(words.word[first], location), number_of(words.word[first + 1], location),
          wrap_angle(number_of(words.word[first + 2], location))};
}

template <typename Words>
InformationNumbers six_numbers(const Words& words, std::size_t first, const Location& location) {
  InformationNumbers numbers{};
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    numbers[i] = number_of(words.word[first + i], location);
  }
  return numbers;
}

/// The upper triangle of nine numbers.
template <typename Words>
InformationNumbers nine_numbers(const Words& words, std::size_t first, const Location& location) {
  Eigen::Matrix3d m;
  for (std::size_t i = 0; i < 9; ++i) {
    m(static_cast<Eigen::Index>(i / 3), static_cast<Eigen::Index>(i % 3)) =
        number_of(words.word[first + i], location);
  }
  if ((m - m.transpose()).cwiseAbs().maxCoeff() > 1e-9 * m.cwiseAbs().maxCoeff()) {
    throw DataError(location, "the information matrix (nine numbers) is not symmetric");
  }
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2)};
}

std::string printable(std::string_view word) {
  std::string text;
  for (const char c : word.substr(0, 32)) text += c > ' ' && c <= '~' ? c : '?';
  return text;
}

}  // namespace

GraphParser::Words GraphParser::split(std::string_view line) {
  Words words;
  loopstone::Words rest(line);
  for (std::string_view word = rest.next(); !word.empty(); word = rest.next(), ++words.count) {
    if (words.count < words.word.size()) words.word[words.count] = word;
  }
  return words;
}

void GraphParser::add_line(std::string_view line, std::int64_t number) {
  const std::string_view content = trim(line);
  if (content.empty() || content.front() == '#') return;
  const Words words = split(content);
  const std::string_view tag = words.word[0];
  if (tag == "EDGE_SE2" || tag == "EDGE2") {
    add_edge(words, number, tag == "EDGE2");
  } else if (tag == "VERTEX_SE2" || tag == "VERTEX2") {
    add_vertex(words, number, false);
  } else if (tag == "VERTEX_XY") {
    add_vertex(words, number, true);
  } else if (tag == "EDGE_SE2_XY") {
    add_landmark_edge(words, number);
  } else if (tag == "EDGE_SE2_PRIOR") {
    add_prior(words, number);
  } else if (tag == "FIX") {
    add_fixed(content, number);
  } else {
    ++skipped_tags_[printable(tag)];
  }
}

void GraphParser::add_vertex(const Words& words, std::int64_t line, bool is_landmark) {
  if (is_landmark) {
    require_words(words.count, 4, "VERTEX_XY id x y", at(line));
    vertices_.push_back(
        {id_of(words.word[1], at(line)),
         line,
         {number_of(words.word[2], at(line)), number_of(words.word[3], at(line)), 0.0},
         true});
    return;
  }
  require_words(words.count, 5,
                words.word[0] == "VERTEX2" ? "VERTEX2 id x y theta" : "VERTEX_SE2 id x y theta",
                at(line));
  vertices_.push_back({id_of(words.word[1], at(line)), line, pose_of(words, 2, at(line)), false});
}

void GraphParser::add_edge(const Words& words, std::int64_t line, bool is_edge2) {
  const bool nine = !is_edge2 && words.count == 15;
  if (!nine) {
    require_words(words.count, 12,
                  is_edge2 ? "EDGE2 i j dx dy dtheta and six numbers of its information"
                           : "EDGE_SE2 i j dx dy dtheta I11 I12 I13 I22 I23 I33",
                  at(line));
  }
  const EdgeLine edge{id_of(words.word[1], at(line)),
                      id_of(words.word[2], at(line)),
                      line,
                      pose_of(words, 3, at(line)),
                      nine ? nine_numbers(words, 6, at(line)) : six_numbers(words, 6, at(line)),
                      is_edge2};
  if (edge.from == edge.to) {
    throw DataError(at(line), fmt::format("the edge joins vertex {} to itself", edge.from));
  }
  if (!is_edge2 && !is_positive_definite(information_from(edge.numbers, InformationOrder::kG2o))) {
    throw DataError(at(line), fmt::format(kNotDefinite, "I11 I12 I13 I22 I23 I33"));
  }
  edges_.push_back(edge);
}

void GraphParser::add_prior(const Words& words, std::int64_t line) {
  require_words(words.count, 11, "EDGE_SE2_PRIOR i x y theta I11 I12 I13 I22 I23 I33", at(line));
  const Eigen::Matrix3d information =
      information_from(six_numbers(words, 5, at(line)), InformationOrder::kG2o);
  if (!is_positive_definite(information)) {
    throw DataError(at(line), fmt::format(kNotDefinite, "I11 I12 I13 I22 I23 I33"));
  }
  priors_.push_back(
      {id_of(words.word[1], at(line)), line, pose_of(words, 2, at(line)), information});
}

void GraphParser::add_landmark_edge(const Words& words, std::int64_t line) {
  require_words(words.count, 8, "EDGE_SE2_XY i j x y I11 I12 I22", at(line));
  const double xx = number_of(words.word[5], at(line));
  const double xy = number_of(words.word[6], at(line));
  const double yy = number_of(words.word[7], at(line));
  if (!(xx > 0.0 && yy - xy * xy / xx > 0.0)) {
    throw DataError(at(line), fmt::format(kNotDefinite, "I11 I12 I22"));
  }
  Eigen::Matrix2d information;
  information << xx, xy, xy, yy;
  landmark_edges_.push_back(
      {id_of(words.word[1], at(line)),
       id_of(words.word[2], at(line)),
       line,
       {number_of(words.word[3], at(line)), number_of(words.word[4], at(line))},
       information});
}

void GraphParser::add_fixed(std::string_view line_text, std::int64_t line) {
  loopstone::Words words(line_text);
  (void)words.next();
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    fixed_.emplace_back(id_of(word, at(line)), line);
  }
}

void GraphParser::add_missing_vertices() {
  std::map<std::int64_t, bool> is_landmark;
  for (const EdgeLine& edge : edges_) {
    is_landmark.emplace(edge.from, false);
    is_landmark.emplace(edge.to, false);
  }
  for (const PriorLine& prior : priors_) is_landmark.emplace(prior.id, false);
  for (const LandmarkLine& edge : landmark_edges_) is_landmark.emplace(edge.from, false);
  for (const LandmarkLine& edge : landmark_edges_) is_landmark.emplace(edge.to, true);
  for (const auto& [id, landmark] : is_landmark) vertices_.push_back({id, 0, {}, landmark});
}

void GraphParser::place_vertices(GraphFile& file) {
  std::stable_sort(vertices_.begin(), vertices_.end(),
                   [](const Vertex& a, const Vertex& b) { return a.id < b.id; });
  nodes_.reserve(vertices_.size());
  for (const Vertex& vertex : vertices_) {
    if (!nodes_.empty() && nodes_.back().id == vertex.id) {
      throw DataError(at(vertex.line), fmt::format("vertex {} is there twice", vertex.id));
    }
    if (vertex.is_landmark) {
      nodes_.push_back({vertex.id, static_cast<int>(file.graph.landmarks.size()), true});
      file.landmark_ids.push_back(vertex.id);
      file.graph.landmarks.push_back(vertex.pose.translation());
    } else {
      nodes_.push_back({vertex.id, static_cast<int>(file.graph.poses.size()), false});
      file.ids.push_back(vertex.id);
      file.graph.poses.push_back(vertex.pose);
    }
  }
}

int GraphParser::find(std::int64_t id, std::int64_t line, bool is_landmark) const {
  const auto found = std::lower_bound(nodes_.begin(), nodes_.end(), id,
                                      [](const Node& node, std::int64_t i) { return node.id < i; });
  if (found == nodes_.end() || found->id != id) {
    throw DataError(at(line), fmt::format("vertex {} has no {} line", id,
                                          is_landmark ? "VERTEX_XY" : "VERTEX_SE2"));
  }
  if (found->is_landmark != is_landmark) {
    throw DataError(at(line), fmt::format("vertex {} is a {}, and this line needs a {}", id,
                                          found->is_landmark ? "landmark" : "pose",
                                          is_landmark ? "landmark" : "pose"));
  }
  return found->index;
}

void GraphParser::add_edges(GraphFile& file) {
  InformationOrder order = edge2_order_;
  if (order == InformationOrder::kGuess) {
    std::vector<InformationNumbers> numbers;
    for (const EdgeLine& edge : edges_) {
      if (edge.is_edge2) numbers.push_back(edge.numbers);
    }
    OrderGuess guess = guess_edge2_order(numbers);
    order = guess.order;
    if (!numbers.empty()) file.notes.push_back(std::move(guess.reason));
  }
  std::vector<std::pair<int, int>> joined;
  joined.reserve(edges_.size());
  file.graph.edges.reserve(edges_.size());
  for (const EdgeLine& edge : edges_) {
    const int from = find(edge.from, edge.line, false);
    const int to = find(edge.to, edge.line, false);
    const Eigen::Matrix3d information =
        information_from(edge.numbers, edge.is_edge2 ? order : InformationOrder::kG2o);
    if (edge.is_edge2 && !is_positive_definite(information)) {
      throw DataError(at(edge.line), fmt::format(kNotDefinite, order == InformationOrder::kToro
                                                                   ? "xx xy yy tt xt yt"
                                                                   : "xx xy xt yy yt tt"));
    }
    const bool neighbours = edge.to - edge.from == 1 || edge.from - edge.to == 1;
    file.graph.edges.push_back({NodeId{from}, NodeId{to}, edge.from_T_to, information,
                                neighbours ? EdgeKind::kOdometry : EdgeKind::kLoopClosure});
    file.backward_edges += edge.from > edge.to ? 1 : 0;
    joined.emplace_back(std::min(from, to), std::max(from, to));
  }
  std::sort(joined.begin(), joined.end());
  file.duplicate_edges =
      static_cast<std::int64_t>(joined.end() - std::unique(joined.begin(), joined.end()));
}

GraphFile GraphParser::finish() && {
  if (vertices_.empty() && edges_.empty() && priors_.empty() && landmark_edges_.empty()) {
    throw DataError({path_}, "holds no VERTEX_SE2 and no EDGE_SE2 line" + first_skipped());
  }
  GraphFile file;
  file.has_poses = !vertices_.empty();
  if (!file.has_poses) add_missing_vertices();
  place_vertices(file);
  add_edges(file);
  for (const PriorLine& prior : priors_) {
    file.graph.priors.push_back(
        {NodeId{find(prior.id, prior.line, false)}, prior.map_T_node, prior.information});
  }
  for (const LandmarkLine& edge : landmark_edges_) {
    file.graph.landmark_edges.push_back({NodeId{find(edge.from, edge.line, false)},
                                         LandmarkId{find(edge.to, edge.line, true)}, edge.point,
                                         edge.information});
  }
  for (const auto& [id, line] : fixed_) {
    const NodeId node{find(id, line, false)};
    auto& fixed = file.graph.fixed;
    if (std::find(fixed.begin(), fixed.end(), node) == fixed.end()) fixed.push_back(node);
  }
  file.skipped_tags = std::move(skipped_tags_);
  return file;
}

std::string GraphParser::first_skipped() const {
  if (skipped_tags_.empty()) return "; is it a g2o file?";
  return ", only lines such as '" + skipped_tags_.begin()->first +
         "'; is it a 2D graph in g2o's or TORO's format?";
}

}  // namespace loopstone
