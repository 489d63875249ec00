#include "loopstone/report/map_outputs.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "html_check.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/g2o.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "loopstone/formats/tum.hpp"
#include "loopstone/report/map_picture.hpp"
#include "loopstone/report/peak_memory.hpp"
#include "report/decisions.hpp"
#include "report/output_files.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

using test::TempDir;

/// A robot drives once around in a square room.
MapResult small_result() {
  MapResult result;
  LaserScan scan;
  scan.angle_min_rad = -kPi;
  scan.angle_increment_rad = kPi / 180.0;
  scan.range_max_m = 20.0;
  scan.ranges_m.assign(360, 3.0F);
  std::vector<PosedScan> posed;
  Pose2 pose{5.0, -3.0, 0.0};
  for (int i = 0; i < 120; ++i) {
    result.trajectory.append(Stamp{1500000000000000000 + i * 100000000LL}, pose);
    result.odometry.append(Stamp{1500000000000000000 + i * 100000000LL},
                           pose * Pose2{0.0, 0.001 * i, 0.0});
    posed.push_back({&scan, pose, pose, pose});
    if (i % 20 == 0) {
      result.graph.poses.push_back(pose);
      result.node_stamps.push_back(result.trajectory.back().stamp);
    }
    pose = pose * exp(Tangent2(0.05, 0.0, 2.0 * kPi / 120));
  }
  result.map = build_occupancy_map(posed, 0.25);
  for (int i = 1; i < 6; ++i)
    result.graph.edges.push_back({NodeId{i - 1}, NodeId{i}, Pose2{1.0, 0.0, 1.0}});
  LoopClosure accepted{.from = NodeId{0}, .to = NodeId{5}, .score = 0.81, .second_score = 0.4};
  accepted.state = ClosureState::kStanding;
  LoopClosure rejected{.from = NodeId{1}, .to = NodeId{4}, .score = 0.5, .second_score = 0.49};
  rejected.reason = ClosureReason::kAmbiguousPose;
  result.loop_closures = {accepted, rejected};
  result.statistics.scans = 120;
  result.statistics.key_scans = 6;
  result.statistics.loop_closures_accepted = 1;
  result.statistics.loop_closures_rejected = 1;
  result.statistics.path_length_m = result.trajectory.path_length_m();
  result.statistics.duration_s = 11.9;
  result.statistics.graph_cost = 1.5;
  result.warnings = {"stamps <went> back & forth"};
  return result;
}

RunInfo small_info() {
  RunInfo info;
  info.log_path = "/logs/a&b.clf";
  info.command_line = "loopstone map a&b.clf -o out";
  info.options_toml = "[map]\nresolution_m = 0.05  # <m>\n";
  info.version = "9.8.7";
  info.wall_time_s = 0.5;
  info.cpu_time_s = 0.75;
  info.peak_memory_bytes = 123'456'789'012;  // more than any test takes
  info.left_out.skipped = {.records = 4, .scans = 1};
  info.left_out.scans_read = 3;
  return info;
}

const std::vector<std::string> kFiles{"decisions.toml", "graph.g2o",     "loop_closures.csv",
                                      "map.pgm",        "map.png",       "map.yaml",
                                      "odometry.tum",   "options.toml",  "report.html",
                                      "summary.json",   "trajectory.tum"};

TEST(MapOutputs, EveryFileIsThereAndReadsBack) {
  const TempDir dir;
  const MapResult result = small_result();
  write_map_outputs(result, small_info(), dir / "out");
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(dir / "out"))
    names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names, kFiles);

  const Trajectory trajectory = read_tum(dir / "out/trajectory.tum");
  ASSERT_EQ(trajectory.size(), 120U);
  EXPECT_EQ(trajectory.back().stamp, result.trajectory.back().stamp);
  EXPECT_EQ(read_tum(dir / "out/odometry.tum").size(), 120U);
  EXPECT_EQ(read_g2o(dir / "out/graph.g2o").graph.poses, result.graph.poses);
  EXPECT_EQ(read_ros_map(dir / "out/map.yaml").cells(), cell_states(result.map).cells());
  EXPECT_EQ(read_image(dir / "out/map.png").channels, 3);
  EXPECT_EQ(dir.read("out/options.toml"), small_info().options_toml);
  EXPECT_EQ(dir.read("out/decisions.toml"), format_decisions(decision_numbers()));
}

