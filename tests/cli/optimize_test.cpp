#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/formats/g2o.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/formats/tum.hpp"
#include "run_program.hpp"
#include "support/manhattan_graph.hpp"
#include "support/temp_dir.hpp"

namespace loopstone::test {
namespace {

using testing::HasSubstr;
using Json = nlohmann::json;

/// A small city, its dead reckoning, and a ring that starts wound once too often.
class OptimizeCommand : public testing::Test {
 protected:
  OptimizeCommand() {
    const SimulatedGraph world = manhattan_graph({.nodes = 300, .blocks = 3}, Rng(1));
    graph_ = world.graph;
    write_g2o(city_, graph_);
    std::string edges = format_g2o(graph_);
    edges.erase(0, edges.find("EDGE_SE2"));
    bare_ = folder_.write("bare.g2o", edges);

    PoseGraph ring;
    for (int i = 0; i < 30; ++i) {
      Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
      information.diagonal() << 100.0, 100.0, 400.0;
      ring.edges.push_back({{i}, {(i + 1) % 30}, {1.0, 0.01 * (i % 3), kPi / 15.0}, information});
      ring.poses.push_back({0.0, 0.0, wrap_angle(2.0 * kPi / 15.0 * i)});
    }
    write_g2o(ring_, ring);
  }

  static Json optimize(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "optimize");
    arguments.emplace_back("--json");
    arguments.emplace_back("--quiet");
    const ProgramResult result = run_program(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.error;
    return result.exit_code == 0 ? Json::parse(result.out) : Json::object();
  }

