#include "loopstone/formats/left_out.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "formats/carmen_reader.hpp"
#include "formats/skip_tally.hpp"
#include "loopstone/formats/log_summary.hpp"

namespace loopstone {
namespace {

std::string flaser(double stamp, double logger = 0.0) {
  return "FLASER 4 1.0 2.0 3.0 " + std::to_string(1.0 + 0.01 * stamp + logger) + " 0 0 0 0 0 0 " +
         std::to_string(stamp) + " host " + std::to_string(logger) + "\n";
}

LogSummary analyse(const std::string& text) {
  const auto log = read_carmen_log(text, {}, "test.clf");
  return analyse_log(*log);
}

bool has_finding(const LogSummary& summary, Severity severity, const std::string& part) {
  for (const Finding& finding : summary.findings) {
    if (finding.severity == severity && finding.text.find(part) != part.npos) return true;
  }
  return false;
}

TEST(SkipTally, ReasonsThatDifferInTheirFiguresAreOne) {
  SkipTally tally;
  tally.add({{{"a.clf", 3}, "the stamp goes back by 0.403 s, too far"}, true});
  tally.add({{{"a.clf", 4}, "a range is 'x1', expected a number"}, true});
  tally.add({{{"a.clf", 5}, "the stamp goes back by 12 s, too far"}, false});
  tally.add({{{"a.clf", 6}, "a range is 'nonsense', expected a number"}, true});
  const SkippedRecords& skipped = tally.skipped();
  EXPECT_EQ(skipped.records, 4);
  EXPECT_EQ(skipped.scans, 3);
  ASSERT_EQ(skipped.reasons.size(), 2u);
  EXPECT_EQ(skipped.reasons[0].records, 2);
  EXPECT_EQ(skipped.reasons[0].first.line, 3);
  EXPECT_EQ(skipped.reasons[1].records, 2);
}

TEST(SkipTally, StaysSmallWhateverTheReasons) {
  SkipTally tally;
  for (int i = 0; i < 1000; ++i)
    tally.add({{{"a.clf", i}, "reason " + std::string(static_cast<std::size_t>(i), 'x')}, false});
  EXPECT_EQ(tally.skipped().records, 1000);
  EXPECT_LE(tally.skipped().reasons.size(), 100u);
}

TEST(LeftOut, SharesLieBetweenNothingAndAll) {
  EXPECT_EQ(LeftOut{}.share(), 0.0);
  const LeftOut all{.skipped = {.records = 3, .scans = 3}};
  EXPECT_EQ(all.share(), 1.0);
  // Lines of odometry between them make the loss of scans look small.
  const LeftOut scans{.skipped = {.records = 8, .scans = 8}, .records_read = 92, .scans_read = 2};
  EXPECT_DOUBLE_EQ(scans.record_share(), 0.08);
  EXPECT_DOUBLE_EQ(scans.share(), 0.8);
}

TEST(LeftOut, NearlyAllIsNotCalledAll) {
  const LeftOut nearly{.skipped = {.records = 99'999, .scans = 99'999},
                       .records_read = 1,
                       .scans_read = 1,
                       .since_s = 0.0};
  EXPECT_NE(nearly.sentence().find("99999 of 100000 scans (99.9 %)"), std::string::npos)
      << nearly.sentence();
}

TEST(LeftOut, BadWordsOfALogBecomeGoodJson) {
  LeftOut left_out;
  left_out.skipped.reasons.push_back({"a range is '\x1b[31m\xff'", {"a.clf", 1}, 1});
  const auto json = nlohmann::json::parse(left_out_json(left_out));
  EXPECT_EQ(json["reasons"].size(), 1u);
  EXPECT_EQ(left_out_json(left_out).find('\x1b'), std::string::npos);
}

TEST(LeftOut, AFewAreANoteManyAWarningAndNearlyAllAnError) {
  const auto judged = [](std::int64_t skipped, std::int64_t read) {
    return judge({.skipped = {.records = skipped, .scans = skipped},
                  .records_read = read,
                  .scans_read = read})
        ->severity;
  };
  EXPECT_FALSE(judge(LeftOut{.records_read = 5}));
  EXPECT_EQ(judged(1, 99), Severity::kNote);
  EXPECT_EQ(judged(10, 90), Severity::kWarning);
  EXPECT_EQ(judged(81, 19), Severity::kWarning);
  EXPECT_EQ(judged(95, 5), Severity::kError);
}

TEST(LeftOut, OdometryThatIsLostDoesNotCostTheMap) {
  const LeftOut odometry{.skipped = {.records = 980}, .records_read = 20, .scans_read = 20};
  EXPECT_EQ(judge(odometry)->severity, Severity::kWarning);
  const LeftOut no_scans{.skipped = {.records = 980}, .records_read = 20};
  EXPECT_EQ(judge(no_scans)->severity, Severity::kError);
}

/// Reads the scans' own stamps whatever they are.
LogSummary analyse_by_header(const std::string& text) {
  LogOptions options;
  options.stamps = StampUse::kHeader;
  const auto log = read_carmen_log(text, options, "test.clf");
  return analyse_log(*log);
}

TEST(LeftOut, StampsThatAreAllTheSameLeaveNoLogWhenTheyMustBeUsed) {
  std::string text;
  for (int i = 0; i < 50; ++i) text += flaser(0.0);
  const LogSummary summary = analyse_by_header(text);
  EXPECT_EQ(summary.left_out.skipped.scans, 49);
  EXPECT_EQ(summary.left_out.scans(), 50);
  EXPECT_TRUE(has_finding(summary, Severity::kError, "49 of 50 scans (98.0 %) were left out"));
  EXPECT_TRUE(has_finding(summary, Severity::kError, "first test.clf:2"));
}

TEST(LeftOut, ALogBackwardsIsNoneByItsStamps) {
  std::string text;
  for (int i = 500; i > 0; --i) text += flaser(i);
  EXPECT_TRUE(has_finding(analyse_by_header(text), Severity::kError, "the stamp goes back by"));
}

TEST(LeftOut, TheTimeOfTheFirstLossIsTold) {
  std::string text;
  for (int i = 0; i < 100; ++i) text += i < 60 ? flaser(i) : "FLASER 4 1 2\n";
  const LogSummary summary = analyse(text);
  ASSERT_TRUE(summary.left_out.since_s);
  EXPECT_NEAR(*summary.left_out.since_s, 59.0, 3.0);
  EXPECT_TRUE(has_finding(summary, Severity::kWarning, "40 of 100 scans (40.0 %)"));
}

TEST(LeftOut, WithoutStampsOfTheSensorsThoseOfTheLoggerAreUsed) {
  std::string text;
  for (int i = 0; i < 50; ++i) text += flaser(0.0, 10.0 + 0.1 * i);
  const LogSummary summary = analyse(text);
  EXPECT_EQ(summary.left_out.skipped.records, 0);
  EXPECT_EQ(summary.lidars.at(0).timing.records, 50);
  EXPECT_NEAR(summary.duration_s(), 4.9, 1e-6);
  EXPECT_TRUE(has_finding(summary, Severity::kWarning, "all scans have the same stamp"));
}

/// The error of opening a log with this text; empty when there is none.
std::string refusal(const std::string& text) {
  try {
    (void)read_carmen_log(text, {}, "test.clf");
  } catch (const DataError& error) {
    return error.what();
  }
  return {};
}

TEST(CarmenRefusal, NamesTheFirstLineAndWhatIsWrongWithIt) {
  const std::string milliseconds = "FLASER 2 1 1 0 0 0 0 0 0 976052857337 host 0.5\n";
  const std::string text = refusal("# a comment\nHELLO 1\n" + milliseconds + milliseconds);
  EXPECT_NE(text.find("test.clf:3: the time is '976052857337'"), std::string::npos) << text;
  EXPECT_NE(text.find("divide it by 1000"), std::string::npos) << text;
}

TEST(CarmenRefusal, SaysThatTheStampIsMissing) {
  const std::string text = refusal("FLASER 2 1 1 0 0 0 0 0 0\n");
  EXPECT_NE(text.find("test.clf:1: the line ends before the time"), std::string::npos) << text;
}

TEST(CarmenRefusal, OfWhatIsNoLogSaysSo) {
  EXPECT_NE(refusal("a b c\nd\n").find("holds no line of a CARMEN log"), std::string::npos);
}

}  // namespace
}  // namespace loopstone
