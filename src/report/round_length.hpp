#pragma once

namespace loopstone {

/// 1, 2 or 5 times a power of ten: the greatest of them that is not above. `value` is positive.
[[nodiscard]] double round_down(double value);
/// ... the least of them that is not below.
[[nodiscard]] double round_up(double value);

}  // namespace loopstone
