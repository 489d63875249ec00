#include "loopstone/report/graph_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <string>

#include "loopstone/base/error.hpp"
#include "loopstone/report/graph_picture.hpp"
#include "support/manhattan_graph.hpp"

namespace loopstone {
namespace {

using testing::HasSubstr;

GraphRun example_run() {
  const test::SimulatedGraph world = test::manhattan_graph({.nodes = 200, .blocks = 2}, Rng(1));
  GraphRun run;
  run.name = "city <1>.g2o";
  run.file.graph = world.graph;
  for (int i = 0; i < 200; ++i) run.file.ids.push_back(10 * i);
  run.before = world.graph.poses;
  run.before_name = "odometry";
  run.before_cost = graph_cost(world.graph);
  run.file.graph.poses = world.truth;
  run.solve = optimize(run.file.graph);
  run.file.graph.poses = run.solve.poses;
  run.certified = optimize_certified(run.file.graph);
  run.certified_edges = world.graph.edges.size();
  return run;
}

std::size_t reds(const Image& image) {
  std::size_t count = 0;
  for (std::size_t i = 0; i + 2 < image.bytes.size(); i += 3) {
    if (image.bytes[i] > 200 && image.bytes[i + 1] < 60 && image.bytes[i + 2] < 60) ++count;
  }
  return count;
}

TEST(GraphReport, LineAndPageSayWhatWasFoundAndProven) {
  const GraphRun run = example_run();
  const std::string line = graph_summary_line(run);
  EXPECT_THAT(line, HasSubstr("city <1>.g2o: 200 poses"));
  EXPECT_THAT(line, HasSubstr("certified to"));
  EXPECT_THAT(certificate_sentence(run), HasSubstr("isotropic optimum"));
  RunInfo info;
  info.log_path = "city <1>.g2o";
  const std::string page = format_graph_report(run, info);
  EXPECT_THAT(page, HasSubstr("city &lt;1&gt;.g2o"));
  EXPECT_THAT(page, HasSubstr("Edges that fit worst"));
  EXPECT_THAT(page, HasSubstr("data:image/png;base64,"));
  EXPECT_THAT(page, testing::Not(HasSubstr("Set aside</h2>")));
}

TEST(GraphReport, EdgesThatWereSetAsideAreListedAndRed) {
  GraphRun run = example_run();
  const std::size_t before = reds(draw_graph_run(run, 800));
  // The last closures, moved far away.
  int moved = 0;
  for (std::size_t i = run.file.graph.edges.size(); i-- > 0 && moved < 3;) {
    if (run.file.graph.edges[i].kind != EdgeKind::kLoopClosure) continue;
    run.file.graph.edges[i].to.index = 30 * moved;
    run.solve.edge_weights[i] = 0.01;
    ++moved;
  }
  EXPECT_EQ(edges_set_aside(run), 3U);
  EXPECT_GT(reds(draw_graph_run(run, 800)), before + 20);
  EXPECT_THAT(graph_summary_line(run), HasSubstr("3 edges set aside"));
  EXPECT_THAT(format_graph_report(run, {}), HasSubstr("Set aside</h2>"));
  const std::string table = format_edge_weights(run);
  EXPECT_EQ(static_cast<std::size_t>(std::count(table.begin(), table.end(), '\n')),
            run.file.graph.edges.size() + 1);
  EXPECT_THAT(table, HasSubstr("loop_closure"));
  EXPECT_THAT(table, HasSubstr(",0.01\n"));
}

TEST(GraphReport, WithoutAProofItSaysSo) {
  GraphRun run = example_run();
  run.certified->certificate.status = CertificateStatus::kNotOptimal;
  EXPECT_THAT(graph_summary_line(run), HasSubstr("NOT certified"));
  run.certified.reset();
  EXPECT_THAT(certificate_sentence(run), HasSubstr("not certified"));
}

TEST(GraphPicture, IsTheSameEveryTimeAndShowsLargeAndSmall) {
  const GraphRun run = example_run();
  const Image first = draw_graph_run(run, 300);
  EXPECT_EQ(first.bytes, draw_graph_run(run, 300).bytes);
  EXPECT_GT(first.width, 600);
  PoseGraph point;
  point.poses.resize(1);
  GraphScene scene;
  scene.graph = &point;
  scene.before = {{1e6, -1e6, 0.0}};
  EXPECT_GT(draw_graph_picture(scene, {.panel_px = 200}).width, 300);
}

TEST(GraphPicture, RefusesWhatCannotBeDrawn) {
  const PoseGraph empty;
  GraphScene scene;
  scene.graph = &empty;
  EXPECT_THROW((void)draw_graph_picture(scene), UsageError);
  PoseGraph two;
  two.poses.resize(2);
  scene.graph = &two;
  EXPECT_THROW((void)draw_graph_picture(scene), UsageError);
}

}  // namespace
}  // namespace loopstone
