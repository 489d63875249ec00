#include "loopstone/formats/g2o.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"
#include "source_folder.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

std::string error_of(std::string_view text) {
  try {
    (void)parse_g2o(text, "g.g2o");
  } catch (const DataError& error) {
    return error.what();
  }
  return "no error";
}

PoseGraph random_graph(std::uint64_t seed) {
  Rng rng(seed);
  PoseGraph graph;
  for (int i = 0; i < 40; ++i)
    graph.poses.push_back({rng.normal(), 1e3 * rng.normal(), rng.uniform(-kPi, kPi)});
  for (int i = 0; i < 80; ++i) {
    const int from = static_cast<int>(rng.below(40));
    const int to = (from + 1 + static_cast<int>(rng.below(39))) % 40;
    Eigen::Matrix3d root;
    for (int k = 0; k < 9; ++k) root(k / 3, k % 3) = rng.normal();
    Eigen::Matrix3d information = root * root.transpose() + 0.1 * Eigen::Matrix3d::Identity();
    for (int k = 0; k < 3; ++k) information(k, (k + 1) % 3) = information((k + 1) % 3, k);
    graph.edges.push_back({NodeId{from},
                           NodeId{to},
                           {rng.normal(), rng.normal(), rng.uniform(-kPi, kPi)},
                           information,
                           EdgeKind::kMatch});
  }
  return graph;
}

TEST(G2o, RoundTripToTheLastBit) {
  const PoseGraph graph = random_graph(1);
  const std::string text = format_g2o(graph);
  const GraphFile file = parse_g2o(text);
  EXPECT_TRUE(file.has_poses);
  EXPECT_EQ(file.graph.poses, graph.poses);
  ASSERT_EQ(file.graph.edges.size(), graph.edges.size());
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    EXPECT_EQ(file.graph.edges[i].from, graph.edges[i].from);
    EXPECT_EQ(file.graph.edges[i].to, graph.edges[i].to);
    EXPECT_EQ(file.graph.edges[i].from_T_to, graph.edges[i].from_T_to);
    EXPECT_EQ(file.graph.edges[i].information, graph.edges[i].information);
  }
  EXPECT_EQ(format_g2o(file), text);
  EXPECT_EQ(graph_cost(file.graph), graph_cost(graph));
}

TEST(G2o, KeepsIdsAndFixedAndCountsTheRest) {
  const GraphFile file = parse_g2o(
      "# a comment\nPARAMS_SE2OFFSET 0 0 0 0\nVERTEX_SE2 900 1 2 3\r\nVERTEX_SE2 17 0 0 4\n\nFIX "
      "17\n"
      "EDGE_SE2 900 17 1 0 0.5 1 0 0 2 0 3\nEQUIV 5 1\nEQUIV 6 1\nFIX 17 900\n");
  EXPECT_EQ(file.ids, (std::vector<std::int64_t>{17, 900}));
  EXPECT_EQ(file.graph.fixed, (std::vector<NodeId>{{0}, {1}}));
  EXPECT_NEAR(file.graph.poses[0].yaw, 4.0 - 2.0 * kPi, 1e-15);
  EXPECT_EQ(file.graph.edges[0].from.index, 1);
  EXPECT_EQ(file.graph.edges[0].kind, EdgeKind::kLoopClosure);
  EXPECT_EQ(file.graph.edges[0].information(1, 1), 2.0);
  EXPECT_EQ(file.skipped_tags.at("EQUIV"), 2);
  EXPECT_EQ(file.skipped_tags.at("PARAMS_SE2OFFSET"), 1);
  EXPECT_EQ(file.backward_edges, 1);
  EXPECT_EQ(file.duplicate_edges, 0);
  const GraphFile again = parse_g2o(format_g2o(file));
  EXPECT_EQ(again.ids, file.ids);
  EXPECT_EQ(again.graph.fixed, file.graph.fixed);
}

