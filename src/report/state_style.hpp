#pragma once

#include <string>

#include "loopstone/localization/localization_result.hpp"
#include "report/canvas.hpp"

namespace loopstone {

/// Blue, amber and a dark pink: told apart by hue, and by lightness where eyes tell no hues
/// (tests/unit/report). The style sheet (report_style.hpp) has the same on a light ground.
[[nodiscard]] inline Colour state_colour(LocalizationState state) {
  switch (state) {
    case LocalizationState::kTracking:
      return hex_colour(0x0072b2);
    case LocalizationState::kDoubtful:
      return hex_colour(0xe69f00);
    case LocalizationState::kLost:
      break;
  }
  return hex_colour(0xb0004e);
}

/// Readable on state_colour().
[[nodiscard]] inline Colour state_text_colour(LocalizationState state) {
  return state == LocalizationState::kDoubtful ? hex_colour(0x1f2937) : hex_colour(0xffffff);
}

/// "tracking", "doubtful", "lost", as the style sheet calls them.
[[nodiscard]] inline std::string state_css_class(LocalizationState state) {
  switch (state) {
    case LocalizationState::kTracking:
      return "tracking";
    case LocalizationState::kDoubtful:
      return "doubtful";
    case LocalizationState::kLost:
      break;
  }
  return "lost";
}

inline const Colour kParticleColour = hex_colour(0x00875a);
inline const Colour kScanColour = hex_colour(0xff5a1f);

}  // namespace loopstone