TEST(MapOutputs, EveryClosureIsListedWithItsEvidence) {
  const TempDir dir;
  MapResult result = small_result();
  result.loop_closures[0].from_T_to = {1.5, -2.0, 0.25};
  result.loop_closures[0].covariance(0, 1) = 0.125;
  write_map_outputs(result, small_info(), dir / "out");
  EXPECT_EQ(dir.read("out/loop_closures.csv"),
            "from_t_s,to_t_s,from_node,to_node,from_submap,to_submap,x_m,y_m,yaw_rad,"
            "xx_m2,xy_m2,xyaw_m_rad,yy_m2,yyaw_m_rad,yawyaw_rad2,"
            "score,second_score,overlap,agreement,chi2,by_appearance,accepted,state,reason\n"
            "1500000000.000000000,1500000010.000000000,0,5,0,0,1.5,-2,0.25,0,0.125,0,0,0,0,"
            "0.81,0.4,0,0,,0,1,standing,\n"
            "1500000002.000000000,1500000008.000000000,1,4,0,0,0,0,0,0,0,0,0,0,0,"
            "0.5,0.49,0,0,,0,0,rejected,ambiguous: another pose scores nearly as well\n");
}

TEST(MapOutputs, SummaryHasEveryKeyOfTheContract) {
  const auto summary = nlohmann::json::parse(format_summary(small_result(), small_info()));
  for (const char* key : {"scans",
                          "key_scans",
                          "key_scans_thinned",
                          "submaps",
                          "loop_closures_accepted",
                          "loop_closures_rejected",
                          "path_length_m",
                          "duration_s",
                          "wall_time_s",
                          "cpu_time_s",
                          "realtime_factor",
                          "scans_per_s",
                          "peak_memory_bytes",
                          "map_area_m2",
                          "records_skipped",
                          "graph_cost",
                          "version",
                          "scans_dropped",
                          "searches",
                          "degenerate_travel_m"}) {
    EXPECT_TRUE(summary.contains(key)) << key;
  }
  EXPECT_EQ(summary["scans"], 120);
  EXPECT_EQ(summary["version"], "9.8.7");
  EXPECT_EQ(summary["records_skipped"], 4);
  EXPECT_EQ(summary["left_out"]["scan_share"], 0.25);
  EXPECT_DOUBLE_EQ(summary["realtime_factor"], 11.9 / 0.5);
  EXPECT_DOUBLE_EQ(summary["scans_per_s"], 240.0);
  EXPECT_NEAR(summary["map_area_m2"], kPi * 4.0 * 4.0, 4.0)
      << "a disc of 3 m swept around a circle of 1 m radius";
}

TEST(MapOutputs, SummarySurvivesStrangeValues) {
  MapResult result = small_result();
  result.statistics.graph_cost = std::numeric_limits<double>::quiet_NaN();
  RunInfo info = small_info();
  info.log_path = "bad\xFFname";
  info.wall_time_s = 0.0;
  const auto summary = nlohmann::json::parse(format_summary(result, info));
  EXPECT_TRUE(summary["graph_cost"].is_null());
  EXPECT_EQ(summary["realtime_factor"], 0.0);
}

TEST(MapOutputs, ReportNeedsNothingElse) {
  const TempDir dir;
  write_map_outputs(small_result(), small_info(), dir / "out");
  const std::string html = dir.read("out/report.html");
  EXPECT_NE(html.find("data:image/png;base64,iVBORw0KGgo"), std::string::npos);
  EXPECT_NE(html.find("a&amp;b.clf"), std::string::npos);
  EXPECT_NE(html.find("stamps &lt;went&gt; back &amp; forth"), std::string::npos);
  EXPECT_NE(html.find("ambiguous: another pose scores nearly as well"), std::string::npos);
  EXPECT_NE(html.find("# &lt;m&gt;"), std::string::npos);
  test::expect_self_contained(html);
}

