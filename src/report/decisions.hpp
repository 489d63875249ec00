#pragma once

#include <span>
#include <string>

#include "loopstone/slam/decision_numbers.hpp"

namespace loopstone {

/// The text of decisions.toml: a table for each algorithm, and behind each number its origin.
[[nodiscard]] std::string format_decisions(std::span<const NumberGroup> groups);

}  // namespace loopstone
