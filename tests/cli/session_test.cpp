// map --checkpoint and --resume: a run that is ended from outside goes on to the same result.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "run_program.hpp"
#include "support/temp_dir.hpp"

namespace loopstone::test {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using testing::HasSubstr;
using testing::Not;

constexpr int kKilled = 128 + 9;
constexpr int kInterrupted = 130;

class SessionCommand : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempDir;
    for (const char* seed : {"3", "4"}) {
      const ProgramResult made =
          run_program({"simulate", "office", "-o", *folder_ / (std::string("log") + seed),
                       "--duration", "12", "--beams", "121", "--fov", "180", "--seed", seed});
      ASSERT_EQ(made.exit_code, 0) << made.error;
    }
    const ProgramResult mapped = run_program(map_into("whole"));
    ASSERT_EQ(mapped.exit_code, 0) << mapped.error;
  }
  static void TearDownTestSuite() { delete folder_; }
  void SetUp() override {
    std::error_code ignored;
    fs::remove_all(out(), ignored);
  }

  static std::string log() { return *folder_ / "log3"; }
  static std::string other_log() { return *folder_ / "log4"; }
  static std::string out() { return *folder_ / "out"; }
  static std::string session() { return out() + "/session.loopstone"; }

  static std::vector<std::string> map_into(const std::string& name,
                                           const std::vector<std::string>& flags = {}) {
    std::vector<std::string> arguments{"map", log(), "-o", *folder_ / name};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    return arguments;
  }
  static std::vector<std::string> map(const std::vector<std::string>& flags) {
    return map_into("out", flags);
  }
  /// Twelve seconds in about one, so that there is time to be disturbed; saved all the time.
  static std::vector<std::string> slow_map(std::vector<std::string> flags = {}) {
    flags.insert(flags.end(), {"--realtime", "12", "--checkpoint", "0.02"});
    return map(flags);
  }
  /// Leaves a session in the folder.
  static void interrupt() {
    const ProgramResult result = interrupt_program(session(), slow_map());
    ASSERT_EQ(result.exit_code, kInterrupted) << result.error;
    ASSERT_TRUE(fs::exists(session()));
  }

  static nlohmann::json summary_of(const std::string& name) {
    auto summary = nlohmann::json::parse(folder_->read(name + "/summary.json"));
    std::vector<std::string> times{
        "wall_time_s",       "cpu_time_s", "realtime_factor", "scans_per_s",
        "peak_memory_bytes", "threads",    "realtime",        "command"};
    for (const auto& [key, value] : summary.items()) {
      if (key.ends_with("_wall_s")) times.push_back(key);
    }
    for (const std::string& key : times) summary.erase(key);
    return summary;
  }
  static void expect_same_result() {
    for (const char* name : {"trajectory.tum", "odometry.tum", "graph.g2o", "loop_closures.csv",
                             "map.pgm", "map.yaml", "map.png", "options.toml", "decisions.toml"}) {
      const std::string expected = folder_->read(std::string("whole/") + name);
      EXPECT_FALSE(expected.empty()) << name;
      EXPECT_TRUE(folder_->read(std::string("out/") + name) == expected) << name;
    }
    EXPECT_EQ(nlohmann::json::diff(summary_of("whole"), summary_of("out")),
              nlohmann::json::array());
    EXPECT_FALSE(fs::exists(session())) << "the results are complete";
    for (const auto& entry : fs::directory_iterator(out()))
      EXPECT_THAT(entry.path().filename().string(), Not(HasSubstr(".partial")));
  }

  static TempDir* folder_;
};

TempDir* SessionCommand::folder_ = nullptr;

TEST_F(SessionCommand, SavingChangesNothing) {
  const ProgramResult result = run_program(map({"--checkpoint", "0.01", "--threads", "1"}));
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("session saved"));
  expect_same_result();
}

TEST_F(SessionCommand, KilledAtAnyTimeItGoesOnToTheSameResult) {
  Rng rng(1);
  int kills = 0;
  while (kills < 200) {
    // What is not saved, such as the end of a run, takes longer on a machine that is busy.
    const auto after = milliseconds(30 + 5 * kills + static_cast<int>(rng.below(350)));
    const ProgramResult result = kill_program(after, slow_map({"--resume"}));
    if (result.exit_code != kKilled) {
      ASSERT_EQ(result.exit_code, 0) << result.error;
      break;
    }
    ++kills;
  }
  EXPECT_GE(kills, 3);
  EXPECT_LT(kills, 200) << "it never comes forward";
  expect_same_result();
}

TEST_F(SessionCommand, CtrlCKeepsTheSessionAndWhatIsThere) {
  interrupt();
  EXPECT_TRUE(fs::exists(out() + "/map.pgm"));
  const ProgramResult result = run_program(map({"--resume", "--threads", "1"}));
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("goes on after"));
  expect_same_result();
}

