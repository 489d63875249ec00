// What commands say of logs that hardly hold one, that come through a pipe, or that want to speak
// to the terminal themselves.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "run_program.hpp"
#include "support/temp_dir.hpp"

namespace loopstone::test {
namespace {

using testing::HasSubstr;
using testing::Not;

/// A few seconds of an office as CARMEN text, made once.
class DamagedLog : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::signal(SIGPIPE, SIG_IGN);
    const TempDir folder;
    ASSERT_EQ(run_program({"simulate", "office", "-o", folder / "sim", "--duration", "6", "--beams",
                           "181", "--fov", "180", "--seed", "3"})
                  .exit_code,
              0);
    const ProgramResult result = run_program({"convert", folder / "sim", folder / "sim.clf"});
    ASSERT_EQ(result.exit_code, 0) << result.error;
    std::istringstream text(folder.read("sim.clf"));
    for (std::string line; std::getline(text, line);) lines_.push_back(line);
  }

  /// The office with every line changed.
  template <typename Change>
  [[nodiscard]] std::string log(const std::string& name, Change&& change) const {
    std::string text;
    for (const std::string& line : lines_) text += change(line) + "\n";
    return folder_.write(name, text);
  }
  /// Stamp and logger's time become this.
  [[nodiscard]] std::string with_stamps(const std::string& name, const std::string& stamp) const {
    return log(name, [&](const std::string& line) {
      const std::size_t host = line.rfind(' ', line.rfind(' ') - 1);
      const std::size_t time = line.rfind(' ', host - 1);
      return line.substr(0, time) + " " + stamp + " host " + stamp;
    });
  }

  static inline std::vector<std::string> lines_;
  TempDir folder_;
};

nlohmann::json info(const std::string& log) {
  const ProgramResult result = run_program({"info", log, "--json", "--quiet"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  return nlohmann::json::parse(result.out, nullptr, false);
}

TEST_F(DamagedLog, WithoutStampsIsMappedInTheOrderOfTheFileWithAWarning) {
  const std::string path = with_stamps("zero.clf", "0.0");
  EXPECT_TRUE(info(path)["mappable"].get<bool>());
  const ProgramResult result = run_program({"map", path, "-o", folder_ / "out", "--json"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  const auto summary = nlohmann::json::parse(result.out);
  EXPECT_EQ(summary["scans"].get<int>(), 59);
  EXPECT_EQ(summary["records_skipped"].get<int>(), 0);
  EXPECT_THAT(summary["warnings"].dump(), HasSubstr("all scans have the same stamp"));
  EXPECT_THAT(summary["warnings"].dump(), HasSubstr("5 scans a second"));
}

TEST_F(DamagedLog, MapRefusesWhatInfoRefusesForTheSameReason) {
  int scan = 0;
  const std::string path = log("rest.clf", [&](const std::string& line) {
    const bool spoil = line.starts_with("FLASER") && ++scan % 20 != 0;
    return spoil ? line.substr(0, line.size() / 2) : line;
  });
  const nlohmann::json found = info(path);
  EXPECT_FALSE(found["mappable"].get<bool>());
  const std::string reason = found["findings"][0]["text"];
  EXPECT_THAT(reason, HasSubstr("were left out"));
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"map", path, "-o", folder_ / "out"},
           {"map", path, "-o", folder_ / "textbook", "--pipeline", "scan_to_scan"},
           {"odometry", path, "-o", folder_ / "out.tum"},
           {"convert", path, folder_ / "converted.clf"}}) {
    const ProgramResult result = run_program(arguments);
    EXPECT_EQ(result.exit_code, 1) << arguments[0] << result.out;
    EXPECT_THAT(result.error, HasSubstr("nothing can be made of this log")) << arguments[0];
    EXPECT_THAT(result.error, HasSubstr("were left out")) << arguments[0];
  }
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out/summary.json"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out.tum"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "converted.clf"));
}

