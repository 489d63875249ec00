#include "loopstone/base/error.hpp"

#include <gtest/gtest.h>

namespace loopstone {
namespace {

TEST(Error, LocationNamesFileAndPlace) {
  EXPECT_EQ(to_string(Location{.path = "a/b.clf", .line = 12}), "a/b.clf:12");
  EXPECT_EQ(to_string(Location{.path = "b.npz", .byte_offset = 4096}), "b.npz (byte 4096)");
  EXPECT_EQ(to_string(Location{.path = "c"}), "c");
}

TEST(Error, DataErrorReadsLikeACompilerMessageAndKeepsItsPlace) {
  const DataError error({.path = "log.clf", .line = 3}, "180 ranges announced, 12 found");
  EXPECT_STREQ(error.what(), "log.clf:3: 180 ranges announced, 12 found");
  EXPECT_EQ(error.location().path, "log.clf");
  EXPECT_EQ(error.location().line, 3);
  EXPECT_FALSE(error.location().byte_offset.has_value());
}

TEST(Error, DataAndUsageErrorsAreToldApart) {
  EXPECT_THROW(throw UsageError("no such option"), UsageError);
  try {
    throw DataError({.path = "x"}, "bad");
  } catch (const UsageError&) {
    FAIL() << "a data error is no usage error";
  } catch (const std::runtime_error&) {
  }
}

}  // namespace
}  // namespace loopstone
