#include "loopstone/formats/edits_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <variant>
#include <vector>

#include "loopstone/base/option_list.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

/// The problems of a text, as the user reads them.
std::vector<std::string> problems_of(const std::string& toml) {
  std::vector<std::string> lines;
  try {
    (void)parse_edits(toml, "e.toml");
  } catch (const OptionsError& error) {
    for (const OptionProblem& problem : error.problems()) lines.push_back(to_string(problem));
  }
  return lines;
}

constexpr const char* kAll = R"(# every kind
[[edit]]
kind = "delete_closure"
from_t_s = "1305031102.175304123"
to_t_s = 1305031402.5

[[edit]]
kind = "delete_closure"
from_submap = 3
to_submap = 17

[[edit]]
kind = "add_closure"
from_s = 12.5
to_node = 900
x_m = 0.5
y_m = -1
yaw_rad = 3.0
half_window_m = 2.0
half_window_rad = 0.4
force = true

[[edit]]
kind = "ignore"
from_s = 100
to_s = 110.5

[[edit]]
kind = "crop"
box = [-10, -5, 30, 25.5]

[[edit]]
kind = "erase"
polygon = [[0, 0], [1, 0], [1, 1.5]]
anchor_s = 7.0

[[edit]]
kind = "straighten"

[[edit]]
kind = "as_edited"

[[edit]]
kind = "origin"
x_m = 1.0
y_m = 2.0
yaw_rad = 1.5

[[edit]]
kind = "keep_out"
name = "the stairs \"down\""
polygon = [[0, 0], [2, 0], [2, 2], [0, 2]]

[[edit]]
kind = "speed"
box = [0, 0, 1, 1]
percent = 30

[[edit]]
kind = "speed"
box = [0, 0, 1, 1]
limit_m_s = 0.3
)";

TEST(EditsFile, ReadsEveryKindInOrder) {
  const std::vector<MapEdit> edits = parse_edits(kAll, "e.toml");
  ASSERT_EQ(edits.size(), 12U);
  EXPECT_EQ(edits[0].line, 2);
  EXPECT_EQ(edits[2].line, 12);
  const auto& deleted = std::get<DeleteClosure>(edits[0].what);
  EXPECT_EQ(deleted.from.stamp->nanoseconds, 1305031102175304123);
  EXPECT_EQ(deleted.to.stamp->nanoseconds, 1305031402500000000);
  EXPECT_EQ(std::get<DeleteClosure>(edits[1].what).to_submap, 17);
  const auto& added = std::get<AddClosure>(edits[2].what);
  EXPECT_EQ(added.from.drive_s, 12.5);
  EXPECT_EQ(added.to.node, 900);
  EXPECT_EQ(added.guess_from_T_to, (Pose2{0.5, -1.0, 3.0}));
  EXPECT_TRUE(added.force);
  EXPECT_EQ(std::get<CropMap>(edits[4].what).polygon, box_polygon({-10.0, -5.0}, {30.0, 25.5}));
  EXPECT_EQ(edits[5].anchor.drive_s, 7.0);
  EXPECT_EQ(std::get<SetOrigin>(edits[8].what).yaw_rad, 1.5);
  EXPECT_EQ(std::get<KeepOut>(edits[9].what).name, "the stairs \"down\"");
  EXPECT_EQ(std::get<LimitSpeed>(edits[10].what).unit, SpeedUnit::kPercent);
  EXPECT_EQ(std::get<LimitSpeed>(edits[11].what).limit, 0.3);
}

TEST(EditsFile, WrittenAndReadAgainTheyAreTheSame) {
  const std::vector<MapEdit> edits = parse_edits(kAll, "e.toml");
  const std::string text = edits_to_toml(edits);
  EXPECT_EQ(parse_edits(text, "again.toml"), edits);
  EXPECT_EQ(edits_to_toml(parse_edits(text, "again.toml")), text);
}

TEST(EditsFile, NoEditsAreNone) {
  EXPECT_TRUE(parse_edits("", "e.toml").empty());
  EXPECT_TRUE(parse_edits("# nothing yet\n", "e.toml").empty());
}