TEST(MapOutputs, IncompleteRunSaysSo) {
  const TempDir dir;
  MapResult result = small_result();
  result.complete = false;
  write_map_outputs(result, small_info(), dir / "out");
  EXPECT_NE(dir.read("out/report.html").find("Incomplete"), std::string::npos);
  EXPECT_FALSE(nlohmann::json::parse(dir.read("out/summary.json"))["complete"]);
}

TEST(MapOutputs, PeakMemoryIsThatOfThePicturesTooWhereTheCallerTellsIt) {
  const TempDir dir;
  RunInfo info = small_info();
  const auto written = [&](const std::string& name) {
    write_map_outputs(small_result(), info, dir / name);
    const auto summary = nlohmann::json::parse(dir.read(name + "/summary.json"));
    return summary["peak_memory_bytes"].get<std::int64_t>();
  };
  info.peak_memory_bytes = 1;
  const std::int64_t raised = written("raised");
  EXPECT_GT(raised, 1 << 20);
  EXPECT_LE(raised, peak_memory_bytes() + (1 << 20));
  info.peak_memory_bytes = 0;
  EXPECT_EQ(written("untold"), 0) << "a library's caller may be a program of many runs";
}

TEST(MapOutputs, SameResultSameBytes) {
  const TempDir dir;
  write_map_outputs(small_result(), small_info(), dir / "a");
  write_map_outputs(small_result(), small_info(), dir / "b");
  for (const std::string& name : kFiles)
    EXPECT_EQ(dir.read("a/" + name), dir.read("b/" + name)) << name;
}

TEST(MapOutputs, ResultWithoutAnyScanIsWritten) {
  const TempDir dir;
  write_map_outputs(MapResult{}, RunInfo{}, dir / "out");
  EXPECT_EQ(read_ros_map(dir / "out/map.yaml").cells(), std::vector<std::int8_t>{kUnknownCell});
}

TEST(MapOutputs, FolderMustBeEmptyOrForced) {
  const TempDir dir;
  RunInfo info = small_info();
  std::filesystem::create_directory(dir / "out");
  dir.write("out/precious.txt", "x");
  EXPECT_THROW(write_map_outputs(small_result(), info, dir / "out"), UsageError);
  info.force = true;
  write_map_outputs(small_result(), info, dir / "out");
  write_map_outputs(small_result(), info, dir / "out");
  EXPECT_EQ(dir.read("out/precious.txt"), "x");
  EXPECT_THROW(write_map_outputs(small_result(), info, dir / "out/precious.txt"), UsageError);
  EXPECT_THROW(write_map_outputs(small_result(), info, dir / "out/precious.txt/deeper"), DataError);
}

TEST(MapOutputs, FullDiskLeavesNothing) {
  const TempDir dir;
  // A limit on the size of files stands in for the disk; the small files fit, the map does not.
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit small = before;
  small.rlim_cur = 8000;
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  EXPECT_THROW(write_map_outputs(small_result(), small_info(), dir / "out"), DataError);
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, old_handler);
  EXPECT_TRUE(dir.names().empty()) << "neither files nor the folder stay";
}

TEST(MapOutputs, WhereOnlyTheMapDoesNotFitTrajectoryAndGraphAreLeft) {
  const TempDir dir;
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit small = before;
  // The page with its pictures takes more than this.
  small.rlim_cur = format_decisions(decision_numbers()).size() + 2000;
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  EXPECT_THROW(write_map_outputs(small_result(), small_info(), dir / "out"), std::runtime_error);
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, old_handler);
  EXPECT_EQ(read_tum(dir / "out/trajectory.tum").size(), 120u);
  EXPECT_EQ(read_g2o(dir / "out/graph.g2o").graph.poses.size(), 6u);
  EXPECT_FALSE(std::filesystem::exists(dir / "out/report.html"));
  EXPECT_EQ(nlohmann::json::parse(dir.read("out/summary.json"))["complete"], false);
}

TEST(MapOutputs, AMapThatCouldNotBeMadeLeavesAllElse) {
  const TempDir dir;
  MapResult result = small_result();
  result.map = {};
  result.map_failure = "the map would be too large";
  try {
    write_map_outputs(result, small_info(), dir / "out");
    FAIL() << "there is no map";
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(std::string(error.what()).find("the map would be too large"), 0u);
  }
  EXPECT_EQ(read_tum(dir / "out/trajectory.tum").size(), 120u);
  EXPECT_FALSE(std::filesystem::exists(dir / "out/map.pgm"));
  const auto summary = nlohmann::json::parse(dir.read("out/summary.json"));
  EXPECT_EQ(summary["complete"], false);
  EXPECT_EQ(summary["warnings"].back(), "the map would be too large");
}

