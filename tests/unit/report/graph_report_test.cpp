#include "loopstone/report/graph_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>

#include "loopstone/base/error.hpp"
#include "loopstone/report/graph_picture.hpp"
#include "support/manhattan_graph.hpp"

namespace loopstone {
namespace {

using testing::HasSubstr;

GraphRun example_run() {
  const test::SimulatedGraph world = test::manhattan_graph({.nodes = 200, .blocks = 2}, Rng(1));
  GraphFile file;
  file.graph = world.graph;
  file.has_poses = true;
  for (int i = 0; i < 200; ++i) file.ids.push_back(10 * i);
  GraphOptimisation found = optimize_graph(file.graph, {.certificate = CertificateOptions{}});
  GraphRun run = make_graph_run("city <1>.g2o", std::move(file), std::move(found));
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

TEST(GraphReport, TheSolutionIsShownBesideTheFilesOwnPosesOrOdometry) {
  const test::SimulatedGraph world = test::manhattan_graph({.nodes = 60, .blocks = 2}, Rng(2));
  GraphFile file;
  file.graph = world.graph;
  file.graph.poses.assign(60, Pose2{3.0, 4.0, 0.0});
  const GraphOptimisation found = optimize_graph(world.graph);
  for (const bool has_poses : {true, false}) {
    file.has_poses = has_poses;
    const GraphRun run = make_graph_run("a", file, found);
    EXPECT_EQ(run.before_name, has_poses ? "file" : "odometry");
    EXPECT_EQ(run.before[7].x == 3.0, has_poses);
    EXPECT_GT(run.before_cost, found.solved.cost);
    EXPECT_EQ(run.file.graph.poses[7].x, found.solved.poses[7].x);
  }
}

TEST(GraphReport, EdgesThatWereSetAsideAreListedAndRed) {
  GraphRun run = example_run();
  const std::size_t before = reds(draw_graph_run(run, 800));
  // The last closures, moved far away.
  int moved = 0;
  for (std::size_t i = run.file.graph.edges.size(); i-- > 0 && moved < 3;) {
    if (run.file.graph.edges[i].kind != EdgeKind::kLoopClosure) continue;
    run.file.graph.edges[i].to.index = 30 * moved;
    run.found.solved.edge_weights[i] = 0.01;
    ++moved;
  }
  EXPECT_EQ(edges_set_aside(run.found.solved), 3U);
  EXPECT_GT(reds(draw_graph_run(run, 800)), before + 20);
  EXPECT_THAT(graph_summary_line(run), HasSubstr("3 edges set aside"));
  EXPECT_THAT(format_graph_report(run, {}), HasSubstr("Set aside</h2>"));
  const std::string table = format_edge_weights(run);
  EXPECT_EQ(static_cast<std::size_t>(std::count(table.begin(), table.end(), '\n')),
            run.file.graph.edges.size() + 1);
  EXPECT_THAT(table, HasSubstr("loop_closure"));
  EXPECT_THAT(table, HasSubstr(",0.01\n"));
}

TEST(GraphReport, AProofOfAPartIsNotTakenForOneOfTheWhole) {
  GraphRun run = example_run();
  Certificate& certificate = run.found.certified->certificate;
  EXPECT_THAT(certificate_sentence(run), testing::Not(HasSubstr("set aside")));
  certificate.edges = 212;
  certificate.edges_set_aside = 88;
  certificate.closures_set_aside = 87;
  const std::string sentence = certificate_sentence(run);
  EXPECT_THAT(sentence, HasSubstr("certified in part"));
  EXPECT_THAT(sentence, HasSubstr("of the 212 edges that were kept"));
  EXPECT_THAT(sentence, HasSubstr("nothing is proven of the 88 edges set aside (87 of "));
  EXPECT_THAT(graph_summary_line(run), HasSubstr("212 edges that were kept certified to"));
  EXPECT_THAT(format_graph_report(run, {}), testing::Not(HasSubstr("class=\"good\"")));
}

TEST(GraphReport, WithoutAProofItSaysSo) {
  GraphRun run = example_run();
  run.found.certified->certificate.status = CertificateStatus::kNotOptimal;
  EXPECT_THAT(graph_summary_line(run), HasSubstr("NOT certified"));
  run.found.certified.reset();
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
