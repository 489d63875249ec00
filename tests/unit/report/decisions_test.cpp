#include "report/decisions.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <type_traits>
#include <variant>
#include <vector>

#include "formats/toml_values.hpp"

namespace loopstone {
namespace {

TEST(Decisions, AreAFileThatReadsBack) {
  const std::vector<NumberGroup> groups = decision_numbers();
  const TomlDocument document = parse_toml(format_decisions(groups), "decisions.toml");
  ASSERT_TRUE(document.problems.empty()) << to_string(document.problems.front());
  std::size_t next = 0;
  for (const NumberGroup& group : groups) {
    for (const DecisionNumber& number : group.numbers) {
      ASSERT_LT(next, document.values.size());
      const TomlValue& read = document.values[next++];
      EXPECT_EQ(read.key, group.name + "." + number.name);
      std::visit(
          [&](auto value) {
            using Read = std::conditional_t<std::is_same_v<decltype(value), int>, std::int64_t,
                                            decltype(value)>;
            ASSERT_TRUE(std::holds_alternative<Read>(read.value)) << read.key;
            EXPECT_EQ(std::get<Read>(read.value), static_cast<Read>(value)) << read.key;
          },
          number.value);
    }
  }
  EXPECT_EQ(next, document.values.size());
}

TEST(Decisions, TellTheOriginBesideTheNumber) {
  const std::vector<NumberGroup> groups{
      {"matching", {{"width_m", 0.5, "chosen: by eye"}, {"rounds", 3, "derived: from it"}}},
      {"search", {{"is_fast", true, "measured by bench/speed.py"}}}};
  EXPECT_EQ(format_decisions(groups),
            "# What the map was made and judged by beside its options, for the record.\n"
            "\n[matching]\nwidth_m = 0.5  # chosen: by eye\nrounds = 3  # derived: from it\n"
            "\n[search]\nis_fast = true  # measured by bench/speed.py\n");
}

}  // namespace
}  // namespace loopstone