TEST(MapOutputs, AnOlderSetIsReplacedAsAWhole) {
  const TempDir dir;
  RunInfo info = small_info();
  write_map_outputs(small_result(), info, dir / "out");
  dir.write("out/texture.png", "of the older run");
  dir.write("out/precious.txt", "x");
  info.force = true;
  write_map_outputs(small_result(), info, dir / "out");
  EXPECT_FALSE(std::filesystem::exists(dir / "out/texture.png"));
  EXPECT_EQ(dir.read("out/precious.txt"), "x");
}

TEST(FileSet, EndedAmidTheSwapItIsMarkedIncomplete) {
  const TempDir dir;
  std::filesystem::create_directory(dir / "out");
  dir.write("out/summary.json", R"({"complete": true})");
  dir.write("out/trajectory.tum", "old");
  dir.write("out/graph.g2o", "old");
  const OutputFolder folder(dir / "out", true);
  FileSet files(folder);
  files.add("trajectory.tum", "", "new");
  files.add("graph.g2o", "", "new");
  files.add("summary.json", "", R"({"complete": true})");
  // Something that cannot be replaced stands for a kill in the middle.
  std::filesystem::remove(dir / "out/graph.g2o");
  std::filesystem::create_directories(dir / "out/graph.g2o/full");
  EXPECT_THROW(files.commit(), DataError);
  EXPECT_EQ(dir.read("out/trajectory.tum"), "new");
  EXPECT_EQ(nlohmann::json::parse(dir.read("out/summary.json"))["complete"], false);
}

TEST(MapPicture, SizesStayWithinBounds) {
  MapResult result = small_result();
  const Image small = draw_map_picture(result);
  EXPECT_GT(std::max(small.width, small.height), 900);
  EXPECT_LT(std::max(small.width, small.height), 2200);
  const GridFrame frame{.origin = {0.0, 0.0}, .resolution = 0.05, .columns = 9000, .rows = 700};
  result.map = {Grid<float>(frame, -1.0F), Grid<std::uint8_t>(frame, 1)};
  const Image large = draw_map_picture(result);
  EXPECT_LE(std::max(large.width, large.height), 4100);
  EXPECT_GT(large.width, 2000);
}

TEST(MapPicture, APathThatLeadsFarOffTheMapIsDrawnAllTheSame) {
  for (const double far_m : {4e4, 1e9, 1e18}) {
    MapResult result = small_result();
    result.trajectory.append(Stamp{1500000100000000000}, {far_m, -far_m, 0.0});
    const Image picture = draw_map_picture(result);
    EXPECT_LE(std::max(picture.width, picture.height), 4200);
    EXPECT_GT(std::min(picture.width, picture.height), 1000);
  }
}

TEST(MapPicture, WallsKeepTheirPlace) {
  // One occupied cell in free space, no path: the only dark pixels of the map lie where the cell
  // is, y upwards.
  MapResult result;
  const GridFrame frame{.origin = {10.0, 20.0}, .resolution = 0.1, .columns = 50, .rows = 40};
  result.map = {Grid<float>(frame, -3.0F), Grid<std::uint8_t>(frame, 1)};
  result.map.log_odds[{5, 35}] = 3.0F;
  const Image image = draw_map_picture(
      result, {.target_side_px = 500, .trajectory = false, .loop_closures = false});
  double sum_row = 0.0;
  double sum_column = 0.0;
  int count = 0;
  for (int row = 0; row < image.height * 6 / 10; ++row) {
    for (int column = 0; column < image.width; ++column) {
      if (image.sample(row, column, 0) > 60) continue;
      sum_row += row;
      sum_column += column;
      ++count;
    }
  }
  ASSERT_GT(count, 0);
  EXPECT_LT(sum_row / count, 0.25 * image.height);
  EXPECT_LT(sum_column / count, 0.3 * image.width);
}

}  // namespace
}  // namespace loopstone