  TempDir folder_;
  PoseGraph graph_;
  std::string city_ = folder_ / "city.g2o";
  std::string ring_ = folder_ / "ring.g2o";
  std::string bare_;
};

TEST_F(OptimizeCommand, GivesItsFiguresAsJson) {
  const Json json = optimize({city_, "--certify"});
  EXPECT_EQ(json.at("poses"), 300);
  EXPECT_EQ(json.at("edges"), graph_.edges.size());
  EXPECT_NEAR(json.at("cost_file").get<double>(), graph_cost(graph_), 1e-6 * graph_cost(graph_));
  EXPECT_GE(json.at("cost_initial").get<double>(), json.at("cost").get<double>());
  EXPECT_GT(json.at("cost").get<double>(), 0.0);
  EXPECT_EQ(json.at("status"), "converged");
  EXPECT_EQ(json.at("certified"), true);
  EXPECT_LT(std::abs(json.at("min_eigenvalue").get<double>()), 1e-6);
  EXPECT_LT(json.at("optimality_gap").get<double>(), 1e-6 * json.at("cost").get<double>());
  EXPECT_GT(json.at("iterations").get<int>(), 0);
  EXPECT_GT(json.at("wall_time_s").get<double>(), 0.0);
  EXPECT_EQ(json.at("certificate").at("status"), "certified");
  EXPECT_EQ(json.at("certificate").at("edges"), graph_.edges.size());
  EXPECT_EQ(json.at("certificate").at("edges_set_aside"), 0);
  EXPECT_EQ(json.at("certificate").at("whole_graph"), true);
  EXPECT_THAT(json.at("certificate").at("what").get<std::string>(), HasSubstr("isotropic"));
}

TEST_F(OptimizeCommand, EveryStartAndMethodEndsAtTheSameCost) {
  const double cost = optimize({city_, "--certify"}).at("cost").get<double>();
  for (const char* start : {"best", "file", "odometry", "spanning_tree", "chordal"}) {
    const Json json = optimize({city_, "--initial", start});
    EXPECT_NEAR(json.at("cost").get<double>(), cost, 1e-6 * cost) << start;
    EXPECT_EQ(json.at("certified"), false);
    EXPECT_EQ(json.at("min_eigenvalue"), nullptr);
    EXPECT_EQ(json.at("certificate").at("status"), "not_asked");
  }
  for (const char* method : {"gauss_newton", "levenberg_marquardt", "dogleg"}) {
    const Json json = optimize({city_, "--initial", "spanning_tree", "--method", method});
    EXPECT_NEAR(json.at("cost").get<double>(), cost, 1e-6 * cost) << method;
  }
  EXPECT_NEAR(optimize({bare_}).at("cost").get<double>(), cost, 1e-6 * cost);
}

TEST_F(OptimizeCommand, WritesEverythingThatIsAskedFor) {
  const std::string out = folder_ / "out.g2o";
  const std::string tum = folder_ / "out.tum";
  const std::string png = folder_ / "out.png";
  const std::string html = folder_ / "out.html";
  const std::string csv = folder_ / "out.csv";
  const Json json = optimize({city_, "-o", out, "--tum", tum, "--picture", png, "--report", html,
                              "--edges", csv, "--robust", "huber"});
  const GraphFile solved = read_g2o(out);
  EXPECT_NEAR(graph_cost(solved.graph), json.at("cost").get<double>(), 1e-9);
  EXPECT_EQ(solved.graph.edges.size(), graph_.edges.size());
  const Trajectory trajectory = read_tum(tum);
  ASSERT_EQ(trajectory.size(), 300u);
  EXPECT_EQ(trajectory.poses()[7].stamp, Stamp{7'000'000'000});
  EXPECT_NEAR(trajectory.poses()[7].pose.x, solved.graph.poses[7].x, 1e-8);
  EXPECT_GT(read_image(png).width, 1000);
  std::ifstream page(html);
  std::stringstream text;
  text << page.rdbuf();
  EXPECT_THAT(text.str(), HasSubstr("Edges that fit worst"));
  std::ifstream table(csv);
  std::string line;
  std::getline(table, line);
  EXPECT_EQ(line, "edge,kind,from,to,chi2,weight");
  std::size_t lines = 0;
  while (std::getline(table, line)) ++lines;
  EXPECT_EQ(lines, graph_.edges.size());
  // Solved again from its own solution, nothing moves.
  EXPECT_EQ(optimize({out, "--initial", "file"}).at("initial"), "file");
}

TEST_F(OptimizeCommand, LeavesALocalMinimumAndSaysSo) {
  const Json stuck =
      optimize({ring_, "--initial", "file", "--certify", "--set", "certificate.max_rank=1"});
  EXPECT_EQ(stuck.at("certified"), false);
  EXPECT_EQ(stuck.at("certificate").at("status"), "not_optimal");
  EXPECT_LT(stuck.at("min_eigenvalue").get<double>(), -1.0);
  EXPECT_GT(stuck.at("optimality_gap").get<double>(), 10.0);
  const Json free = optimize({ring_, "--initial", "file", "--certify"});
  EXPECT_EQ(free.at("certified"), true);
  EXPECT_GE(free.at("certificate").at("escapes").get<int>(), 1);
  EXPECT_LT(free.at("cost").get<double>(), 0.1 * stuck.at("cost").get<double>());
}

TEST_F(OptimizeCommand, DemandsAreMetOrExitWithThree) {
  EXPECT_EQ(run_program({"optimize", city_, "--certify", "--require", "certified", "--require",
                         "converged", "--require", "cost>=0"})
                .exit_code,
            0);
  const ProgramResult missed =
      run_program({"optimize", ring_, "--initial", "file", "--certify", "--set",
                   "certificate.max_rank=1", "--require", "certified", "--require", "cost<=0"});
  EXPECT_EQ(missed.exit_code, 3);
  EXPECT_THAT(missed.error, HasSubstr("it is not certified"));
  EXPECT_THAT(missed.error, HasSubstr("cost is"));
}

TEST_F(OptimizeCommand, ReadsToroAndTellsTheOrder) {
  const std::string toro = folder_.write(
      "a.graph",
      "VERTEX2 0 0 0 0\nVERTEX2 5 1 0 0\nEDGE2 5 0 -1 0 0 50 0 60 100 0 0\nEQUIV 0 5\n"
      "EDGE2 0 5 1.1 0 0 50 0 60 100 0 0\n");
  const ProgramResult result = run_program({"optimize", toro, "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("xx xy yy tt xt yt (TORO's order)"));
  EXPECT_THAT(result.error, HasSubstr("EQUIV"));
  const Json json = Json::parse(result.out);
  EXPECT_EQ(json.at("duplicate_edges"), 1);
  EXPECT_EQ(json.at("backward_edges"), 1);
  EXPECT_EQ(json.at("skipped_lines").at("EQUIV"), 1);
  EXPECT_NEAR(json.at("cost").get<double>(), 2.0 * 50.0 * 0.05 * 0.05, 1e-9);
}

TEST_F(OptimizeCommand, TableIsForPeople) {
  const ProgramResult result = run_program({"optimize", city_, "--certify"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  for (const char* text : {"city.g2o: 300 poses", "certified", "chordal (the cheapest)", " ms"}) {
    EXPECT_THAT(result.out, HasSubstr(text));
  }
}

TEST_F(OptimizeCommand, BadInputIsOneLineThatSaysWhatToDo) {
  const auto expect = [&](std::vector<std::string> arguments, int code, const char* text) {
    arguments.insert(arguments.begin(), "optimize");
    const ProgramResult result = run_program(arguments);
    EXPECT_EQ(result.exit_code, code) << result.error;
    EXPECT_THAT(result.error, HasSubstr(text));
    EXPECT_EQ(count_lines(result.error), 1u) << result.error;
    EXPECT_EQ(result.out, "");
  };
  const auto file = [&](const char* name, const std::string& text) {
    return folder_.write(name, text);
  };
  const std::string edge = "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n";
  expect({folder_ / "none.g2o"}, 1, "none.g2o");
  expect({file("empty.g2o", "")}, 1, "holds no VERTEX_SE2");
  expect({file("parts.g2o", edge + "EDGE_SE2 7 8 1 0 0 1 0 0 1 0 1\n")}, 1,
         "2 parts that nothing connects: 0, 1 (2 poses); 7, 8 (2 poses)");
  expect({file("missing.g2o", "VERTEX_SE2 0 0 0 0\n" + edge)}, 1,
         "missing.g2o:2: vertex 1 has no VERTEX_SE2 line");
  expect({file("indefinite.g2o", "EDGE_SE2 0 1 1 0 0 1 2 0 1 0 1\n")}, 1,
         "indefinite.g2o:1: the information matrix");
  expect({file("asymmetric.g2o", "EDGE_SE2 0 1 1 0 0 1 0 0.5 0 1 0 0 0 1\n")}, 1,
         "asymmetric.g2o:1: the information matrix (nine numbers) is not symmetric");
  expect({bare_, "--initial", "file"}, 2, "the file has no VERTEX lines");
  expect({bare_, "--initial", "magic"}, 2, "magic");
  expect({bare_, "--robust", "magic"}, 2, "magic");
  expect({bare_, "--picture", "a.jpg"}, 2, "must end in .png");
  expect({bare_, "--picture", "a.png", "-o", "a.png"}, 2, "is named for two outputs");
  expect({bare_, "--require", "certified"}, 2, "needs --certify");
  expect({bare_, "--require", "certain"}, 2, "must read like");
  expect({bare_, "--set", "solver.max_iteration=3"}, 2, "max_iterations");
  expect({bare_, "-o", folder_ / "none/out.g2o"}, 1, "none/out.g2o");
}

TEST_F(OptimizeCommand, ACertificateOfAPartSaysHowManyEdgesItIsNotOf) {
  // A ring of true closures over odometry that bends: DCS believes none of them.
  PoseGraph chain;
  Eigen::Matrix3d tight = Eigen::Vector3d(1e6, 1e6, 1e8).asDiagonal();
  for (int i = 0; i < 90; ++i)
    chain.edges.push_back({{i}, {i + 1}, {1.0, 0.0, 0.2}, tight, EdgeKind::kOdometry});
  for (int i = 0; i + 20 <= 90; ++i) {
    chain.edges.push_back({{i},
                           {i + 20},
                           {20.0, 0.0, 0.0},
                           Eigen::Matrix3d::Identity() * 1e4,
                           EdgeKind::kLoopClosure});
  }
  chain.poses.resize(91);
  for (std::size_t i = 0; i < 90; ++i) chain.poses[i + 1] = chain.poses[i] * Pose2{1.0, 0.0, 0.2};
  const std::string path = folder_ / "chain.g2o";
  write_g2o(path, chain);
  const Json json = optimize({path, "--robust", "dcs", "--initial", "odometry", "--certify"});
  const Json& certificate = json.at("certificate");
  EXPECT_EQ(certificate.at("whole_graph"), false);
  EXPECT_EQ(certificate.at("edges_set_aside"), json.at("edges_set_aside"));
  EXPECT_GE(certificate.at("loop_closures_set_aside").get<int>(), 60);
  EXPECT_THAT(certificate.at("what").get<std::string>(), HasSubstr("edges that were kept"));
  const ProgramResult text =
      run_program({"optimize", path, "--robust", "dcs", "--initial", "odometry", "--certify"});
  EXPECT_THAT(text.out, HasSubstr("nothing is proven of the"));
  EXPECT_THAT(text.out, HasSubstr("nor that setting them aside was right"));
}

}  // namespace
}  // namespace loopstone::test