TEST(G2o, LandmarksAndPriorsRoundTrip) {
  const std::string text =
      "VERTEX_SE2 1 0 0 0\nVERTEX_SE2 4 1 0 0.1\nVERTEX_XY 2 3 4\nVERTEX_XY 9 -1 0.5\n"
      "FIX 1\n"
      "EDGE_SE2_PRIOR 4 1 0.1 0.2 5 0.1 0.2 6 0.3 7\n"
      "EDGE_SE2 1 4 1 0 0.1 10 0 0 11 0 12\n"
      "EDGE_SE2_XY 4 9 -2 0.5 3 0.5 4\nEDGE_SE2_XY 1 2 3 4 1 0 1\n";
  const GraphFile file = parse_g2o(text);
  EXPECT_EQ(file.landmark_ids, (std::vector<std::int64_t>{2, 9}));
  ASSERT_EQ(file.graph.landmarks.size(), 2U);
  EXPECT_EQ(file.graph.landmarks[1], Eigen::Vector2d(-1.0, 0.5));
  ASSERT_EQ(file.graph.landmark_edges.size(), 2U);
  EXPECT_EQ(file.graph.landmark_edges[0].from.index, 1);
  EXPECT_EQ(file.graph.landmark_edges[0].landmark.index, 1);
  EXPECT_EQ(file.graph.landmark_edges[0].information(1, 0), 0.5);
  ASSERT_EQ(file.graph.priors.size(), 1U);
  EXPECT_EQ(file.graph.priors[0].map_T_node, (Pose2{1.0, 0.1, 0.2}));
  EXPECT_EQ(file.graph.priors[0].information(1, 2), 0.3);
  EXPECT_TRUE(file.skipped_tags.empty());
  EXPECT_EQ(format_g2o(file), text);
  EXPECT_NO_THROW(check_graph(file.graph));
}

TEST(G2o, NineNumbersAreAWholeMatrix) {
  const std::string edge = "EDGE_SE2 0 1 1 0 0 ";
  const GraphFile file = parse_g2o(edge + "1 0.1 0.2 0.1 2 0.3 0.2 0.3 3\n");
  EXPECT_EQ(file.graph.edges[0].information,
            parse_g2o(edge + "1 0.1 0.2 2 0.3 3\n").graph.edges[0].information);
  EXPECT_NE(error_of(edge + "1 0.1 0.2 -0.1 2 0.3 0.2 0.3 3\n")
                .find("g.g2o:1: the information matrix (nine numbers) is not symmetric"),
            std::string::npos);
}

TEST(G2o, CountsDuplicatesAndKeepsThem) {
  const GraphFile file = parse_g2o(
      "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 1 0 -1 0 0 1 0 0 1 0 1\n"
      "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\n");
  EXPECT_EQ(file.graph.edges.size(), 4U);
  EXPECT_EQ(file.duplicate_edges, 2);
  EXPECT_EQ(file.backward_edges, 1);
}

Eigen::Matrix3d edge2_information(const std::string& numbers, std::string& note) {
  const GraphFile file =
      parse_g2o("VERTEX2 0 0 0 0\nVERTEX2 1 1 0 0\nEDGE2 0 1 1 0 0 " + numbers + "\n");
  note = file.notes.empty() ? "" : file.notes.front();
  return file.graph.edges.front().information;
}

Eigen::Matrix3d symmetric(double xx, double xy, double xt, double yy, double yt, double tt) {
  Eigen::Matrix3d m;
  m << xx, xy, xt, xy, yy, yt, xt, yt, tt;
  return m;
}

TEST(Toro, OrderOfTheInformationIsToldByDefiniteness) {
  std::string note;
  // A zero where the other order has a diagonal entry.
  EXPECT_EQ(edge2_information("50 1 60 100 0 0", note), symmetric(50, 1, 0, 60, 0, 100));
  EXPECT_NE(note.find("TORO's order): in the other order"), std::string::npos) << note;
  EXPECT_EQ(edge2_information("50 1 0 60 0 100", note), symmetric(50, 1, 0, 60, 0, 100));
  EXPECT_NE(note.find("g2o's order): in the other order"), std::string::npos) << note;
  // Without zeros: xx xy yy tt xt yt.
  EXPECT_EQ(edge2_information("50 1 60 100 2 -3", note), symmetric(50, 1, 2, 60, -3, 100));
}