TEST_F(SessionCommand, WithoutASessionItBeginsAtTheBeginning) {
  const ProgramResult result = run_program(map({"--resume"}));
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("no session"));
  expect_same_result();
  // The same again has nothing left to do; another run must not replace results by accident.
  const ProgramResult again = run_program(map({"--resume"}));
  EXPECT_EQ(again.exit_code, 0) << again.error;
  EXPECT_THAT(again.error, HasSubstr("already"));
  // Words of the command that lead to no other result don't count, nor do other ways to the log.
  for (const std::vector<std::string>& flags :
       std::vector<std::vector<std::string>>{{"--resume", "--threads", "1"},
                                             {"--resume", "--quiet", "--checkpoint", "3"},
                                             {"--set", "map.resolution_m=0.05", "--resume"}}) {
    EXPECT_EQ(run_program(map(flags)).exit_code, 0) << flags.back();
  }
  const ProgramResult copy = run_program({"map", log() + "#20", "-o", out(), "--resume", "--json"});
  EXPECT_EQ(copy.exit_code, 0) << copy.error;
  EXPECT_EQ(copy.out, folder_->read("out/summary.json"));
  EXPECT_EQ(run_program({"map", other_log(), "-o", out(), "--resume"}).exit_code, 2);
  EXPECT_EQ(run_program(map({"--resume", "--max-scans", "20"})).exit_code, 2);
  const ProgramResult other = run_program(map({"--resume", "--no-loop-closure"}));
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_THAT(other.error, HasSubstr("--force"));
  expect_same_result();
}

TEST_F(SessionCommand, ASessionThatWasNotAskedForIsNotOverwritten) {
  interrupt();
  const ProgramResult result = run_program(map({}));
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.error, HasSubstr("--resume"));
  ASSERT_TRUE(fs::exists(session()));
  const ProgramResult forced = run_program(map({"--force"}));
  EXPECT_EQ(forced.exit_code, 0) << forced.error;
  expect_same_result();
}

TEST_F(SessionCommand, ASessionOfAnotherRunIsRefusedAndSaysWhatDiffers) {
  interrupt();
  const auto refusal = [&](const std::vector<std::string>& flags) {
    const ProgramResult result = run_program(map(flags));
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_EQ(count_lines(result.error), 1u) << result.error;
    EXPECT_TRUE(fs::exists(session()));
    return result.error;
  };
  EXPECT_THAT(refusal({"--resume", "--set", "front_end.points_max=200"}),
              HasSubstr("points_max = 360` then, `points_max = 200` now"));
  EXPECT_THAT(refusal({"--resume", "--max-scans", "30"}), HasSubstr("--max-scans: 0 then, 30 now"));
  EXPECT_THAT(refusal({"--resume", "--start", "1"}), HasSubstr("--start"));
  EXPECT_THAT(refusal({"--resume", "--duration", "3"}), HasSubstr("--duration"));
  const std::string robot =
      folder_->write("robot.toml", "name = \"other\"\n[wheels]\ntrack_width_m = 0.5\n");
  EXPECT_THAT(refusal({"--resume", "--robot", robot}), HasSubstr("robot: "));
  const ProgramResult other = run_program({"map", other_log(), "-o", out(), "--resume", "--quiet"});
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_THAT(other.error, HasSubstr("another log"));
}

TEST_F(SessionCommand, ADamagedSessionIsRefusedWithItsOffset) {
  interrupt();
  std::string bytes = folder_->read("out/session.loopstone");
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 4);
  (void)folder_->write("out/session.loopstone", bytes);
  const ProgramResult result = run_program(map({"--resume", "--quiet"}));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.error, HasSubstr("session.loopstone (byte "));
  EXPECT_THAT(result.error, HasSubstr("--force"));
  (void)folder_->write("out/session.loopstone", bytes.substr(0, bytes.size() / 3));
  EXPECT_EQ(run_program(map({"--resume"})).exit_code, 1);
}

TEST_F(SessionCommand, ASessionThatCannotBeSavedIsAWarning) {
  const ProgramResult result = disturb_program(
      session(),
      [] {
        // The run may save the next one in between.
        std::error_code ignored;
        while (!fs::is_directory(session())) {
          fs::remove(session(), ignored);
          fs::create_directory(session(), ignored);
        }
      },
      slow_map());
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("could not be saved, the run goes on"));
  expect_same_result();
}

TEST_F(SessionCommand, TheTextbookPipelineHasNoSession) {
  for (const char* flag : {"--checkpoint=5", "--resume"}) {
    const ProgramResult result = run_program(map({"--pipeline", "scan_to_scan", flag}));
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.error, HasSubstr("--checkpoint"));
    EXPECT_FALSE(fs::exists(out()));
  }
}

}  // namespace
}  // namespace loopstone::test
