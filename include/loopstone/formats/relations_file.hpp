#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "loopstone/base/memory_budget.hpp"
#include "loopstone/evaluation/relations.hpp"

namespace loopstone {

/// Reads relations: one `t1 t2 x y z roll pitch yaw` a line, the pose at t2 seen from the one at
/// t1; Unix seconds, read exactly to the nanosecond, metres and radians. Comments (#) and empty
/// lines are skipped; z, roll and pitch dropped. Throws DataError with the line for anything else,
/// and when there is no relation at all.
[[nodiscard]] std::vector<Relation> parse_relations(
    std::string_view text, const std::string& path_for_errors = "relations");

[[nodiscard]] std::vector<Relation> read_relations(const std::string& path,
                                                   const MemoryBudget& budget = {});

}  // namespace loopstone
