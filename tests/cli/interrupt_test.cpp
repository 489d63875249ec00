// Ctrl-C: at once, everywhere, with exit code 130, and what is written says whether it is complete.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "run_program.hpp"
#include "support/temp_dir.hpp"

namespace loopstone::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using testing::HasSubstr;
using Words = std::vector<std::string>;

constexpr int kInterrupted = 130;

TEST(Interrupt, WhoOnlyReadsEndsAtOnceAndLeavesNothing) {
  // Nothing ever comes out of a pipe that somebody holds open: any file that takes long to read.
  for (const std::string& name : Words{"graph.g2o", "cloud.ply", "a.tum", "map.yaml"}) {
    const TempDir dir;
    const std::string pipe = dir / name;
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    const std::string out = dir / "out";
    const Words arguments = name == "graph.g2o"   ? Words{"optimize", pipe, "-o", out}
                            : name == "cloud.ply" ? Words{"match", pipe, pipe, "--png", out}
                            : name == "a.tum"
                                ? Words{"evaluate", "--estimate", pipe, "--reference", pipe}
                                : Words{"evaluate", "--map", pipe, "--true-map", pipe};
    const ProgramResult result = interrupt_reader(pipe, arguments);
    EXPECT_EQ(result.exit_code, kInterrupted) << name << ": " << result.error;
    EXPECT_EQ(result.error, "loopstone: interrupted: nothing was written\n") << name;
    EXPECT_EQ(dir.names(), Words{name});
  }
}

TEST(Interrupt, TheExitCodeAndTheSummaryAgreeWheneverItComes) {
  const TempDir dir;
  ASSERT_EQ(run_program({"simulate", "office", "-o", dir / "sim", "--duration", "6", "--beams",
                         "121", "--fov", "180", "--quiet"})
                .exit_code,
            0);
  // The last one comes while results are put in place: there is nothing left to be interrupted.
  for (const char* const moment : {"", "/session.loopstone", "/trajectory.tum"}) {
    const std::string out = dir / ("out" + std::to_string(fs::path(moment).string().size()));
    const ProgramResult result = interrupt_program(
        out + moment,
        {"map", dir / "sim", "-o", out, "--realtime", "12", "--checkpoint", "0.05", "--quiet"});
    SCOPED_TRACE(moment + result.error);
    const std::string path = out + "/summary.json";
    if (!fs::exists(path)) {
      EXPECT_EQ(result.exit_code, kInterrupted);
      continue;
    }
    const Json summary = Json::parse(dir.read(fs::relative(path, dir.path()).string()));
    EXPECT_EQ(result.exit_code, summary.at("complete").get<bool>() ? 0 : kInterrupted);
  }
}

TEST(Interrupt, ASimulationTellsThatItIsIncomplete) {
  const TempDir dir;
  const std::string out = dir / "sim";
  const ProgramResult result =
      interrupt_program(out, {"simulate", "office", "-o", out, "--json", "--quiet"});
  EXPECT_EQ(result.exit_code, kInterrupted) << result.error;
  EXPECT_EQ(Json::parse(result.out).at("complete"), false);
  EXPECT_EQ(Json::parse(dir.read("sim/world.json")).at("complete"), false);
  EXPECT_THAT(result.error, HasSubstr("interrupted"));
}

}  // namespace
}  // namespace loopstone::test
