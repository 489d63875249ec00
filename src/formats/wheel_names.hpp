#pragma once

#include <compare>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace loopstone {

enum class WheelRow { kOnly, kFront, kRear };

/// Which wheel of a robot. A robot with two wheels has only sides.
struct WheelSpot {
  bool is_left = false;
  WheelRow row = WheelRow::kOnly;
  auto operator<=>(const WheelSpot&) const = default;
};

/// The words of a name in lower case: "base", "to", "left", "wheel" of "base_to_LeftWheel". Letters
/// that stick to a word for a wheel or a side are words of their own: "l", "wheel" of "lwheel".
[[nodiscard]] std::vector<std::string> words_of_name(std::string_view name);

/// The spot that words tell; nothing when they name no side, or both.
[[nodiscard]] std::optional<WheelSpot> spot_of(const std::vector<std::string>& words);

/// The words without those that tell a spot, joined: what the names of one robot's wheels share.
[[nodiscard]] std::string without_spot(const std::vector<std::string>& words);

/// The spot of a joint or frame that is named like a wheel which drives the robot: not a caster,
/// what steers a wheel, lets it drop or turns something else.
[[nodiscard]] std::optional<WheelSpot> wheel_spot(std::string_view name);

/// Whether the name of a joint says that it steers wheels.
[[nodiscard]] bool is_steering(std::string_view name);

/// Whether the name of a topic or field says that it is what somebody wants, not what was measured.
[[nodiscard]] bool is_command(std::string_view name);

}  // namespace loopstone
