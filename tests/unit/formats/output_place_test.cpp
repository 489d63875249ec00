#include "loopstone/formats/output_place.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

#include "formats/atomic_file.hpp"
#include "loopstone/base/error.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

using test::TempDir;
using Names = std::vector<std::string>;

/// The id of a process that was there.
std::string dead_process() {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(0);
  ::waitpid(child, nullptr, 0);
  return std::to_string(child);
}

TEST(OutputPlace, AFileThatCannotBeMadeIsFoundOutAndNothingStays) {
  const TempDir dir;
  require_room(dir / "a.txt", 1);
  EXPECT_TRUE(dir.names().empty());
  EXPECT_THROW(require_room("/proc/a.txt", 1), DataError);
  EXPECT_THROW(require_room(dir / "no/a.txt", 1), DataError);
}

TEST(OutputPlace, MoreThanTheDiskHoldsIsRefusedWithBothNumbers) {
  const TempDir dir;
  constexpr std::int64_t kAll = std::int64_t{1} << 60;
  try {
    require_room(dir / "a.txt", kAll);
    FAIL() << "there is no such disk";
  } catch (const DataError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("a.txt: there are "), std::string::npos) << text;
    EXPECT_NE(text.find(std::to_string(kAll)), std::string::npos) << text;
  }
}

TEST(OutputPlace, OnlyWhatDeadRunsLeftGoes) {
  const TempDir dir;
  const std::string dead = dead_process();
  dir.write(".map.png." + dead + "-0.partial", "half");
  dir.write(".trajectory.tum." + std::to_string(::getpid()) + "-7.partial", "of this process");
  std::filesystem::create_directory(dir / (".RGB20." + dead + ".partial"));
  dir.write(".RGB20." + dead + ".partial/rgb20_1.png", "half");
  const Names others{".map.png." + std::to_string(::getppid()) + "-0.partial", ".notes.partial",
                     ".x.12a-0.partial", "map.png." + dead + "-0.partial"};
  for (const std::string& name : others) dir.write(name, "another's");
  EXPECT_FALSE(holds_nothing(dir.path().string()));
  remove_partial_files(dir.path().string());
  EXPECT_EQ(dir.names(), others);
}

TEST(OutputPlace, ByNameOnlyThatFilesLeftoversGo) {
  const TempDir dir;
  const std::string dead = dead_process();
  const std::string other = ".b.tum." + dead + "-0.partial";
  dir.write(".a.tum." + dead + "-0.partial", "half");
  dir.write(other, "half");
  remove_partial_files(dir.path().string(), "a.tum");
  EXPECT_EQ(dir.names(), Names{other});
  EXPECT_TRUE(holds_nothing(dir.path().string()));
}

TEST(OutputPlace, ATakenTemporaryNameIsNoError) {
  // In a container each run may have the process id of the one that was killed before.
  const TempDir dir;
  const std::string first = AtomicFile(dir / "a.txt").temporary_path();
  const std::size_t dash = first.rfind('-');
  const int next = std::stoi(first.substr(dash + 1)) + 1;
  const std::string taken = first.substr(0, dash + 1) + std::to_string(next) + ".partial";
  dir.write(std::filesystem::path(taken).filename().string(), "half");
  write_file_atomically(dir / "a.txt", "whole");
  EXPECT_EQ(dir.read("a.txt"), "whole");
}

}  // namespace
}  // namespace loopstone