TEST_F(DamagedLog, AMapOfAHalfSaysSo) {
  int scan = 0;
  const std::string path = log("half.clf", [&](const std::string& line) {
    const bool spoil = line.starts_with("FLASER") && ++scan % 2 == 0;
    return spoil ? line.substr(0, line.size() / 2) : line;
  });
  EXPECT_TRUE(info(path)["mappable"].get<bool>());
  const ProgramResult result = run_program({"map", path, "-o", folder_ / "out", "--json"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("29 of 59 scans (49.2 %)"));
  EXPECT_THAT(result.error, HasSubstr("the line ends before"));
  const auto summary = nlohmann::json::parse(result.out);
  EXPECT_DOUBLE_EQ(summary["left_out"]["scan_share"].get<double>(), 29.0 / 59.0);
  EXPECT_THAT(summary["warnings"].dump(), HasSubstr("were left out"));
  EXPECT_THAT(folder_.read("out/report.html"), HasSubstr("were left out"));
}

TEST_F(DamagedLog, StampsInMillisecondsAreNamedWithTheirLine) {
  const std::string path = with_stamps("ms.clf", "976052857337");
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"info", path}, {"map", path, "-o", folder_ / "out"}}) {
    const ProgramResult result = run_program(arguments);
    EXPECT_THAT(result.out + result.error, HasSubstr("'976052857337', expected seconds"));
    EXPECT_THAT(result.out + result.error, HasSubstr("divide it by 1000"));
    EXPECT_THAT(result.out + result.error, HasSubstr("ms.clf:"));
  }
}

TEST_F(DamagedLog, AMapOfAPipeIsThatOfTheFile) {
  const std::string path = log("sim.clf", [](const std::string& line) { return line; });
  const std::string text = folder_.read("sim.clf");
  const std::string pipe = folder_ / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  ASSERT_EQ(run_program({"map", path, "-o", folder_ / "of_file"}).exit_code, 0);
  for (const std::string threads : {"1", "2"}) {
    const std::jthread writer([&] { std::ofstream(pipe, std::ios::binary) << text; });
    const ProgramResult result =
        run_program({"map", pipe, "-o", folder_ / ("out" + threads), "--threads", threads});
    EXPECT_EQ(result.exit_code, 0) << result.error;
    EXPECT_EQ(folder_.read("out" + threads + "/trajectory.tum"),
              folder_.read("of_file/trajectory.tum"));
  }
}

TEST_F(DamagedLog, CtrlCLeavesAPipeThatNobodyWritesInto) {
  const std::string pipe = folder_ / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  for (const std::vector<std::string>& arguments :
       std::vector<std::vector<std::string>>{{"info", pipe},
                                             {"map", pipe, "-o", folder_ / "out"},
                                             {"match", pipe + "#0", pipe + "#1"}}) {
    EXPECT_EQ(interrupt_program(pipe, arguments).exit_code, 130);
  }
}

TEST_F(DamagedLog, DevicesAreNoLogs) {
  for (const char* device : {"/dev/zero", "/dev/stdin", "-"}) {
    const ProgramResult result = run_program({"map", device, "-o", folder_ / "out"});
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_THAT(result.error, HasSubstr("is a device, not a log")) << device;
  }
}

TEST_F(DamagedLog, ControlCharactersNeverReachTheTerminal) {
  const std::string evil = "\x1b]0;owned\x07\x1b[2J\x7f\xc2\x9b";
  const std::string path = folder_ / ("log" + evil + ".clf");
  std::ofstream(path) << "FLASER 2 " << evil << " 1 0 0 0 0 0 0 1.0 h 0\nODOM 0 0 0 0 0 0 1.0 h 0\n"
                      << "ODOM " << evil << "\nODOM 1 2 \xff\xfe 0 0 0 1.0 h 0\n";
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"info", path},
           {"info", path, "--json"},
           {"map", path, "-o", folder_ / "out"},
           {"odometry", path, "-o", folder_ / ("odometry" + evil + ".tum")},
           {"convert", path, folder_ / ("out" + evil + ".clf")},
           {"match", path + "#0", path + "#1"},
           {evil}}) {
    const ProgramResult result = run_program(arguments);
    for (const std::string& text : {result.out, result.error}) {
      EXPECT_THAT(text, Not(HasSubstr("\x1b"))) << arguments[0];
      EXPECT_THAT(text, Not(HasSubstr("\x07"))) << arguments[0];
      EXPECT_THAT(text, Not(HasSubstr("\x7f"))) << arguments[0];
      EXPECT_THAT(text, Not(HasSubstr("\xc2\x9b"))) << arguments[0];
    }
    EXPECT_THAT(result.out + result.error, testing::AnyOf(HasSubstr("\\x1b"), HasSubstr("\\u001b")))
        << arguments[0];
  }
}

}  // namespace
}  // namespace loopstone::test
