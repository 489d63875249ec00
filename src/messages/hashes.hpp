#pragma once

#include <string>
#include <string_view>

// The hashes that ROS tells types apart by; for nothing that has to be secret.

namespace loopstone {

/// 32 hexadecimal digits. Source: RFC 1321.
[[nodiscard]] std::string md5_of(std::string_view bytes);
/// 64 hexadecimal digits. Source: FIPS 180-4.
[[nodiscard]] std::string sha256_of(std::string_view bytes);

}  // namespace loopstone
