#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "office_command.hpp"
#include "run_program.hpp"
#include "support/temp_dir.hpp"

namespace loopstone::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using Json = nlohmann::json;

std::string text_of(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

class ExportCommand : public OfficeCommand {
 protected:
  static void SetUpTestSuite() {
    OfficeCommand::SetUpTestSuite();
    out_ = *folder_ / "out";
    const ProgramResult result = run_program({"map", log_, "-o", out_, "--keep-state", "--quiet"});
    ASSERT_EQ(result.exit_code, 0) << result.error;
  }
  static std::string file(const std::string& name) { return *folder_ / name; }
  static inline std::string out_;
};

TEST_F(ExportCommand, WritesAPlanInEveryFormat) {
  const ProgramResult result = run_program(
      {"export", out_, "--svg", file("a.svg"), "--pdf", file("a.pdf"), "--dxf", file("a.dxf"),
       "--geojson", file("a.geojson"), "--anchor", "48.26,11.67,93.5", "--json", "--quiet"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const Json json = Json::parse(result.out);
  EXPECT_EQ(json.at("source"), "scans");
  EXPECT_GT(json.at("structure_m").get<double>(), 10.0);
  EXPECT_GE(json.at("rooms").size(), 1U);
  for (const Json& room : json.at("rooms")) EXPECT_GT(room.at("area_m2").get<double>(), 1.0);
  EXPECT_THAT(text_of(file("a.svg")), HasSubstr("</svg>"));
  EXPECT_EQ(text_of(file("a.pdf")).substr(0, 5), "%PDF-");
  EXPECT_THAT(text_of(file("a.dxf")), HasSubstr("STRUCTURE"));
  const Json plan = Json::parse(text_of(file("a.geojson")));
  EXPECT_EQ(plan.at("features").size(), json.at("rooms").size() + json.at("doors").size() +
                                            json.at("segments").get<std::size_t>());
}

TEST_F(ExportCommand, TakesAnyMapOfMapServer) {
  const ProgramResult result = run_program({"export", map_, "--dxf", file("map.dxf"), "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(Json::parse(result.out).at("source"), "cells");
  EXPECT_THAT(result.error, HasSubstr("--keep-state"));
}

TEST_F(ExportCommand, StraightenedIsTurned) {
  const auto exported = [](const std::string& name, std::vector<std::string> flags) {
    std::vector<std::string> words{"export", out_, "--dxf", file(name), "--quiet"};
    words.insert(words.end(), flags.begin(), flags.end());
    EXPECT_EQ(run_program(words).exit_code, 0);
    return text_of(file(name));
  };
  EXPECT_NE(exported("as_it_is.dxf", {}), exported("straight.dxf", {"--straighten"}));
}

TEST_F(ExportCommand, SameBytesForAnyNumberOfThreads) {
  for (const char* threads : {"1", "4"}) {
    const std::string name = file(std::string("threads") + threads);
    ASSERT_EQ(run_program({"export", out_, "--svg", name + ".svg", "--dxf", name + ".dxf",
                           "--title", "plan", "--threads", threads, "--quiet"})
                  .exit_code,
              0);
  }
  EXPECT_EQ(text_of(file("threads1.svg")), text_of(file("threads4.svg")));
  EXPECT_EQ(text_of(file("threads1.dxf")), text_of(file("threads4.dxf")));
}

TEST_F(ExportCommand, SaysWhatIsWrong) {
  const ProgramResult nothing = run_program({"export", out_});
  EXPECT_EQ(nothing.exit_code, 2);
  EXPECT_THAT(nothing.error, HasSubstr("--svg, --pdf, --dxf or --geojson"));
  const ProgramResult nowhere = run_program({"export", out_, "--geojson", file("b.geojson")});
  EXPECT_EQ(nowhere.exit_code, 2);
  EXPECT_THAT(nowhere.error, HasSubstr("--anchor LAT,LON,BEARING"));
  for (const char* anchor : {"1,2", "91,0,0", "1,200,0", "1,2,north"}) {
    EXPECT_EQ(
        run_program({"export", out_, "--geojson", file("b.geojson"), "--anchor", anchor}).exit_code,
        2)
        << anchor;
  }
  const ProgramResult missing = run_program({"export", file("nowhere"), "--svg", file("b.svg")});
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_THAT(missing.error, HasSubstr("nowhere"));
  fs::create_directory(file("empty"));
  const ProgramResult empty = run_program({"export", file("empty"), "--svg", file("b.svg")});
  EXPECT_EQ(empty.exit_code, 1);
  EXPECT_THAT(empty.error, HasSubstr("there is no map.yaml in this folder"));
  for (const char* name : {"b.svg", "b.geojson"}) EXPECT_FALSE(fs::exists(file(name)));
}

TEST_F(ExportCommand, ReplacesNothingUnasked) {
  std::ofstream(file("mine.svg")) << "mine";
  EXPECT_EQ(run_program({"export", out_, "--svg", file("mine.svg"), "--quiet"}).exit_code, 2);
  EXPECT_EQ(text_of(file("mine.svg")), "mine");
  EXPECT_EQ(run_program({"export", out_, "--svg", file("mine.svg"), "--force"}).exit_code, 0);
}

TEST_F(ExportCommand, ADamagedStateIsNamed) {
  const std::string copy = file("damaged");
  fs::copy(out_, copy);
  fs::resize_file(copy + "/state.loopstone", 1000);
  const ProgramResult result = run_program({"export", copy, "--svg", file("c.svg")});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.error, HasSubstr("state.loopstone"));
  EXPECT_FALSE(fs::exists(file("c.svg")));
}

}  // namespace
}  // namespace loopstone::test
