#include <gtest/gtest.h>
#include <sys/stat.h>

#include <atomic>
#include <csignal>
#include <fstream>
#include <functional>
#include <string>
#include <thread>
#include <utility>

#include "loopstone/formats/log_reader.hpp"
#include "support/read_log.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

using test::LogContent;

/// More than the survey looks at.
std::string long_log() {
  std::string text;
  for (int i = 0; i < 3000; ++i) {
    text += "FLASER 40";
    for (int beam = 0; beam < 40; ++beam) text += " " + std::to_string(1 + (i + beam) % 7);
    text += " 0 0 0 0 0 0 " + std::to_string(i) + ".5 host 0\n";
  }
  return text;
}

class ThreadedPipeLog : public testing::Test {
 protected:
  void SetUp() override {
    std::signal(SIGPIPE, SIG_IGN);  // readers here leave before the writer is done
    ASSERT_EQ(::mkfifo(pipe().c_str(), 0600), 0);
  }
  [[nodiscard]] std::string pipe() const { return folder_ / "pipe"; }

  /// The log that comes out of the pipe while `text` goes in.
  [[nodiscard]] LogContent read_from_pipe(const std::string& text) const {
    const std::jthread writer([&] { std::ofstream(pipe(), std::ios::binary) << text; });
    return test::read_log(pipe());
  }
  /// What is said of a pipe that ends or goes on for ever.
  [[nodiscard]] std::string refusal(const std::function<bool(std::ostream&)>& write_more) const {
    const std::jthread writer([&] {
      std::ofstream stream(pipe(), std::ios::binary);
      while (stream && write_more(stream)) {
      }
    });
    try {
      (void)open_log(pipe());
    } catch (const DataError& error) {
      return error.what();
    }
    return {};
  }

  test::TempDir folder_;
};

TEST_F(ThreadedPipeLog, GivesWhatTheFileGives) {
  const std::string text = long_log();
  const LogContent of_file = test::read_log(folder_.write("log.clf", text));
  const LogContent of_pipe = read_from_pipe(text);
  EXPECT_EQ(of_pipe.messages.size(), of_file.messages.size());
  ASSERT_EQ(of_pipe.scans.size(), 3000u);
  EXPECT_EQ(of_pipe.scans.back().stamp, of_file.scans.back().stamp);
  EXPECT_EQ(of_pipe.scans.back().ranges_m, of_file.scans.back().ranges_m);
  EXPECT_EQ(of_pipe.skipped, 0);
}

TEST_F(ThreadedPipeLog, TellsLinesFromTheBeginning) {
  const LogContent log = read_from_pipe("# one\nODOM 1 2\n" + long_log());
  ASSERT_EQ(log.problems.size(), 1u);
  EXPECT_EQ(to_string(log.problems[0].location), pipe() + ":2");
}

TEST_F(ThreadedPipeLog, OfNothingIsAnEmptyFile) {
  EXPECT_NE(refusal([](std::ostream&) { return false; }).find("the file is empty"),
            std::string::npos);
}

TEST_F(ThreadedPipeLog, ThatNeverEndsAndHoldsNoLogIsRefused) {
  const std::string zeros(1 << 16, '\0');
  const std::string text =
      refusal([&](std::ostream& stream) { return static_cast<bool>(stream << zeros); });
  EXPECT_NE(text.find("holds no line of a CARMEN log"), std::string::npos) << text;
}

TEST_F(ThreadedPipeLog, WithAnArchiveIsRefused) {
  const std::string text = refusal([](std::ostream& stream) {
    stream << "PK\x03\x04 and so on, long enough";
    return false;
  });
  EXPECT_NE(text.find("archive"), std::string::npos) << text;
}

TEST_F(ThreadedPipeLog, NobodyWritesIntoCanBeLeft) {
  int asked = 0;
  EXPECT_THROW((void)open_log(pipe(), {.stop = [&] { return ++asked > 2; }}), ReadingStopped);
}

TEST_F(ThreadedPipeLog, ThatFallsSilentEndsWhenToldTo) {
  std::atomic<bool> stop{false};
  std::ofstream stream;
  const std::jthread writer([&] {
    stream.open(pipe(), std::ios::binary);
    stream << long_log() << std::flush;
  });
  const auto log = open_log(pipe(), {.stop = [&] { return stop.load(); }});
  EXPECT_TRUE(log->next());
  stop = true;
  int messages = 0;
  while (log->next()) ++messages;
  EXPECT_LT(messages, 6000) << "the writer is still there";
}

TEST(DeviceLog, IsRefused) {
  for (const char* device : {"/dev/zero", "/dev/null"}) {
    try {
      (void)open_log(device);
      FAIL() << device;
    } catch (const DataError& error) {
      EXPECT_EQ(std::string(error.what()), std::string(device) + ": is a device, not a log");
    }
  }
}

TEST(StoppedLog, EndsAtOnce) {
  const test::TempDir folder;
  const std::string path = folder.write("log.clf", long_log());
  EXPECT_THROW((void)open_log(path, {.stop = [] { return true; }}), ReadingStopped);
  for (const auto open : {open_log, open_log_ahead}) {
    std::atomic<bool> stop{false};
    const auto log = open(path, {.stop = [&] { return stop.load(); }});
    EXPECT_TRUE(log->next());
    stop = true;
    while (log->next()) {
    }
    EXPECT_LT(log->progress().bytes_done, log->progress().bytes_total);
  }
}

}  // namespace
}  // namespace loopstone
