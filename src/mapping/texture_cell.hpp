#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

namespace loopstone {

/// Red, green, blue in linear light, 0 to 65535.
using LinearRgb = std::array<float, 3>;

/// A colour that a cell was seen in, and how much speaks for it.
struct TextureMode {
  std::array<std::uint16_t, 3> rgb{};  ///< weighted mean in linear light
  std::uint16_t weight = 0;            ///< in 1 / kWeightUnit; stays at its maximum
};

/// What is known of a cell's colour: the colour that most speaks for, and its strongest rival. A
/// sample joins the colour it agrees with; if it agrees with none, it wears down the rival and
/// takes its place in the end. So a foot that stood here for a few frames, or a frame at a wrong
/// pose, leaves no trace: the heavier colour is the mode of the samples where a mean would mix
/// them. 16 bytes, whatever the number of frames.
/// Source: Stauffer and Grimson 1999, "Adaptive background mixture models for real-time tracking",
/// for the two modes; Boyer and Moore 1981, "A fast majority vote algorithm", for the wearing down.
struct TextureCell {
  TextureMode best{};
  TextureMode rival{};

  static constexpr float kWeightUnit = 256.0F;
  static constexpr float kMostWeight = 65535.0F;

  [[nodiscard]] bool seen() const { return best.weight > 0; }

  /// \param weight of the sample, (0, 1]
  void add(const LinearRgb& sample, float weight) {
    const float own = std::max(1.0F, weight * kWeightUnit);
    if (best.weight == 0 || agrees(best, sample)) {
      join(best, sample, own);
    } else if (rival.weight == 0 || agrees(rival, sample)) {
      join(rival, sample, own);
    } else if (own >= static_cast<float>(rival.weight)) {
      rival = TextureMode{};
      join(rival, sample, own);
    } else {
      rival.weight = static_cast<std::uint16_t>(static_cast<float>(rival.weight) - own);
    }
    if (rival.weight > best.weight) std::swap(best, rival);
  }

 private:
  /// Two samples of one colour differ by noise, blur and light: some of the value and a little of
  /// the range.
  [[nodiscard]] static bool agrees(const TextureMode& mode, const LinearRgb& sample) {
    constexpr float kShare = 0.3F;
    constexpr float kFloor = 0.02F * 65535.0F;
    for (std::size_t c = 0; c < 3; ++c) {
      const auto known = static_cast<float>(mode.rgb[c]);
      if (std::abs(sample[c] - known) > kFloor + kShare * std::max(sample[c], known)) return false;
    }
    return true;
  }
  static void join(TextureMode& mode, const LinearRgb& sample, float own) {
    const float sum = static_cast<float>(mode.weight) + own;
    const float share = own / sum;
    for (std::size_t c = 0; c < 3; ++c) {
      const auto known = static_cast<float>(mode.rgb[c]);
      const float mean = known + share * (sample[c] - known);
      mode.rgb[c] = static_cast<std::uint16_t>(std::clamp(mean + 0.5F, 0.0F, 65535.0F));
    }
    mode.weight = static_cast<std::uint16_t>(std::min(sum, kMostWeight));
  }
};

}  // namespace loopstone
