#include "loopstone/base/short_text.hpp"

#include <gtest/gtest.h>

#include <string>

#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

TEST(ShortText, LeavesNumbersThatMeanSomething) {
  for (const std::string text : {"", "x", "7", "a 1.7976931348623157e+308, b -12 c"})
    EXPECT_EQ(with_short_numbers(text), text);
  const std::string forty(40, '9');
  EXPECT_EQ(with_short_numbers("n = " + forty), "n = " + forty);
}

TEST(ShortText, ShortensTheOthers) {
  const std::string long_one(309, '9');
  EXPECT_EQ(with_short_numbers("n = " + long_one + " m"), "n = 999999999999... (309 digits) m");
  const DataError error({"a.tum", 3}, "'" + long_one + "' is no time");
  EXPECT_EQ(std::string(error.what()), "a.tum:3: '999999999999... (309 digits)' is no time");
}

}  // namespace
}  // namespace loopstone
