#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "loopstone/formats/log_files.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

namespace fs = std::filesystem;
using test::TempDir;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(LogFiles, AFileIsItselfAndASetItsSensors) {
  const TempDir dir;
  const std::string file = dir.write("a.clf", "12345");
  EXPECT_THAT(LogFiles(file).paths(), ElementsAre(file));
  EXPECT_EQ(LogFiles(file).bytes(), 5);
  const std::string hokuyo = dir.write("Hokuyo20.npz", "123");
  const std::string encoders = dir.write("Encoders20.npz", "1");
  dir.write("Hokuyo21.npz", "other");
  const std::string folder = dir.path().string();
  EXPECT_THAT(LogFiles(folder + "#20").paths(), ElementsAre(encoders, hokuyo));
  EXPECT_THAT(LogFiles(hokuyo).paths(), ElementsAre(encoders, hokuyo));
  EXPECT_EQ(LogFiles(folder + "#20").bytes(), 4);
  EXPECT_THAT(LogFiles(dir / "none.clf").paths(), IsEmpty());
}

TEST(LogFiles, WhatBecameOfThemIsSaidWithTheSizes) {
  const TempDir dir;
  const std::string file = dir.write("a.clf", "12345");
  const LogFiles log(file);
  EXPECT_THAT(log.changes(), IsEmpty());
  dir.write("a.clf", "12345678");
  EXPECT_THAT(log.changes(), ElementsAre(HasSubstr("a.clf: grew while it was read, from 5 to 8")));
  dir.write("a.clf", "123");
  EXPECT_THAT(log.changes(), ElementsAre(HasSubstr("shrank while it was read, from 5 to 3")));
  dir.write("a.clf", "54321");
  fs::last_write_time(file, fs::last_write_time(file) + std::chrono::seconds(2));
  EXPECT_THAT(log.changes(), ElementsAre(HasSubstr("was written to while it was read")));
  fs::remove(file);
  EXPECT_THAT(log.changes(), ElementsAre(HasSubstr("was removed while it was read")));
}

TEST(LogFiles, APipeDoesNotChange) {
  EXPECT_THAT(LogFiles("/dev/null").changes(), IsEmpty());
  EXPECT_EQ(LogFiles("/dev/null").bytes(), 0);
}

}  // namespace
}  // namespace loopstone
