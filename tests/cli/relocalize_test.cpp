#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "loopstone/geometry/angle.hpp"
#include "office_command.hpp"
#include "run_program.hpp"
#include "support/temp_dir.hpp"

namespace loopstone::test {
namespace {

using testing::HasSubstr;
using Json = nlohmann::json;

class RelocalizeCommand : public OfficeCommand {
 protected:
  static ProgramResult relocalize(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"relocalize", log_, "--map", map_});
    return run_program(arguments);
  }
  static Pose2 best_of(const Json& json) {
    const Json& pose = json.at("candidates").at(0).at("map_T_robot");
    return {pose.at("x_m"), pose.at("y_m"), pose.at("yaw_rad")};
  }
  static double off_m(const Pose2& pose, const Pose2& truth) {
    return std::hypot(pose.x - truth.x, pose.y - truth.y);
  }
};

TEST_F(RelocalizeCommand, TellsWhereTheFirstScanWasTaken) {
  const ProgramResult result = relocalize({"--json", "--quiet"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(result.error, "");
  const Json json = Json::parse(result.out);
  EXPECT_LT(off_m(best_of(json), truth_.front().pose), 0.1);
  double sum = json.at("none_probability").get<double>();
  double before = 1.0;
  for (const Json& candidate : json.at("candidates")) {
    const double probability = candidate.at("probability").get<double>();
    EXPECT_LE(probability, before);
    before = probability;
    sum += probability;
    EXPECT_EQ(candidate.at("covariance").size(), 9U);
    for (const char* key : {"explained", "violations", "unexpected", "known", "silent"})
      EXPECT_TRUE(candidate.at(key).is_number()) << key;
  }
  EXPECT_LE(sum, 1.0 + 1e-9);
  EXPECT_GT(json.at("candidates").at(0).at("probability").get<double>(), 0.5);
}

TEST_F(RelocalizeCommand, TakesAScanOfAnotherTime) {
  const ProgramResult result = relocalize({"--at", "8", "--json", "--quiet"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const Json json = Json::parse(result.out);
  const Pose2 truth = *truth_.at_clamped(Stamp::from_seconds(json.at("stamp_s")));
  EXPECT_LT(off_m(best_of(json), truth), 0.1);
  EXPECT_GE(json.at("stamp_s").get<double>() - truth_.front().stamp.seconds(), 7.5);
}

TEST_F(RelocalizeCommand, PrintsATable) {
  const ProgramResult result = relocalize({});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  for (const char* text : {"probability", "x [m]", "explained", "none of them"})
    EXPECT_THAT(result.out, HasSubstr(text));
}

TEST_F(RelocalizeCommand, SameAnswerForAnyNumberOfThreads) {
  const auto answer = [](const std::string& threads) {
    Json json = Json::parse(relocalize({"--threads", threads, "--json", "--quiet"}).out);
    json.erase("search_s");
    return json.dump();
  };
  EXPECT_EQ(answer("1"), answer("4"));
}

TEST_F(RelocalizeCommand, SaysWhatIsWrong) {
  const ProgramResult late = relocalize({"--at", "1000"});
  EXPECT_EQ(late.exit_code, 1);
  EXPECT_THAT(late.error, HasSubstr("no laser scan in it from 1000 s on"));
  EXPECT_EQ(relocalize({"--at", "-1"}).exit_code, 2);
  const ProgramResult no_map = run_program({"relocalize", log_});
  EXPECT_EQ(no_map.exit_code, 2);
  EXPECT_THAT(no_map.error, HasSubstr("--map"));
  const ProgramResult missing = run_program({"relocalize", log_, "--map", "nowhere.yaml"});
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_THAT(missing.error, HasSubstr("nowhere.yaml"));
}

TEST_F(RelocalizeCommand, AScanWithoutReturnsIsBadData) {
  const TempDir out;
  std::ofstream(out / "blind.clf") << "FLASER 3 81.83 81.83 81.83 0 0 0 0 0 0 1.0 host 1.0\n";
  const ProgramResult result = run_program({"relocalize", out / "blind.clf", "--map", map_});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.error, HasSubstr("fewer than 10 don't tell a place"));
}

}  // namespace
}  // namespace loopstone::test
