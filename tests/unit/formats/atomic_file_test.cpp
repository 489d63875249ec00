#include "formats/atomic_file.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <functional>
#include <string>

#include "loopstone/base/error.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

using test::TempDir;

std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const DataError& error) {
    return error.what();
  }
  return "no error";
}

TEST(AtomicFile, AppearsOnlyWithCommit) {
  const TempDir dir;
  {
    AtomicFile file(dir / "a.txt");
    file.write("half");
    EXPECT_FALSE(std::filesystem::exists(dir / "a.txt"));
  }
  EXPECT_TRUE(dir.names().empty()) << "the temporary file stayed";
  AtomicFile file(dir / "a.txt");
  file.write("whole");
  file.finish_writing();
  EXPECT_FALSE(std::filesystem::exists(dir / "a.txt"));
  file.commit();
  EXPECT_EQ(dir.read("a.txt"), "whole");
  EXPECT_EQ(dir.names(), std::vector<std::string>{"a.txt"});
}

TEST(AtomicFile, BytesAreOverwritten) {
  const TempDir dir;
  AtomicFile file(dir / "a.txt");
  file.write("head 0000 tail");
  file.overwrite(5, "1234");
  file.write(" end");
  file.commit();
  EXPECT_EQ(dir.read("a.txt"), "head 1234 tail end");
}

TEST(AtomicFile, OldContentStaysUntilCommit) {
  const TempDir dir;
  dir.write("a.txt", "old");
  {
    AtomicFile file(dir / "a.txt");
    file.write("new");
  }
  EXPECT_EQ(dir.read("a.txt"), "old");
  write_file_atomically(dir / "a.txt", "new");
  EXPECT_EQ(dir.read("a.txt"), "new");
}

TEST(AtomicFile, LargeContentArrivesWhole) {
  const TempDir dir;
  std::string content;
  for (int i = 0; i < 300000; ++i) content += std::to_string(i) + "\n";
  AtomicFile file(dir / "big");
  for (std::size_t at = 0; at < content.size(); at += 1009)
    file.write(std::string_view(content).substr(at, 1009));
  file.commit();
  EXPECT_EQ(read_whole_file(dir / "big"), content);
}

TEST(AtomicFile, MoveHandsOverTheTemporaryFile) {
  const TempDir dir;
  AtomicFile first(dir / "a");
  first.write("x");
  {
    AtomicFile second(std::move(first));
    second.write("y");
    second.commit();
  }
  EXPECT_EQ(dir.read("a"), "xy");
}

TEST(AtomicFile, LinkIsFollowedNotReplaced) {
  const TempDir dir;
  dir.write("real", "old");
  std::filesystem::create_symlink("real", dir.path() / "link");
  write_file_atomically(dir / "link", "new");
  EXPECT_TRUE(std::filesystem::is_symlink(dir.path() / "link"));
  EXPECT_EQ(dir.read("real"), "new");
}

TEST(AtomicFile, FullDiskIsAnErrorThatNamesTheFile) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "this system has no /dev/full";
  const std::string error = error_of([] { write_file_atomically("/dev/full", "x"); });
  EXPECT_NE(error.find("/dev/full: cannot write to this file: No space left"), std::string::npos)
      << error;
  EXPECT_TRUE(std::filesystem::exists("/dev/full"));
}

TEST(AtomicFile, DiskThatFillsUpHalfWayLeavesNothing) {
  const TempDir dir;
  // A limit on the size of files stands in for the disk: write() fails in the middle.
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit small = before;
  small.rlim_cur = 1000000;
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string error =
      error_of([&] { write_file_atomically(dir / "big", std::string(3000000, 'x')); });
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, old_handler);
  EXPECT_NE(error.find("big: cannot write to this file"), std::string::npos) << error;
  EXPECT_TRUE(dir.names().empty());
}

TEST(AtomicFile, MissingFolderAndFolderAsFileAreRefused) {
  const TempDir dir;
  EXPECT_NE(
      error_of([&] { write_file_atomically(dir / "none/a", "x"); }).find("none/a: cannot create"),
      std::string::npos);
  EXPECT_NE(
      error_of([&] { write_file_atomically(dir.path().string(), "x"); }).find("it is a folder"),
      std::string::npos);
  EXPECT_THROW(write_file_atomically("", "x"), UsageError);
  if (::geteuid() != 0) {
    std::filesystem::permissions(dir.path(), std::filesystem::perms::owner_read);
    EXPECT_NE(error_of([&] { write_file_atomically(dir / "a", "x"); }).find("Permission denied"),
              std::string::npos);
    std::filesystem::permissions(dir.path(), std::filesystem::perms::owner_all);
  }
}

TEST(ReadWholeFile, RefusesWhatIsNoFile) {
  const TempDir dir;
  EXPECT_NE(error_of([&] { (void)read_whole_file(dir / "none"); }).find("No such file"),
            std::string::npos);
  EXPECT_NE(error_of([&] { (void)read_whole_file(dir.path().string()); }).find("cannot read"),
            std::string::npos);
  dir.write("big", std::string(100, 'x'));
  EXPECT_NE(error_of([&] { (void)read_whole_file(dir / "big", 99); }).find("larger than 99"),
            std::string::npos);
}

}  // namespace
}  // namespace loopstone
