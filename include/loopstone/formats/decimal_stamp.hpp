#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "loopstone/base/stamp.hpp"

namespace loopstone {

/// Decimal seconds ("1305031102.175304", "1.305e+09", "-0.5") as a stamp, exact: no double in
/// between, digits beyond the ninth are rounded half up. Nothing when the text is no plain number
/// or does not fit 64 bits.
[[nodiscard]] std::optional<Stamp> parse_decimal_stamp(std::string_view text);

/// Seconds with nine digits after the point; parse_decimal_stamp gives the same stamp back.
[[nodiscard]] std::string format_decimal_stamp(Stamp stamp);

}  // namespace loopstone