TEST(Toro, WhatTheNumbersLeaveOpenIsTheTagsOwnOrder) {
  std::string note;
  EXPECT_EQ(edge2_information("50 1 2 60 3 100", note), symmetric(50, 1, 2, 60, 3, 100));
  EXPECT_EQ(edge2_information("50 1 40 60 3 45", note), symmetric(50, 1, 3, 40, 45, 60));
  EXPECT_NE(note.find("nothing in the numbers tells"), std::string::npos) << note;
  const std::string text = "EDGE2 0 1 1 0 0 50 1 40 60 3 45\n";
  EXPECT_EQ(parse_g2o(text, "t", InformationOrder::kG2o).graph.edges[0].information,
            symmetric(50, 1, 40, 60, 3, 45));
}

TEST(Toro, OneOrderHoldsForTheWholeFile) {
  const GraphFile file =
      parse_g2o("EDGE2 0 1 1 0 0 50 1 40 60 3 45\nEDGE2 1 2 1 0 0 50 0 0 60 0 100\n");
  EXPECT_EQ(file.graph.edges[0].information, symmetric(50, 1, 40, 60, 3, 45));
  const auto neither =
      error_of("EDGE2 0 1 1 0 0 50 0 0 60 0 100\nEDGE2 1 2 1 0 0 50 0 60 100 0 0\n");
  EXPECT_NE(neither.find("g.g2o:1: the information matrix (xx xy yy tt xt yt)"), std::string::npos)
      << neither;
}

TEST(RequireConnected, NamesTheParts) {
  const std::string one = "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n";
  const std::string two =
      one + "EDGE_SE2 20 30 1 0 0 1 0 0 1 0 1\nEDGE_SE2 30 21 1 0 0 1 0 0 1 0 1\n";
  EXPECT_NO_THROW(require_connected(parse_g2o(one), "g"));
  try {
    require_connected(parse_g2o(two), "g");
    FAIL();
  } catch (const DataError& error) {
    EXPECT_STREQ(
        error.what(),
        "g: falls into 2 parts that nothing connects: 0, 1 (2 poses); 20, 21, 30 (3 poses)");
  }
  // Each part held: every pose has its place.
  EXPECT_NO_THROW(require_connected(parse_g2o(two + "FIX 0 30\n"), "g"));
  EXPECT_THROW(require_connected(parse_g2o(two + "FIX 0\n"), "g"), DataError);
  // A landmark that both see joins them.
  EXPECT_NO_THROW(require_connected(
      parse_g2o(two + "EDGE_SE2_XY 0 5 1 1 1 0 1\nEDGE_SE2_XY 21 5 1 1 1 0 1\n"), "g"));
}

TEST(G2o, WithoutVerticesPosesAreZeroAndFlagged) {
  const GraphFile file =
      parse_g2o("EDGE_SE2 3 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\n");
  EXPECT_FALSE(file.has_poses);
  EXPECT_EQ(file.ids, (std::vector<std::int64_t>{1, 2, 3}));
  EXPECT_EQ(file.graph.poses, std::vector<Pose2>(3));
  EXPECT_EQ(file.graph.edges[1].kind, EdgeKind::kOdometry);
}

