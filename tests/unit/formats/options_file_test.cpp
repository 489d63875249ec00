#include "loopstone/formats/options_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace loopstone {
namespace {

using testing::HasSubstr;
using testing::Not;

struct Inner {
  double max_range_m = 80.0;
  int beams = 180;
};

template <typename Visitor>
void visit_options(Inner& options, Visitor&& visit) {
  visit("max_range_m", options.max_range_m, Range{0.1, 1000.0}, "returns beyond are ignored");
  visit("beams", options.beams, Range{1, 2000}, "of a scan");
}

enum class Kernel { kHuber, kCauchy };

constexpr auto words_of(Kernel /*any*/) {
  return std::array{Word{Kernel::kHuber, "huber"}, Word{Kernel::kCauchy, "cauchy"}};
}

struct Outer {
  bool fast = false;
  Kernel kernel = Kernel::kHuber;
  std::string name = "plain";
  Inner front_end{};
  Inner loop{12.5, 90};
};

template <typename Visitor>
void visit_options(Outer& options, Visitor&& visit) {
  visit.group("front_end", options.front_end);
  visit("fast", options.fast, "in a hurry");
  visit("kernel", options.kernel, "of the residuals");
  visit("name", options.name, "for people");
  visit.group("loop", options.loop);
}

TEST(OptionsFile, ListsEveryFieldWithItsGroup) {
  Outer options;
  const auto entries = list_options(options);
  std::vector<std::string> keys;
  for (const OptionEntry& entry : entries) keys.push_back(entry.key);
  EXPECT_THAT(keys, testing::ElementsAre("front_end.max_range_m", "front_end.beams", "fast",
                                         "kernel", "name", "loop.max_range_m", "loop.beams"));
}

TEST(OptionsFile, FileOverridesDefaultsAndNothingElse) {
  Outer options;
  const auto problems =
      apply_toml(list_options(options), "fast = true\n[front_end]\nmax_range_m = 20\n", "o.toml");
  EXPECT_TRUE(problems.empty());
  EXPECT_TRUE(options.fast);
  EXPECT_EQ(options.front_end.max_range_m, 20.0) << "a whole number serves as a real one";
  EXPECT_EQ(options.front_end.beams, 180);
  EXPECT_EQ(options.loop.max_range_m, 12.5);
}

TEST(OptionsFile, AllProblemsComeAtOnceWithKeyValueRuleAndLine) {
  Outer options;
  const auto problems = apply_toml(list_options(options),
                                   "fast = 1\n"
                                   "kernal = \"huber\"\n"
                                   "[front_end]\n"
                                   "max_range_m = -3.0\n"
                                   "beams = 2.5\n"
                                   "[loop]\n"
                                   "beams = 99999999999\n"
                                   "max_range_m = nan\n",
                                   "o.toml");
  ASSERT_EQ(problems.size(), 6u);
  EXPECT_EQ(to_string(problems[0]), "o.toml:1: fast = 1: must be true or false");
  EXPECT_EQ(to_string(problems[1]), "o.toml:2: kernal: unknown key; did you mean kernel?");
  EXPECT_EQ(to_string(problems[2]),
            "o.toml:4: front_end.max_range_m = -3.0: must be a number from 0.1 to 1000");
  EXPECT_EQ(to_string(problems[3]),
            "o.toml:5: front_end.beams = 2.5: must be a whole number from 1 to 2000");
  EXPECT_THAT(to_string(problems[4]), HasSubstr("o.toml:7: loop.beams"));
  EXPECT_THAT(to_string(problems[5]), HasSubstr("o.toml:8: loop.max_range_m"));
  EXPECT_EQ(options.front_end.max_range_m, 80.0) << "a refused value changes nothing";
}

TEST(OptionsFile, BrokenTomlNamesItsLine) {
  Outer options;
  const auto problems = apply_toml(list_options(options), "fast = true\nkernel = [\n", "o.toml");
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_THAT(to_string(problems[0]), HasSubstr("o.toml:"));
  EXPECT_THAT(to_string(problems[0]), HasSubstr("not valid TOML"));
}

TEST(OptionsFile, WordsOfTheParserAreNotShown) {
  Outer options;
  const auto entries = list_options(options);
  const auto problems = apply_toml(entries, "fast = true\nfast = yes please\n", "o.toml");
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_THAT(to_string(problems[0]), HasSubstr("o.toml:2: not valid TOML"));
  EXPECT_THAT(to_string(problems[0]), HasSubstr("'fast = yes please'"));
  EXPECT_THAT(to_string(problems[0]), Not(HasSubstr("Error while parsing")));
}

TEST(OptionsFile, DepthIsBoundedBeforeItIsParsed) {
  Outer options;
  const auto entries = list_options(options);
  const auto rule = [&](const std::string& toml) {
    const auto problems = apply_toml(entries, toml, "o.toml");
    return problems.size() == 1 ? to_string(problems[0]) : std::to_string(problems.size());
  };
  std::string dotted = "a";
  std::string nested;
  for (int i = 0; i < 100'000; ++i) dotted += ".a";
  for (int i = 0; i < 200; ++i) nested += "{a = ";
  EXPECT_THAT(rule("fast = true\n" + dotted + " = 1\n"), HasSubstr("o.toml:2: more than 32"));
  EXPECT_THAT(rule("[" + dotted + "]\n"), HasSubstr("more than 32"));
  EXPECT_THAT(rule("[[" + dotted + "]]\n"), HasSubstr("more than 32"));
  EXPECT_THAT(rule("x = {y = 1, " + dotted + " = 1}\n"), HasSubstr("more than 32"));
  EXPECT_THAT(rule("x = " + nested), HasSubstr("more than 32"));
  EXPECT_THAT(rule("x = " + std::string(1000, '[')), HasSubstr("more than 32"));
  // Texts do not hide what follows them.
  for (const char* const text :
       {R"("\\\"" )", R"('\' )", "\"\"\"\n\"\"\"\"", "'''\n\"'''", "\"#\" ", "\"\" "}) {
    EXPECT_THAT(rule("x = {y = " + std::string(text) + ", " + dotted + " = 1}\n"),
                HasSubstr("more than 32"))
        << text;
  }
  EXPECT_THAT(rule("# " + dotted + "\nkernel = \"" + dotted + "\"\n"), HasSubstr("must be one of"));
  EXPECT_THAT(rule(std::string(2'000'000, ' ')), HasSubstr("megabyte"));
}

TEST(OptionsFile, UnreadableFilesAreProblems) {
  Outer options;
  EXPECT_EQ(apply_options_file(list_options(options), "/no/such/file.toml").size(), 1u);
  EXPECT_EQ(apply_options_file(list_options(options), "/").size(), 1u);
}

TEST(OptionsFile, AssignmentsNeedNoQuotes) {
  Outer options;
  const auto entries = list_options(options);
  EXPECT_TRUE(apply_assignment(entries, "kernel=cauchy").empty());
  EXPECT_TRUE(apply_assignment(entries, "front_end.max_range_m = 7").empty());
  EXPECT_TRUE(apply_assignment(entries, "fast=true").empty());
  EXPECT_EQ(options.kernel, Kernel::kCauchy);
  EXPECT_EQ(options.front_end.max_range_m, 7.0);
  EXPECT_TRUE(options.fast);
  EXPECT_TRUE(apply_assignment(entries, "kernel=\"huber\"").empty());
  EXPECT_EQ(options.kernel, Kernel::kHuber);
  EXPECT_TRUE(apply_assignment(entries, "name=any text").empty());
  EXPECT_EQ(options.name, "any text");
}

TEST(OptionsFile, BadAssignmentsSayWhatIsWrong) {
  Outer options;
  const auto entries = list_options(options);
  const auto only = [&](const char* text) {
    const auto problems = apply_assignment(entries, text);
    return problems.size() == 1 ? to_string(problems[0]) : "not one problem";
  };
  EXPECT_THAT(only("kernel"), HasSubstr("key=value"));
  EXPECT_THAT(only("=3"), HasSubstr("key=value"));
  EXPECT_THAT(only("kernel=tukey"), HasSubstr("one of huber, cauchy"));
  EXPECT_THAT(only("kernel=1"), HasSubstr("one of huber, cauchy"));
  EXPECT_THAT(only("kernel="), HasSubstr("one of huber, cauchy"));
  EXPECT_THAT(only("max_rang_m=3"), HasSubstr("did you mean front_end.max_range_m?"));
  EXPECT_THAT(only("front_end=3"), HasSubstr("is a group"));
  EXPECT_THAT(only("zzzzzzzzzz=3"), HasSubstr("unknown key"));
  EXPECT_THAT(only("front_end.beams=1\nfast=true"), HasSubstr("whole number"));
  EXPECT_FALSE(options.fast);
}

TEST(OptionsFile, WhatIsWrittenReadsBackTheSame) {
  Outer options;
  options.front_end.max_range_m = 0.1 + 0.2;
  options.loop.max_range_m = 5.0;
  options.loop.beams = 7;
  options.fast = true;
  options.kernel = Kernel::kCauchy;
  options.name = "a \"quoted\" one";
  const std::string toml = options_to_toml(list_options(options));
  Outer read;
  EXPECT_TRUE(apply_toml(list_options(read), toml, "o.toml").empty()) << toml;
  EXPECT_EQ(read.front_end.max_range_m, options.front_end.max_range_m);
  EXPECT_EQ(read.loop.beams, 7);
  EXPECT_TRUE(read.fast);
  EXPECT_EQ(read.kernel, Kernel::kCauchy);
  EXPECT_EQ(read.name, options.name);
  EXPECT_THAT(toml, HasSubstr("# of the residuals (one of huber, cauchy)\nkernel = \"cauchy\"\n"));
  EXPECT_EQ(options_to_toml(list_options(read)), toml);
  EXPECT_THAT(toml, HasSubstr("# returns beyond are ignored (a number from 0.1 to 1000)"));
  EXPECT_LT(toml.find("fast"), toml.find("[front_end]")) << "free options stand before the tables";
}

TEST(NearestKey, FindsTypingErrorsAndForgottenGroups) {
  const std::vector<std::string> known{"front_end.max_range_m", "loop.min_score", "threads"};
  EXPECT_EQ(nearest_key("thread", known), "threads");
  EXPECT_EQ(nearest_key("loop.minscore", known), "loop.min_score");
  EXPECT_EQ(nearest_key("min_score", known), "loop.min_score");
  EXPECT_EQ(nearest_key("qqqqqqq", known), "");
}

}  // namespace
}  // namespace loopstone
