#pragma once

#include <string>

#include "messages/layout.hpp"

// What is said of a type in words and numbers, from its layout alone.

namespace loopstone {

/// The definition with those of the types that it uses.
[[nodiscard]] std::string definition_text(const Layout& layout, WireFormat format);
/// ROS 1's, of a layout for kRos1.
[[nodiscard]] std::string md5_of(const Layout& layout);
/// ROS 2's, of a layout for kCdr. Source: REP-2016.
[[nodiscard]] std::string rihs01_of(const Layout& layout);

}  // namespace loopstone
