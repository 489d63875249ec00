#include "loopstone/report/localization_outputs.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "html_check.hpp"
#include "localization_scene.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/formats/localization_csv.hpp"
#include "loopstone/formats/tum.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

using test::small_localization;
using test::small_room;
using test::small_run;
using test::TempDir;
using testing::HasSubstr;
using Json = nlohmann::json;

const std::vector<std::string> kFiles{"localization.csv", "map.png",      "options.toml",
                                      "report.html",      "summary.json", "trajectory.tum"};

Json summary_of(const LocalizationResult& result, const LocalizationRunInfo& info = small_run()) {
  return Json::parse(format_summary(result, small_room(), info));
}

TEST(LocalizationOutputs, EveryFileIsThereAndReadsBack) {
  const TempDir dir;
  write_localization_outputs(small_localization(), small_room(), small_run(), dir / "out");
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(dir / "out"))
    names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names, kFiles);
  EXPECT_EQ(read_tum(dir / "out/trajectory.tum").size(), 201u);
  const auto estimates = read_localization_csv(dir / "out/localization.csv");
  ASSERT_EQ(estimates.size(), 201u);
  EXPECT_EQ(estimates.back().state, LocalizationState::kTracking);
  EXPECT_EQ(read_image(dir / "out/map.png").channels, 3);
  EXPECT_EQ(dir.read("out/options.toml"), small_run().run.options_toml);
  EXPECT_EQ(Json::parse(dir.read("out/summary.json")), summary_of(small_localization()));
}

TEST(LocalizationOutputs, SummaryCountsTime) {
  const Json summary = summary_of(small_localization());
  EXPECT_NEAR(summary["lost_share"].get<double>(), 2.4 / 20.0, 1e-9);
  EXPECT_NEAR(summary["doubtful_share"].get<double>(), 1.0 / 20.0, 1e-9);
  EXPECT_NEAR(summary["tracking_share"].get<double>(), 16.6 / 20.0, 1e-9);
  EXPECT_NEAR(summary["first_tracking_s"].get<double>(), 3.0, 1e-9);
  EXPECT_NEAR(summary["first_tracking_m"].get<double>(), 1.5, 1e-9);
  EXPECT_EQ(summary["state_changes"], 4);
  EXPECT_EQ(summary["searches"], 2);
  EXPECT_EQ(summary["searches_of_whole_map"], 1);
  EXPECT_EQ(summary["poses_refined"], 177);
  EXPECT_EQ(summary["seed"], 7);
  EXPECT_EQ(summary["start"], "global");
  EXPECT_TRUE(summary["initial"].is_null());
  EXPECT_EQ(summary["map"], "rooms/map.yaml");
  EXPECT_DOUBLE_EQ(summary["realtime_factor"].get<double>(), 40.0);
  EXPECT_DOUBLE_EQ(summary["last_pose"]["sigma_x_m"].get<double>(), 0.01);
  EXPECT_EQ(summary["last_pose"]["state"], "TRACKING");
}

TEST(LocalizationOutputs, FiguresAreTheNumbersOfTheSummary) {
  const Json summary = summary_of(small_localization());
  const auto figures = summary_figures(small_localization(), small_room(), small_run());
  const auto value_of = [&](const std::string& key) {
    const auto found = std::ranges::find(figures, key, &SummaryFigure::key);
    EXPECT_NE(found, figures.end()) << key;
    return found == figures.end() ? std::nullopt : found->value;
  };
  EXPECT_EQ(value_of("scans"), summary["scans"].get<double>());
  EXPECT_EQ(value_of("tracking_share"), summary["tracking_share"].get<double>());
  EXPECT_EQ(value_of("last_pose.sigma_x_m"), 0.01);
  EXPECT_EQ(value_of("left_out.records"), 4.0);
  EXPECT_EQ(value_of("initial"), std::nullopt);
  for (const std::string text : {"start", "warnings", "last_pose", "complete"})
    EXPECT_EQ(std::ranges::count(figures, text, &SummaryFigure::key), 0) << text;
  // Not one is forgotten.
  std::size_t numbers = 0;
  const std::function<void(const Json&)> count = [&](const Json& value) {
    for (const Json& child : value) {
      if (child.is_object()) count(child);
      numbers += child.is_number() || child.is_null() ? 1 : 0;
    }
  };
  count(summary);
  EXPECT_EQ(figures.size(), numbers);
}

