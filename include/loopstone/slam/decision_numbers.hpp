#pragma once

#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace loopstone {

// Beside its options, which are for users, an algorithm decides by numbers that are not. They stand
// in one struct beside the algorithm, each with where it comes from:
//
//   /// What the verdict decides by.
//   struct MapVerdictNumbers {
//     double certified_near_m = 0.10;
//   };
//   inline constexpr MapVerdictNumbers kMapVerdict{};
//
//   template <typename Visitor>
//   void visit_numbers(const MapVerdictNumbers& n, Visitor&& visit) {
//     visit("certified_near_m", n.certified_near_m, "chosen: two cells of a map of 5 cm");
//   }
//
// The origin begins with "derived" (from what), "measured" (by which script of bench/) or "chosen"
// (why). A line in decision_numbers.cpp puts the struct on record with every map.

/// A number that an algorithm decides by.
struct DecisionNumber {
  std::string name{};
  std::variant<bool, int, double> value{};
  std::string origin{};
};

/// The numbers of one algorithm.
struct NumberGroup {
  std::string name{};
  std::vector<DecisionNumber> numbers{};
};

/// The numbers of a struct that visit_numbers tells.
template <typename Numbers>
[[nodiscard]] NumberGroup number_group(std::string_view name, const Numbers& numbers) {
  NumberGroup listed{std::string(name), {}};
  visit_numbers(numbers, [&](std::string_view number, auto value, std::string_view origin) {
    DecisionNumber entry{.name = std::string(number), .origin = std::string(origin)};
    if constexpr (std::is_integral_v<decltype(value)> && !std::is_same_v<decltype(value), bool>) {
      entry.value = static_cast<int>(value);
    } else {
      entry.value = value;
    }
    listed.numbers.push_back(std::move(entry));
  });
  return listed;
}

/// All that a map is made and judged by, beside the options, in the order of the pipeline.
[[nodiscard]] std::vector<NumberGroup> decision_numbers();

}  // namespace loopstone
