#pragma once

#include <cmath>

#include "loopstone/base/error.hpp"

namespace loopstone {

// What the restore() of an object asks of the state that it is given. A state may come from a file,
// and say anything there.

/// Refuses a state that the object can't have had. Throws UsageError; who has the state from a file
/// says which. \param what  the state is then
inline void require_sound(bool holds, const char* what) {
  if (!holds) throw UsageError(what);
}

/// Of something counted one by one: not negative, and far from where counting on would overflow.
[[nodiscard]] constexpr bool is_count(int number) { return number >= 0 && number < (1 << 30); }

/// Finite, and not negative.
[[nodiscard]] inline bool is_amount(double value) { return value >= 0.0 && std::isfinite(value); }

}  // namespace loopstone