TEST(LocalizationOutputs, TimesBetweenScansCountNotScans) {
  LocalizationResult result;
  LocalizationEstimate e;
  e.stamp = Stamp{0};
  result.estimates.push_back(e);  // LOST for 9 s
  e.stamp = Stamp{9'000'000'000};
  e.state = LocalizationState::kTracking;
  result.estimates.push_back(e);  // TRACKING for 1 s
  e.stamp = Stamp{10'000'000'000};
  result.estimates.push_back(e);
  const Json summary = summary_of(result);
  EXPECT_DOUBLE_EQ(summary["lost_share"].get<double>(), 0.9);
  EXPECT_DOUBLE_EQ(summary["tracking_share"].get<double>(), 0.1);
}

TEST(LocalizationOutputs, TimeBeforeTheFirstPoseWasLost) {
  LocalizationResult result = small_localization();
  result.start = result.start - Duration::from_seconds(20.0);
  const Json summary = summary_of(result);
  EXPECT_NEAR(summary["lost_share"].get<double>(), 22.4 / 40.0, 1e-9);
  EXPECT_NEAR(summary["first_tracking_s"].get<double>(), 23.0, 1e-9);
  result.estimates.clear();
  EXPECT_EQ(summary_of(result)["lost_share"], 1.0);
}

TEST(LocalizationOutputs, SummaryOfOnePoseAndOfNone) {
  LocalizationResult result;
  const Json none = summary_of(result);
  EXPECT_TRUE(none["last_pose"].is_null());
  EXPECT_TRUE(none["first_tracking_s"].is_null());
  EXPECT_EQ(none["tracking_share"], 0.0);
  result.estimates.resize(1);
  EXPECT_EQ(summary_of(result)["lost_share"], 1.0);
  LocalizationRunInfo info = small_run();
  info.initial = InitialPose{.map_T_robot = {1.0, 2.0, 0.5}, .sigma_m = 0.3, .sigma_rad = 0.1};
  info.run.log_path = "bad\xFFname";
  const Json one = summary_of(result, info);
  EXPECT_EQ(one["start"], "initial");
  EXPECT_EQ(one["initial"]["sigma_rad"], 0.1);
}

TEST(LocalizationOutputs, ReportNeedsNothingElse) {
  const TempDir dir;
  write_localization_outputs(small_localization(), small_room(), small_run(), dir / "out");
  const std::string html = dir.read("out/report.html");
  EXPECT_THAT(html, HasSubstr("data:image/png;base64,iVBORw0KGgo"));
  EXPECT_THAT(html, HasSubstr("Localisation of a&amp;b.clf"));
  EXPECT_THAT(html, HasSubstr("a wall &lt;went&gt; &amp; came back"));
  EXPECT_THAT(html, HasSubstr("lost &lt;again&gt;"));
  EXPECT_THAT(html, HasSubstr("# &lt;most&gt;"));
  EXPECT_THAT(html, HasSubstr("after 3.00 s and 1.50 m"));
  EXPECT_THAT(html, HasSubstr("whole map"));
  EXPECT_THAT(html, HasSubstr("<rect class=\"band lost\""));
  EXPECT_THAT(html, HasSubstr("<rect class=\"strip tracking\""));
  test::expect_self_contained(html);
}

TEST(LocalizationOutputs, IncompleteAndEmptyRunsAreWritten) {
  const TempDir dir;
  LocalizationResult result;
  result.complete = false;
  write_localization_outputs(result, small_room(), small_run(), dir / "out");
  const std::string html = dir.read("out/report.html");
  EXPECT_THAT(html, HasSubstr("Incomplete"));
  EXPECT_THAT(html, HasSubstr("never sure"));
  test::expect_self_contained(html);
  EXPECT_FALSE(Json::parse(dir.read("out/summary.json"))["complete"]);
  result = small_localization();
  result.estimates.resize(1);
  result.snapshots.resize(1);
  write_localization_outputs(result, small_room(), small_run(), dir / "one");
}

TEST(LocalizationOutputs, LongRunsGiveSmallPages) {
  LocalizationResult result = small_localization();
  const auto pattern = result.estimates;
  for (int round = 1; round <= 60; ++round) {
    for (LocalizationEstimate e : pattern) {
      e.stamp = e.stamp + Duration::from_seconds(20.1 * round);
      if (e.state != result.estimates.back().state) result.changes.push_back({e.stamp, e.state});
      result.estimates.push_back(e);
    }
  }
  result.searches.assign(5000, result.searches.back());
  const TempDir dir;
  write_localization_outputs(result, small_room(), small_run(), dir / "out");
  EXPECT_LT(std::filesystem::file_size(dir / "out/report.html"), 1'500'000u);
  EXPECT_THAT(dir.read("out/report.html"), HasSubstr("and 4,750 more"));
}

TEST(LocalizationOutputs, SameResultSameBytes) {
  const TempDir dir;
  for (const char* name : {"a", "b"})
    write_localization_outputs(small_localization(), small_room(), small_run(), dir / name);
  for (const std::string& name : kFiles)
    EXPECT_EQ(dir.read("a/" + name), dir.read("b/" + name)) << name;
}

TEST(LocalizationOutputs, FolderMustBeEmptyOrForced) {
  const TempDir dir;
  LocalizationRunInfo info = small_run();
  std::filesystem::create_directory(dir / "out");
  dir.write("out/precious.txt", "x");
  const LocalizationResult result = small_localization();
  EXPECT_THROW(write_localization_outputs(result, small_room(), info, dir / "out"), UsageError);
  EXPECT_THROW((void)write_localization_animation(result, small_room(), dir / "out", false),
               UsageError);
  info.run.force = true;
  write_localization_outputs(result, small_room(), info, dir / "out");
  EXPECT_EQ(dir.read("out/precious.txt"), "x");
}

TEST(LocalizationOutputs, FullDiskLeavesNothing) {
  const TempDir dir;
  const LocalizationResult result = small_localization();
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit small = before;
  small.rlim_cur = 20000;  // fits the trajectory, not the table or the picture
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  EXPECT_THROW(write_localization_outputs(result, small_room(), small_run(), dir / "out"),
               DataError);
  EXPECT_THROW((void)write_localization_trajectory(result, dir / "where.tum"), DataError);
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, old_handler);
  EXPECT_TRUE(dir.names().empty()) << "neither files nor the folder stay";
}

TEST(LocalizationTrajectory, TheTableStandsBesideIt) {
  const TempDir dir;
  const LocalizationResult result = small_localization();
  EXPECT_EQ(write_localization_trajectory(result, dir / "where.tum"), dir / "where.csv");
  EXPECT_EQ(write_localization_trajectory(result, dir / "plain"), dir / "plain.csv");
  EXPECT_EQ(read_tum(dir / "where.tum").size(), 201u);
  EXPECT_EQ(read_localization_csv(dir / "where.csv").size(), 201u);
  EXPECT_THROW((void)write_localization_trajectory(result, dir / "where.csv"), UsageError);
  EXPECT_EQ(write_localization_trajectory(result, "/dev/null"), "");
  EXPECT_THROW((void)write_localization_trajectory(result, dir / "no/where.tum"), DataError);
}

TEST(LocalizationAnimation, NumberedPicturesOfOneSize) {
  const TempDir dir;
  LocalizationResult result = small_localization();
  EXPECT_EQ(write_localization_animation(result, small_room(), dir / "film", false), 6);
  const Image first = read_image(dir / "film/000001.png");
  const Image last = read_image(dir / "film/000006.png");
  EXPECT_EQ(first.width, last.width);
  EXPECT_EQ(first.height, last.height);
  EXPECT_EQ(first.width % 2 + first.height % 2, 0) << "video encoders want even sides";
  EXPECT_NE(first.bytes, last.bytes);
  // A shorter run over it leaves none of the old ones, and nothing else is touched.
  dir.write("film/notes.txt", "x");
  result.snapshots.resize(2);
  EXPECT_EQ(write_localization_animation(result, small_room(), dir / "film", true), 2);
  EXPECT_TRUE(std::filesystem::exists(dir / "film/000002.png"));
  EXPECT_FALSE(std::filesystem::exists(dir / "film/000003.png"));
  EXPECT_FALSE(std::filesystem::exists(dir / "film/000006.png"));
  EXPECT_EQ(dir.read("film/notes.txt"), "x");
  result.snapshots.clear();
  EXPECT_EQ(write_localization_animation(result, small_room(), dir / "none", false), 0);
}

}  // namespace
}  // namespace loopstone
