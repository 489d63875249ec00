#include <gtest/gtest.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <initializer_list>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "loopstone/formats/log_reader.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

std::string odom_line(int i, int stamp) {
  return "ODOM " + std::to_string(0.01 * i) + " 0 0 0 0 0 " + std::to_string(stamp) + ".5 host 0\n";
}

/// Some thousand messages, every 70th record damaged: more than fits into the queue.
std::string damaged_log() {
  std::string text;
  for (int i = 0; i < 3000; ++i) {
    text += i % 70 == 33 ? std::string("ODOM 1 2 what\n") : odom_line(i, i + 1);
  }
  return text;
}

class ParallelReadAhead : public ::testing::Test {
 protected:
  std::string file(const std::string& text) {
    const std::string path = (folder_.path() / "log.clf").string();
    std::ofstream(path) << text;
    return path;
  }
  test::TempDir folder_;
};

/// All that a caller sees, in the order that it sees it.
std::vector<std::string> seen_of(decltype(open_log) open, const std::string& path,
                                 std::int64_t most = 1'000'000) {
  std::vector<std::string> seen;
  const auto caller = std::this_thread::get_id();
  const auto reader = open(path, {.on_problem = [&](const Problem& problem) {
                             EXPECT_EQ(std::this_thread::get_id(), caller);
                             seen.push_back(to_string(problem.location) + ": " + problem.reason);
                           }});
  for (std::int64_t i = 0; i < most; ++i) {
    const auto message = reader->next();
    seen.push_back(std::to_string(reader->records_skipped()) + " skipped, " +
                   std::to_string(reader->progress().bytes_done) + " of " +
                   std::to_string(reader->progress().bytes_total));
    if (!message) break;
    seen.push_back(std::to_string(stamp_of(*message).nanoseconds) + " " +
                   std::to_string(std::get<OdometryPose>(*message).odom_T_robot.x));
  }
  return seen;
}

TEST_F(ParallelReadAhead, SameMessagesProblemsAndCountsInTheSameOrder) {
  const std::string path = file(damaged_log());
  const auto expected = seen_of(open_log, path);
  ASSERT_GT(expected.size(), 5900U);
  EXPECT_EQ(seen_of(open_log_ahead, path), expected);
}

TEST_F(ParallelReadAhead, WhoStopsEarlySawNoMoreThanThat) {
  const std::string path = file(damaged_log());
  for (const std::int64_t most : {0, 1, 40, 400, 2000}) {
    EXPECT_EQ(seen_of(open_log_ahead, path, most), seen_of(open_log, path, most)) << most;
  }
}

TEST_F(ParallelReadAhead, AnErrorComesWhereItIs) {
  std::string text;
  for (int i = 0; i < 500; ++i) text += odom_line(i, i + 1);
  const std::string path = file(text + "ODOM 1 2 what\n" + odom_line(1, 900));
  const auto messages_before_error = [&](decltype(open_log) open) {
    const auto reader = open(path, {.strict = true});
    int messages = 0;
    EXPECT_THROW(
        {
          while (reader->next()) ++messages;
        },
        DataError);
    return messages;
  };
  const int expected = messages_before_error(open_log);
  EXPECT_GT(expected, 490);
  EXPECT_EQ(messages_before_error(open_log_ahead), expected);
  EXPECT_THROW((void)open_log_ahead((folder_.path() / "none").string()), DataError);
}

/// Two poses, then nothing of use for many blocks.
std::string mostly_garbage() {
  std::string text = odom_line(0, 1) + odom_line(1, 2);
  while (text.size() < (std::size_t{4} << 20)) text += "ODOM 1 2 what is this, please\n";
  return text;
}

TEST_F(ParallelReadAhead, InterruptedAmongBrokenRecordsItStopsThere) {
  const std::string path = file(mostly_garbage());
  for (const auto open : {open_log, open_log_ahead}) {
    std::atomic<bool> is_open{false};
    std::atomic<int> asked{0};
    const auto reader = open(path, {.stop = [&] { return is_open && ++asked > 3; }});
    is_open = true;
    while (reader->next()) {
    }
    EXPECT_LT(reader->progress().bytes_done, std::int64_t{2} << 20);
  }
}

TEST_F(ParallelReadAhead, InterruptedBeforeItIsOpenIsSaidAtOnce) {
  const std::string path = file(mostly_garbage());
  EXPECT_THROW((void)open_log(path, {.stop = [] { return true; }}), ReadingStopped);
}

}  // namespace
}  // namespace loopstone
