// `loopstone live`: maps and localises what comes.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "loopstone/formats/tum.hpp"
#include "office_command.hpp"
#include "program_paths.hpp"
#include "run_program.hpp"
#include "support/temp_dir.hpp"

namespace loopstone::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using testing::HasSubstr;
using Words = std::vector<std::string>;

class LiveCommand : public OfficeCommand {
 protected:
  static void SetUpTestSuite() {
    OfficeCommand::SetUpTestSuite();
    mcap_ = *folder_ / "log.mcap";
    const ProgramResult converted = run_program({"convert", log_, mcap_, "--quiet"});
    ASSERT_EQ(converted.exit_code, 0) << converted.error;
    const ProgramResult mapped = run_program({"map", log_, "-o", *folder_ / "map", "--quiet"});
    ASSERT_EQ(mapped.exit_code, 0) << mapped.error;
  }

  static Words live(const std::string& source, const std::string& out, const Words& more = {}) {
    Words words{"live", "--source", source, "-o", *folder_ / out, "--no-view", "--quiet"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  static Json summary_of(const std::string& out) {
    return Json::parse(folder_->read(out + "/summary.json"));
  }
  static std::vector<Json> lines_of(const std::string& file) {
    std::vector<Json> lines;
    std::istringstream text(folder_->read(file));
    for (std::string line; std::getline(text, line);) lines.push_back(Json::parse(line));
    return lines;
  }
  /// Between where a pose puts the robot and where the true map has it [m].
  static double error_of(const Json& line) {
    const auto truth = truth_.at(Stamp::from_seconds(line["t"].get<double>()));
    if (!truth) return 1e9;
    return std::hypot(line["map_T_robot"][0].get<double>() - truth->x,
                      line["map_T_robot"][1].get<double>() - truth->y);
  }

  /// Poses that were told so far.
  static std::size_t told_in(const std::string& path) {
    std::ifstream file(path);
    std::size_t lines = 0;
    for (std::string line; std::getline(file, line);) ++lines;
    return lines;
  }
  static std::size_t scans_of_the_log() { return summary_of("map")["scans"].get<std::size_t>(); }
  static void wait_for(const std::function<bool()>& is_so) {
    for (int i = 0; i < 3000 && !is_so(); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    EXPECT_TRUE(is_so());
  }

  static inline std::string mcap_;
};

TEST_F(LiveCommand, AReplayGivesTheMapOfTheLog) {
  const ProgramResult result = run_program(live("replay:" + log_, "replayed", {"--speed", "1000"}));
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(folder_->read("replayed/trajectory.tum"), folder_->read("map/trajectory.tum"));
  EXPECT_EQ(folder_->read("replayed/map.pgm"), folder_->read("map/map.pgm"));
  EXPECT_EQ(summary_of("replayed")["complete"], true);
}

TEST_F(LiveCommand, AFileThatGrowsIsMappedUntilCtrlC) {
  // Line by line, where chunks of MCAP would come when they are whole.
  ASSERT_EQ(run_program({"convert", log_, *folder_ / "log.clf", "--quiet"}).exit_code, 0);
  const std::string all = folder_->read("log.clf");
  const std::string path = folder_->write("growing.clf", all.substr(0, all.size() / 2));
  const std::string poses = *folder_ / "poses.jsonl";
  const std::size_t scans = scans_of_the_log();
  const ProgramResult result = interrupt_after(
      live(path, "grown", {"--poses", poses, "--record", *folder_ / "record.mcap"}),
      [&](const std::function<std::string()>&) {
        wait_for([&] { return told_in(poses) > 10; });
        EXPECT_LT(told_in(poses), scans) << "half of it is not there yet";
        std::ofstream(path, std::ios::app | std::ios::binary) << all.substr(all.size() / 2);
        wait_for([&] { return told_in(poses) + 3 >= scans; });
      });
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(summary_of("grown")["complete"], true) << "the end of a drive is no interruption";
  const std::vector<Json> lines = lines_of("poses.jsonl");
  EXPECT_GE(lines.size() + 3, scans);
  EXPECT_EQ(lines.back()["status"], "tracked");
  EXPECT_LT(lines.back()["sigma_m"].get<double>(), 0.1);

  const ProgramResult again =
      run_program({"map", *folder_ / "record.mcap", "-o", *folder_ / "again", "--quiet"});
  ASSERT_EQ(again.exit_code, 0) << again.error;
  EXPECT_EQ(summary_of("again")["scans"], summary_of("grown")["scans"]);
}

TEST_F(LiveCommand, WhatWasSavedBeforeACrashIsGoneOnWith) {
  const std::string state = *folder_ / "crashed/state.loopstone";
  Words words = live("replay:" + log_, "crashed", {"--speed", "3", "--checkpoint", "0.3"});
  (void)kill_program(std::chrono::milliseconds(2500), words);
  ASSERT_TRUE(fs::exists(state));
  const ProgramResult result = run_program(
      live("replay:" + mcap_, "joined", {"--speed", "1000", "--continue", *folder_ / "crashed"}));
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const ProgramResult drawn =
      run_program({"edit", *folder_ / "crashed", "-o", *folder_ / "drawn", "--quiet"});
  ASSERT_EQ(drawn.exit_code, 0) << drawn.error;
  EXPECT_GT(summary_of("drawn")["scans"].get<int>(), 10) << "what the run had led to";

  const Json summary = summary_of("joined");
  EXPECT_GT(summary["scans"].get<int>(), summary_of("map")["scans"].get<int>());
  EXPECT_EQ(summary["drives"].size(), 1U);
}

TEST_F(LiveCommand, TellsWhereTheRobotIsOnAMap) {
  const ProgramResult result = run_program(
      {"live", "--source", "replay:" + log_, "--speed", "1000", "--map", map_, "--no-view", "-o",
       *folder_ / "where.tum", "--poses", *folder_ / "where.jsonl", "--quiet"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const std::vector<Json> lines = lines_of("where.jsonl");
  ASSERT_GT(lines.size(), 50U);
  EXPECT_EQ(lines.back()["status"], "TRACKING");
  EXPECT_GT(lines.back()["probability"].get<double>(), 0.9);
  EXPECT_LT(error_of(lines.back()), 0.05);
  EXPECT_EQ(read_tum(*folder_ / "where.tum").size(), lines.size());
}

TEST_F(LiveCommand, SourcesThatComeLaterAreWaitedForAndMayComeBack) {
  const std::string pipe = *folder_ / "late";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const std::string poses = *folder_ / "late.jsonl";
  const ProgramResult result = interrupt_after(
      live(pipe, "late_map", {"--poses", poses}), [&](const std::function<std::string()>& errors) {
        std::this_thread::sleep_for(std::chrono::milliseconds(200));
        std::ofstream(pipe, std::ios::binary) << folder_->read("log.mcap");
        wait_for([&] { return errors().find("trying again") != std::string::npos; });
        wait_for([&] { return told_in(poses) + 3 >= scans_of_the_log(); });
        // The last ones are told in the end, for they wait for odometry. They have come, too.
        std::this_thread::sleep_for(std::chrono::milliseconds(300));
      });
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("late: ended; trying again"));
  EXPECT_EQ(summary_of("late_map")["scans"], summary_of("map")["scans"]);
}

/// A program that says where it serves, in its first line.
class Emulator {
 public:
  explicit Emulator(const std::string& arguments)
      : pipe_(::popen((std::string(LOOPSTONE_EMULATED_SCANNER) + " " + arguments).c_str(), "r")) {
    std::array<char, 256> line{};
    if (pipe_ != nullptr && std::fgets(line.data(), line.size(), pipe_) != nullptr)
      address_ = line.data();
    while (address_.ends_with('\n')) address_.pop_back();
  }
  ~Emulator() {
    if (pipe_ != nullptr) ::pclose(pipe_);
  }
  Emulator(const Emulator&) = delete;
  Emulator& operator=(const Emulator&) = delete;
  [[nodiscard]] const std::string& address() const { return address_; }

 private:
  std::FILE* pipe_;
  std::string address_{};
};

TEST_F(LiveCommand, AScannerAloneMakesAMapThoughItsCableIsPulledOnce) {
  for (const std::string& arguments :
       Words{"scip --seconds 6 --disconnect-after 2", "rplidar --seconds 6"}) {
    const Emulator emulator(arguments);
    const std::string out = arguments.substr(0, 4);
    const ProgramResult result = run_program({"live", "--source", emulator.address(), "-o",
                                              *folder_ / out, "--no-view", "--end-after", "1.5"});
    ASSERT_EQ(result.exit_code, 0) << result.error;
    const Json summary = summary_of(out);
    EXPECT_GT(summary["scans"].get<int>(), 10) << arguments;
    EXPECT_GT(summary["map_free_area_m2"].get<double>(), 5.0) << arguments;
    EXPECT_THAT(result.error, HasSubstr("trying again"));
    if (out == "scip") {
      EXPECT_THAT(result.error, HasSubstr("is back"));
    }
  }
}

TEST_F(LiveCommand, WhatMakesNoSenseIsRefused) {
  const auto refused = [](const Words& words) {
    const ProgramResult result = run_program(words);
    EXPECT_EQ(result.exit_code, 2) << result.error;
    return result.error;
  };
  const std::string out = *folder_ / "none";
  EXPECT_THAT(refused({"live", "-o", out}), HasSubstr("--source"));
  EXPECT_THAT(refused({"live", "--source", "-"}), HasSubstr("-o FOLDER"));
  EXPECT_THAT(refused({"live", "--source", "http://host", "-o", out}),
              HasSubstr("no kind of source"));
  EXPECT_THAT(refused({"live", "--source", "tcp://host", "-o", out}), HasSubstr("tcp://HOST:PORT"));
  EXPECT_THAT(refused({"live", "--source", "-", "--source", "-", "-o", out}),
              HasSubstr("one source"));
  EXPECT_THAT(refused({"live", "--source", "-", "-o", out, "--initial", "0,0,0"}),
              HasSubstr("--map"));
  EXPECT_THAT(refused({"live", "--source", "-", "-o", out, "--map", map_, "--continue", out}),
              HasSubstr("leave out one"));
  EXPECT_THAT(refused({"live", "--source", "-", "-o", out, "--no-view", "--port", "9000"}),
              HasSubstr("are of the view"));
  EXPECT_FALSE(fs::exists(out));
  const ProgramResult gone = run_program(live(*folder_ / "no_such_log", "none"));
  EXPECT_EQ(gone.exit_code, 1);
  EXPECT_THAT(gone.error, HasSubstr("there is no such file"));
}

}  // namespace
}  // namespace loopstone::test
