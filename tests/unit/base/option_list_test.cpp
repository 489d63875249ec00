#include "loopstone/base/option_list.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

namespace loopstone {
namespace {

using testing::HasSubstr;

struct Inner {
  double max_range_m = 80.0;
  int beams = 180;
};

template <typename Visitor>
void visit_options(Inner& options, Visitor&& visit) {
  visit("max_range_m", options.max_range_m, Range{0.1, 1000.0}, "returns beyond are ignored");
  visit("beams", options.beams, Range{1, 2000}, "of a scan");
}

enum class Kernel { kHuber, kCauchy };

constexpr auto words_of(Kernel /*any*/) {
  return std::array{Word{Kernel::kHuber, "huber"}, Word{Kernel::kCauchy, "cauchy"}};
}

struct Outer {
  bool fast = false;
  Kernel kernel = Kernel::kHuber;
  Inner front_end{};
};

template <typename Visitor>
void visit_options(Outer& options, Visitor&& visit) {
  visit("fast", options.fast, "in a hurry");
  visit("kernel", options.kernel, "of the residuals");
  visit.group("front_end", options.front_end);
}

TEST(OptionProblems, DefaultsAndLimitsAreValid) {
  EXPECT_TRUE(problems(Outer{}).empty());
  EXPECT_TRUE(problems(Outer{true, Kernel::kCauchy, {0.1, 2000}}).empty());
  EXPECT_NO_THROW(require_valid(Outer{}));
}

TEST(OptionProblems, AllAreToldAtOnceWithKeyValueAndRule) {
  const Outer wrong{false, static_cast<Kernel>(2), {-1.0, 2001}};
  const auto found = problems(wrong);
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(found[0].key, "kernel");
  EXPECT_EQ(found[0].value, "unknown");
  EXPECT_EQ(found[0].rule, "must be one of huber, cauchy");
  EXPECT_EQ(found[1].key, "front_end.max_range_m");
  EXPECT_EQ(found[1].value, "-1");
  EXPECT_EQ(found[2].key, "front_end.beams");
  EXPECT_EQ(found[2].rule, "must be a whole number from 1 to 2000");
  try {
    require_valid(wrong);
    FAIL() << "it was let in";
  } catch (const OptionsError& error) {
    EXPECT_EQ(error.problems().size(), 3U);
    EXPECT_THAT(error.what(), HasSubstr("options: front_end.beams = 2001"));
  }
}

TEST(OptionProblems, NoNumberIsInNoRange) {
  for (const double value :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(problems(Outer{false, Kernel::kHuber, {value, 180}}).size(), 1U) << value;
  }
}

}  // namespace
}  // namespace loopstone