TEST(EditsFile, TellsAllProblemsAtOnceWithTheirLines) {
  EXPECT_THAT(
      problems_of(R"([[edit]]
kind = "delete_closur"

[[edit]]
kind = "ignore"
from_s = "early"

[[edit]]
from_s = 3

[[edit]]
kind = "crop"
polygon = [[0, 0], [1, 1], [1, 0], [0, 1]]
ancor_s = 3.0

[[edit]]
kind = "straighten"
yaw_rad = 0.1
)"),
      ElementsAre(AllOf(HasSubstr("e.toml:2: "), HasSubstr("must be delete_closure?")),
                  AllOf(HasSubstr("e.toml:4: "), HasSubstr("must tell one of to_s")),
                  AllOf(HasSubstr("e.toml:6: "), HasSubstr("from_s"), HasSubstr("a number")),
                  AllOf(HasSubstr("e.toml:8: "), HasSubstr("must have a kind")),
                  AllOf(HasSubstr("e.toml:13: "), HasSubstr("do not cross")),
                  AllOf(HasSubstr("e.toml:14: "), HasSubstr("did you mean anchor_s?")),
                  AllOf(HasSubstr("e.toml:18: "), HasSubstr("unknown key"))));
}

TEST(EditsFile, RefusesWhatIsNoEdit) {
  EXPECT_THAT(problems_of("kind = \"straighten\"\n"), ElementsAre(HasSubstr("[[edit]]")));
  EXPECT_THAT(problems_of("[edit]\nkind = \"straighten\"\n"), ElementsAre(HasSubstr("[[edit]]")));
  EXPECT_THAT(problems_of("edit = []\n"), ElementsAre(HasSubstr("[[edit]]")));
  EXPECT_THAT(problems_of("[[edit]\n"), ElementsAre(HasSubstr("not valid TOML")));
}

TEST(EditsFile, EachKindHoldsItsOwnRules) {
  const auto problem_of = [](const std::string& keys) {
    const auto problems = problems_of("[[edit]]\n" + keys);
    return problems.size() == 1 ? problems.front() : std::to_string(problems.size());
  };
  EXPECT_THAT(problem_of("kind = \"speed\"\nbox = [0, 0, 1, 1]\n"), HasSubstr("one of percent"));
  EXPECT_THAT(problem_of("kind = \"speed\"\nbox = [0, 0, 1, 1]\npercent = 0\n"),
              HasSubstr("from 1 to 100"));
  EXPECT_THAT(problem_of("kind = \"crop\"\nbox = [0, 0, -1, 1]\n"), HasSubstr("min less than max"));
  EXPECT_THAT(problem_of("kind = \"crop\"\n"), HasSubstr("one of polygon and box"));
  EXPECT_THAT(problem_of("kind = \"crop\"\npolygon = [[0, 0], [1, 0, 0], [1, 1]]\n"),
              HasSubstr("[[x, y]"));
  EXPECT_THAT(problem_of("kind = \"crop\"\npolygon = [[0, 0], [1, \"a\"], [1, 1]]\n"),
              HasSubstr("[[x, y]"));
  EXPECT_THAT(problem_of("kind = \"add_closure\"\nfrom_s = 1\nto_s = 2\nx_m = 1.0\n"),
              HasSubstr("all of x_m"));
  EXPECT_THAT(problem_of("kind = \"add_closure\"\nfrom_s = 1\nfrom_node = 3\nto_s = 2\n"),
              HasSubstr("one of from_s"));
  EXPECT_THAT(problem_of("kind = \"add_closure\"\nfrom_s = 1\nto_s = 2\nforce = 1\n"),
              HasSubstr("true or false"));
  EXPECT_THAT(problem_of("kind = \"delete_closure\"\nfrom_submap = 1\n"), HasSubstr("both"));
  EXPECT_THAT(problem_of("kind = \"delete_closure\"\nfrom_node = -1\nto_node = 2\n"),
              HasSubstr("whole number from 0"));
  EXPECT_THAT(problem_of("kind = \"origin\"\nx_m = 1\n"), HasSubstr("x_m and y_m"));
  EXPECT_THAT(problem_of("kind = \"ignore\"\nfrom_t_s = 1e300\nto_s = 2\n"), HasSubstr("a stamp"));
}

TEST(EditsFile, MoreEditsFollowOnTheMapAsEdited) {
  const test::TempDir dir;
  dir.write("a.toml", "[[edit]]\nkind = \"straighten\"");
  dir.write("b.toml", "# more\n[[edit]]\nkind = \"origin\"\nx_m = 1\ny_m = 2\n");
  const EditsFile both = joined(read_edits_file(dir / "a.toml"), read_edits_file(dir / "b.toml"));
  ASSERT_EQ(both.edits.size(), 3U);
  EXPECT_EQ(kind_of(both.edits[1]), "as_edited");
  EXPECT_EQ(parse_edits(both.text, "both.toml"), both.edits);
  EXPECT_THAT(both.text, HasSubstr("# more"));
}

}  // namespace
}  // namespace loopstone
