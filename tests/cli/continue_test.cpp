// map --keep-state and --continue: another drive goes on with a map.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <tuple>
#include <vector>

#include "loopstone/formats/tum.hpp"
#include "run_program.hpp"
#include "support/temp_dir.hpp"

namespace loopstone::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using Json = nlohmann::json;

class ContinueCommand : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempDir;
    for (const auto& [name, world, seconds] : {std::tuple{"first", "office", "60"},
                                               {"second", "office", "30"},
                                               {"elsewhere", "warehouse", "30"}}) {
      const ProgramResult made =
          run_program({"simulate", world, "-o", *folder_ / name, "--seed", "3", "--duration",
                       seconds, "--beams", "361", "--quiet"});
      ASSERT_EQ(made.exit_code, 0) << made.error;
    }
    const ProgramResult mapped =
        run_program({"map", *folder_ / "first", "-o", *folder_ / "map", "--keep-state", "--quiet"});
    ASSERT_EQ(mapped.exit_code, 0) << mapped.error;
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  static ProgramResult go_on(const std::string& log, const std::string& out,
                             std::vector<std::string> more = {}) {
    more.insert(more.begin(), {"map", *folder_ / log, "--continue", *folder_ / "map", "-o",
                               *folder_ / out, "--quiet"});
    return run_program(more);
  }
  static Json summary_of(const std::string& out) {
    return Json::parse(folder_->read(out + "/summary.json"));
  }

  static inline TempDir* folder_ = nullptr;
};

TEST_F(ContinueCommand, ASecondDriveJoinsTheMapOfTheFirst) {
  const std::string before = folder_->read("map/trajectory.tum");
  const ProgramResult result = go_on("second", "both");
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const Json summary = summary_of("both");
  ASSERT_EQ(summary.at("drives").size(), 1U);
  EXPECT_EQ(summary.at("drives")[0].at("joined"), true);
  const Trajectory first = read_tum(*folder_ / "both/trajectory_drive_1.tum");
  const Trajectory second = read_tum(*folder_ / "both/trajectory_drive_2.tum");
  EXPECT_EQ(first.size() + second.size(), summary.at("scans").get<std::size_t>());
  EXPECT_EQ(second.front().stamp, read_tum(*folder_ / "second/truth.tum").front().stamp);
  EXPECT_EQ(folder_->read("map/trajectory.tum"), before);
  // And so on.
  ASSERT_EQ(go_on("second", "kept", {"--keep-state"}).exit_code, 0);
  const ProgramResult third = run_program({"map", *folder_ / "second", "--continue",
                                           *folder_ / "kept", "-o", *folder_ / "three", "-q"});
  ASSERT_EQ(third.exit_code, 0) << third.error;
  EXPECT_EQ(summary_of("three").at("drives").size(), 2U);
}

TEST_F(ContinueCommand, AnotherBuildingIsSaidNotToBeFound) {
  const ProgramResult result = go_on("elsewhere", "apart");
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("it is drawn beside it"));
  EXPECT_EQ(summary_of("apart").at("drives")[0].at("joined"), false);
}

TEST_F(ContinueCommand, SaysWhatIsWrongWithTheState) {
  const ProgramResult none = run_program(
      {"map", *folder_ / "second", "--continue", *folder_ / "first", "-o", *folder_ / "no"});
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.error, HasSubstr("--keep-state"));
  const ProgramResult other = go_on("second", "no", {"--set", "front_end.points_max=200"});
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_THAT(other.error, HasSubstr("points_max"));
  fs::create_directory(*folder_ / "bad");
  std::string bytes = folder_->read("map/state.loopstone");
  bytes[bytes.size() / 2] ^= 1;
  std::ofstream(*folder_ / "bad/state.loopstone", std::ios::binary) << bytes;
  const ProgramResult damaged = run_program(
      {"map", *folder_ / "second", "--continue", *folder_ / "bad", "-o", *folder_ / "no"});
  EXPECT_EQ(damaged.exit_code, 1);
  EXPECT_THAT(damaged.error, HasSubstr("checksum"));
  EXPECT_EQ(go_on("second", "no", {"--resume"}).exit_code, 2);
  EXPECT_FALSE(fs::exists(*folder_ / "no"));
}

}  // namespace
}  // namespace loopstone::test