TEST(G2o, DamageIsNamedWithItsLine) {
  const std::string two = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\n";
  const auto has = [](const std::string& error, const char* part) {
    EXPECT_NE(error.find(part), std::string::npos) << error;
  };
  has(error_of(""), "g.g2o: holds no VERTEX_SE2");
  has(error_of("EDGE3 0 1 1 0 0 1 0 1 1 0 0\n"), "'EDGE3'");
  has(error_of(two + "VERTEX_SE2 1 1 0 0\n"), "g.g2o:3: vertex 1 is there twice");
  has(error_of(two + "VERTEX_SE2 x 1 0 0\n"), "g.g2o:3: a vertex id");
  has(error_of(two + "VERTEX_SE2 -1 1 0 0\n"), "g.g2o:3: a vertex id");
  has(error_of(two + "VERTEX_SE2 2 nan 0 0\n"), "not finite");
  has(error_of(two + "VERTEX_SE2 2 0 0\n"),
      "g.g2o:3: expected 'VERTEX_SE2 id x y theta' (4 numbers), found 3");
  has(error_of(two + "EDGE_SE2 0 1 1 0 0 1 0 0 1 0\n"), "g.g2o:3: expected 'EDGE_SE2");
  has(error_of(two + "EDGE_SE2 0 0 1 0 0 1 0 0 1 0 1\n"),
      "g.g2o:3: the edge joins vertex 0 to itself");
  has(error_of(two + "EDGE_SE2 0 7 1 0 0 1 0 0 1 0 1\n"), "g.g2o:3: vertex 7 has no VERTEX_SE2");
  has(error_of(two + "FIX 9\n"), "g.g2o:3: vertex 9");
  has(error_of(two + "VERTEX_XY 1 0 0\n"), "g.g2o:3: vertex 1 is there twice");
  has(error_of(two + "VERTEX_XY 2 0 0\nFIX 2\n"), "g.g2o:4: vertex 2 is a landmark");
  has(error_of(two + "EDGE_SE2_XY 0 1 1 1 1 0 1\n"), "g.g2o:3: vertex 1 is a pose");
  has(error_of(two + "EDGE_SE2_XY 0 5 1 1 1 0 1\n"), "g.g2o:3: vertex 5 has no VERTEX_XY");
  has(error_of(two + "VERTEX_XY 5 0 0\nEDGE_SE2_XY 0 5 1 1 1 2 1\n"),
      "g.g2o:4: the information matrix (I11 I12 I22)");
  has(error_of(two + "EDGE_SE2_PRIOR 0 1 1 1 1 0 0 1 0 0\n"), "g.g2o:3: the information matrix");
  has(error_of(two + "EDGE_SE2_PRIOR 0 1 1 1 1 0 0 1 0\n"), "g.g2o:3: expected 'EDGE_SE2_PRIOR");
  has(error_of(two + "EDGE2 0 1 1 0 0 1 0 0 1 0\n"), "g.g2o:3: expected 'EDGE2");
  for (const char* bad :
       {"0 0 0 1 0 1", "1 2 0 1 0 1", "1 0 0 1 0 -1", "-1 0 0 -1 0 -1", "1 0 1 1 0 1"}) {
    has(error_of(two + "EDGE_SE2 0 1 1 0 0 " + bad + "\n"), "g.g2o:3: the information matrix");
  }
}

TEST(G2o, FileRoundTripAndUnwritableFolder) {
  const test::TempDir dir;
  const PoseGraph graph = random_graph(2);
  write_g2o(dir / "a.g2o", graph);
  EXPECT_EQ(read_g2o(dir / "a.g2o").graph.poses, graph.poses);
  EXPECT_THROW(write_g2o(dir / "none/a.g2o", graph), DataError);
}

TEST(G2o, ReadsThePublishedGraphs) {
  const char* root = std::getenv("LOOPSTONE_DATA");
  const std::filesystem::path graphs =
      std::filesystem::path(root != nullptr ? root : LOOPSTONE_SOURCE_DIR "/../shared/data") /
      "graphs";
  if (!std::filesystem::exists(graphs)) GTEST_SKIP() << "no recorded data at " << graphs;
  int read = 0;
  for (const auto& entry : std::filesystem::directory_iterator(graphs)) {
    if (entry.path().extension() != ".g2o") continue;
    const GraphFile file = read_g2o(entry.path().string());
    EXPECT_GT(file.graph.edges.size(), 100U) << entry.path();
    EXPECT_EQ(file.has_poses, entry.path().stem() != "manhattan") << entry.path();
    ++read;
  }
  EXPECT_GE(read, 4);
}

}  // namespace
}  // namespace loopstone
