// What all subcommands share: help, version, exit codes, option files.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <initializer_list>
#include <string>

#include "loopstone/version.hpp"
#include "run_program.hpp"
#include "source_folder.hpp"
#include "support/temp_dir.hpp"

namespace loopstone::test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

TEST(Program, HelpFitsOnOneScreenAndListsEveryCommand) {
  const ProgramResult result = run_program({"--help"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_LE(count_lines(result.out), 40u);
  for (const char* command :
       {"info", "convert", "simulate", "map", "odometry", "evaluate", "config"}) {
    EXPECT_THAT(result.out, HasSubstr(std::string("  ") + command + " ")) << command;
  }
  EXPECT_THAT(result.out, HasSubstr("Examples:"));
}

TEST(Program, EveryCommandHasHelp) {
  for (const char* command :
       {"info", "convert", "simulate", "map", "odometry", "evaluate", "config"}) {
    const ProgramResult result = run_program({command, "--help"});
    EXPECT_EQ(result.exit_code, 0) << command;
    EXPECT_THAT(result.out, HasSubstr(std::string("loopstone ") + command)) << command;
    EXPECT_EQ(result.error, "") << command;
  }
}

TEST(Program, TellsItsVersion) {
  const ProgramResult result = run_program({"--version"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out, HasSubstr(std::string(kVersion)));
}

TEST(Program, BadUsageIsOneLineAndExitCodeTwo) {
  for (const std::vector<std::string>& arguments :
       std::vector<std::vector<std::string>>{{},
                                             {"odometri", "x"},
                                             {"odometry"},
                                             {"odometry", "x", "--yaw", "stars"},
                                             {"evaluate", "--no-such-flag"},
                                             {"config", "--set", "nonsense"}}) {
    const ProgramResult result = run_program(arguments);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(count_lines(result.error), 1u) << result.error;
    EXPECT_THAT(result.error, StartsWith("loopstone: "));
    EXPECT_EQ(result.out, "");
  }
  EXPECT_THAT(run_program({"odometri"}).error, HasSubstr("did you mean odometry?"));
}

TEST(Program, FlagsOfWordsSayWhichThereAre) {
  const ProgramResult wrong = run_program({"map", "x", "-o", "y", "--odometry", "belief"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_THAT(wrong.error, HasSubstr("belief not in {check,trust,ignore}"));
  const std::string help = run_program({"optimize", "--help"}).out;
  EXPECT_THAT(help, HasSubstr("--initial best|file|odometry|spanning_tree|chordal=best"));
  EXPECT_THAT(help, HasSubstr("--method gauss_newton|levenberg_marquardt|dogleg\n"));
  EXPECT_THAT(help, HasSubstr("--robust none|huber|cauchy|geman_mcclure|tukey|dcs|gnc"));
}

TEST(Program, SmallFilesThatUnpackToGigabytesAreRefused) {
  const TempDir folder;
  const std::string map = folder.write(
      "m.yaml", std::string("image: ") + LOOPSTONE_SOURCE_DIR +
                    "/fuzz/corpus/image/one_bit_16384_square.png\nresolution: 0.05\n"
                    "origin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n");
  const ProgramResult refused = run_program({"evaluate", "--map", map, "--true-map", map});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.error, HasSubstr("one_bit_16384_square.png: "));
  EXPECT_THAT(refused.error, HasSubstr("--max-memory 512M"));
  for (const char* const amount : {"some", "-1G", "1k"}) {
    const ProgramResult wrong =
        run_program({"evaluate", "--map", map, "--true-map", map, "--max-memory", amount});
    EXPECT_EQ(wrong.exit_code, 2) << amount;
    EXPECT_THAT(wrong.error, HasSubstr("--max-memory '")) << amount;
  }
}

TEST(Program, FullStandardOutputIsAnError) {
  const ProgramResult result = run_program_into("/dev/full", {"config"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.error, HasSubstr("standard output"));
}

TEST(Config, PrintsOptionsThatReadBackTheSame) {
  const TempDir folder;
  const ProgramResult first = run_program({"config", "--set", "map.resolution_m=0.1"});
  ASSERT_EQ(first.exit_code, 0) << first.error;
  EXPECT_THAT(first.out, HasSubstr("[map]"));
  EXPECT_THAT(first.out, HasSubstr("\nresolution_m = 0.1\n"));
  const std::string path = folder.write("options.toml", first.out);
  EXPECT_EQ(run_program({"config", "-c", path}).out, first.out);
}

TEST(Config, FlagBeatsFileBeatsDefault) {
  const TempDir folder;
  const std::string path = folder.write("o.toml", "[map]\nresolution_m = 0.2\nmax_range_m = 33\n");
  const ProgramResult result = run_program({"config", "-c", path, "--set", "map.max_range_m=44"});
  EXPECT_THAT(result.out, HasSubstr("\nresolution_m = 0.2\n"));
  EXPECT_THAT(result.out, HasSubstr("\nmax_range_m = 44.0\n"));
}

TEST(Config, AllProblemsOfFileAndFlagsComeAtOnce) {
  const TempDir folder;
  const std::string path = folder.write("o.toml", "[map]\nresolution = 0.2\nmax_range_m = -1\n");
  const ProgramResult result =
      run_program({"config", "-c", path, "--set", "map.hit_probability=7"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.out, "");
  EXPECT_THAT(result.error,
              HasSubstr(path + ":2: map.resolution: unknown key; did you mean map.resolution_m?"));
  EXPECT_THAT(result.error, HasSubstr(path + ":3: map.max_range_m = -1: must be a number from"));
  EXPECT_THAT(result.error, HasSubstr("--set: map.hit_probability = 7: must be a number from"));
}

TEST(Config, AMissingFileIsNamed) {
  const ProgramResult result = run_program({"config", "-c", "/no/such/options.toml"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.error, HasSubstr("/no/such/options.toml"));
}

}  // namespace
}  // namespace loopstone::test
