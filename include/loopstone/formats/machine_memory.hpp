#pragma once

#include "loopstone/base/memory_budget.hpp"

namespace loopstone {

/// The default of a program: three quarters of the memory that this process may use (what the
/// machine has, or what its control group is allowed, if that is less), and no more than a budget
/// without a machine allows.
[[nodiscard]] MemoryBudget machine_memory_budget();

}  // namespace loopstone
