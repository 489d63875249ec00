#include "loopstone/formats/relations_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

std::string error_of(std::string_view text) {
  try {
    (void)parse_relations(text, "r.relations");
  } catch (const DataError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(RelationsFile, ReadsStampsToTheNanosecond) {
  const auto relations = parse_relations(
      "# comment\n\n976052905.167303 976052911.885496 -0.056990 -0.128430 0 0 0 -1.682210\r\n"
      "0.000000001 1298445274.541885123 1 2 0 0 0 7");
  ASSERT_EQ(relations.size(), 2u);
  EXPECT_EQ(relations[0].from.nanoseconds, 976052905167303000);
  EXPECT_EQ(relations[0].to.nanoseconds, 976052911885496000);
  EXPECT_EQ(relations[0].from_T_to, (Pose2{-0.05699, -0.12843, -1.68221}));
  EXPECT_EQ(relations[1].from.nanoseconds, 1);
  EXPECT_EQ(relations[1].to.nanoseconds, 1298445274541885123);
  EXPECT_NEAR(relations[1].from_T_to.yaw, 7.0 - 2.0 * kPi, 1e-12) << "kept in (-pi, pi]";
}

TEST(RelationsFile, DamageNamesItsLine) {
  EXPECT_THAT(error_of("0 1 0 0 0 0 0 0\n0 1 2 3"), testing::HasSubstr("r.relations:2: "));
  EXPECT_THAT(error_of("0 1 nan 0 0 0 0 0"), testing::HasSubstr("r.relations:1: "));
  EXPECT_THAT(error_of("x 1 0 0 0 0 0 0"), testing::HasSubstr("not a time"));
  EXPECT_THAT(error_of("0 1 0 0 0 0 0 0 0"), testing::HasSubstr("8 numbers"));
  EXPECT_THAT(error_of(""), testing::HasSubstr("no relation"));
  EXPECT_THAT(error_of("# nothing\n"), testing::HasSubstr("no relation"));
}

}  // namespace
}  // namespace loopstone
