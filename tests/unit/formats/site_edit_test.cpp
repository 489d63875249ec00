#include "loopstone/formats/site_edit.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

using testing::HasSubstr;

std::string refusal(const std::string& text) {
  try {
    (void)parse_polygon(text);
  } catch (const UsageError& error) {
    return error.what();
  }
  return {};
}

TEST(SitePolygon, IsReadAsItIsWritten) {
  const Polygon2 polygon{{{-1.5, 2.0}, {0.1, 1e-3}, {4.0 / 3.0, 7.25}}};
  EXPECT_EQ(parse_polygon(polygon_text(polygon)), polygon);
  EXPECT_EQ(parse_polygon("  -1.5,2   +0.1,1e-3\n1.3333333333333333,7.25 "), polygon);
}

TEST(SitePolygon, WhatIsNoneIsSaid) {
  EXPECT_THAT(refusal(""), HasSubstr("three corners"));
  EXPECT_THAT(refusal("0,0 1,0"), HasSubstr("three corners"));
  EXPECT_THAT(refusal("0,0 1,0 one,1"), HasSubstr("'one,1' is no corner"));
  EXPECT_THAT(refusal("0,0 1,0 1"), HasSubstr("'1' is no corner"));
  EXPECT_THAT(refusal("0,0 1,0 1,1,1"), HasSubstr("is no corner"));
  EXPECT_THAT(refusal("0,0 1,0 1,nan"), HasSubstr("is no corner"));
  EXPECT_THAT(refusal("0,0 1,0 1,1e9"), HasSubstr("is no corner"));
  EXPECT_THAT(refusal("0,0 1,1 1,0 0,1"), HasSubstr("cross"));
  EXPECT_THAT(refusal("0,0 1,1 2,2"), HasSubstr("must"));
  std::string many;
  for (int i = 0; i < 1001; ++i) many += "1,1 ";
  EXPECT_THAT(refusal(many), HasSubstr("1000 corners"));
}

}  // namespace
}  // namespace loopstone
