#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace loopstone {

/// Fit to stand in HTML text and attributes. Bytes that are no UTF-8 become U+FFFD.
[[nodiscard]] std::string escape_html(std::string_view text);

/// RFC 4648.
[[nodiscard]] std::string base64(std::string_view bytes);

/// 13631 as "13,631".
[[nodiscard]] std::string with_thousands(std::int64_t value);

/// Three significant digits and never an exponent for everyday sizes: 0.0123, 1.23, 12.3, 1,234.
/// "n/a" when not finite.
[[nodiscard]] std::string readable(double value);

/// 75.2 as "1 min 15 s", 3700 as "1 h 01 min"; below a minute "12.3 s".
[[nodiscard]] std::string readable_time(double seconds);

/// 1536 as "1.5 KiB".
[[nodiscard]] std::string readable_bytes(std::int64_t bytes);

}  // namespace loopstone
