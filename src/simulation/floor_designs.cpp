#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/base/linear_light.hpp"
#include "loopstone/simulation/floor_pattern.hpp"
#include "simulation/letters.hpp"

// The built-in patterns, as functions of a point of the patch. Everything in them repeats after
// kPatch, which is a whole number of tiles, planks and flecks.

namespace loopstone {
namespace {

constexpr int kTexels = 2048;
constexpr double kTexel = 0.002;             ///< [m]
constexpr double kPatch = kTexels * kTexel;  ///< [m]
constexpr double kQuarter = 0.5 * kPatch;    ///< side of a quarter of `mixed` [m]

/// Even in [0, 1), from three numbers.
float even_of(std::uint64_t seed, std::int64_t a, std::int64_t b) {
  std::uint64_t h = seed * 0x9e3779b97f4a7c15U +
                    static_cast<std::uint64_t>(a) * 0xbf58476d1ce4e5b9U +
                    static_cast<std::uint64_t>(b) * 0x94d049bb133111ebU;
  h = (h ^ (h >> 31U)) * 0xd6e8feb86659fd93U;
  h = (h ^ (h >> 29U)) * 0xa0761d6478bd642fU;
  h ^= h >> 32U;
  return static_cast<float>(h >> 40U) * 0x1p-24F;
}

/// Even numbers at the corners of cells, smoothly joined (Perlin's value noise); repeats with the
/// patch when its sides are whole numbers of cells. Mean 0.5.
float noise_at(const Eigen::Vector2d& p, double cell_x_m, double cell_y_m, std::uint64_t seed) {
  const auto nx = static_cast<std::int64_t>(std::lround(kPatch / cell_x_m));
  const auto ny = static_cast<std::int64_t>(std::lround(kPatch / cell_y_m));
  const double u = p.x() / kPatch * static_cast<double>(nx);
  const double v = p.y() / kPatch * static_cast<double>(ny);
  const auto i = static_cast<std::int64_t>(std::floor(u));
  const auto j = static_cast<std::int64_t>(std::floor(v));
  const auto smooth = [](double t) { return static_cast<float>(t * t * (3.0 - 2.0 * t)); };
  const float a = smooth(u - static_cast<double>(i));
  const float b = smooth(v - static_cast<double>(j));
  const auto corner = [&](std::int64_t di, std::int64_t dj) {
    return even_of(seed, (i + di + nx) % nx, (j + dj + ny) % ny);
  };
  const float low = corner(0, 0) * (1.0F - a) + corner(1, 0) * a;
  const float high = corner(0, 1) * (1.0F - a) + corner(1, 1) * a;
  return low * (1.0F - b) + high * b;
}

LinearColour tiles_at(const Eigen::Vector2d& p, std::uint64_t seed) {
  constexpr double kTile = 0.256;
  constexpr double kHalfJoint = 0.003;
  const auto i = static_cast<std::int64_t>(std::floor(p.x() / kTile));
  const auto j = static_cast<std::int64_t>(std::floor(p.y() / kTile));
  const double x = p.x() - static_cast<double>(i) * kTile;
  const double y = p.y() - static_cast<double>(j) * kTile;
  const double to_joint = std::min(std::min(x, kTile - x), std::min(y, kTile - y));
  const float fine = noise_at(p, 0.008, 0.008, seed + 1);
  if (to_joint < kHalfJoint) return LinearColour(0.16F, 0.15F, 0.14F) * (0.85F + 0.3F * fine);
  const bool is_dark = even_of(seed + 2, i, j) < 0.14F;
  const LinearColour glaze =
      is_dark ? LinearColour(0.25F, 0.1F, 0.06F) : LinearColour(0.55F, 0.5F, 0.42F);
  const float cloud = noise_at(p, 0.064, 0.064, seed + 3);
  return glaze * (0.82F + 0.16F * even_of(seed + 4, i, j) + 0.16F * cloud + 0.08F * fine);
}

LinearColour carpet_at(const Eigen::Vector2d& p, std::uint64_t seed) {
  constexpr double kDiamond = 0.256;
  const double x = p.x() / kDiamond - std::floor(p.x() / kDiamond) - 0.5;
  const double y = p.y() / kDiamond - std::floor(p.y() / kDiamond) - 0.5;
  const double rim = std::abs(std::abs(x) + std::abs(y) - 0.42);
  const LinearColour yarn =
      rim < 0.035 ? LinearColour(0.4F, 0.3F, 0.16F) : LinearColour(0.06F, 0.1F, 0.2F);
  const float tuft = noise_at(p, 0.008, 0.008, seed + 1);
  const float shade = noise_at(p, 0.128, 0.128, seed + 2);
  return yarn * (0.45F + 0.8F * tuft + 0.3F * shade);
}

LinearColour wood_at(const Eigen::Vector2d& p, std::uint64_t seed) {
  constexpr double kWidth = 0.128;
  constexpr double kLength = 1.024;
  const auto row = static_cast<std::int64_t>(std::floor(p.y() / kWidth));
  const double shift = kLength * static_cast<double>(even_of(seed, row, 7));
  const double along = p.x() + shift;
  const auto plank = static_cast<std::int64_t>(std::floor(along / kLength)) % 4;
  const double x = along - kLength * std::floor(along / kLength);
  const double y = p.y() - static_cast<double>(row) * kWidth;
  if (std::min(y, kWidth - y) < 0.0015 || std::min(x, kLength - x) < 0.0015) {
    return {0.04F, 0.025F, 0.015F};
  }
  const float grain = noise_at(p, 0.256, 0.008, seed + 1);
  const float vein = noise_at(p, 0.512, 0.032, seed + 2);
  const float tone = even_of(seed + 3, plank, row);
  return LinearColour(0.38F, 0.2F, 0.085F) *
         (0.55F + 0.5F * tone + 0.3F * grain + (vein > 0.72F ? -0.12F : 0.12F));
}

LinearColour linoleum_at(const Eigen::Vector2d& p, std::uint64_t seed) {
  const float fleck = noise_at(p, 0.016, 0.016, seed + 1);
  const float cloud = noise_at(p, 0.256, 0.256, seed + 2);
  return LinearColour(0.6F, 0.6F, 0.54F) * (0.86F + 0.1F * fleck + 0.14F * cloud);
}

/// A line of text, from its lower left corner to at most a length.
struct TextLine {
  double x_m = 0.0;
  double y_m = 0.0;
  double length_m = 0.0;
  double height_m = 0.05;
  std::size_t sentence = 0;
};

constexpr std::array<std::string_view, 6> kSentences{
    "THE QUICK BROWN FOX JUMPS OVER THE LAZY DOG. 0123456789 ",
    "A ROBOT THAT KNOWS WHERE IT IS CAN READ ITS OWN FLOOR. ",
    "PACK MY BOX WITH FIVE DOZEN LIQUOR JUGS. 7314 2860 95 ",
    "LINES MEET AGAIN WHERE THE LOOP IS CLOSED - OR THEY DO NOT. ",
    "SPHINX OF BLACK QUARTZ JUDGE MY VOW. ROOM 204 EXIT 17 ",
    "HOW VEXINGLY QUICK DAFT ZEBRAS JUMP. 360 480 640 1081 ",
};

void add_line(const TextLine& line, std::vector<FloorLetter>& letters) {
  const std::string_view sentence = kSentences[line.sentence % kSentences.size()];
  const double advance = line.height_m * (kLetterColumns + 1) / kLetterRows;
  const auto count = static_cast<std::size_t>(line.length_m / advance);
  for (std::size_t i = 0; i < count; ++i) {
    const char letter = sentence[i % sentence.size()];
    if (letter == ' ') continue;
    letters.push_back(
        {letter, {line.x_m + static_cast<double>(i) * advance, line.y_m, 0.0}, line.height_m});
  }
}

/// Lines of the usual 50 mm with larger and smaller ones between them, from low to high.
void add_page(const Extent& page, std::vector<FloorLetter>& letters) {
  constexpr std::array kHeights{0.05, 0.05, 0.08, 0.05, 0.035, 0.05, 0.05, 0.12, 0.05, 0.025};
  double y = page.low.y() + 0.04;
  for (std::size_t line = 0;; ++line) {
    const double height = kHeights[line % kHeights.size()];
    if (y + height > page.high.y() - 0.03) break;
    add_line({page.low.x() + 0.03, y, page.high.x() - page.low.x() - 0.06, height, line}, letters);
    y += height + std::max(0.03, 0.6 * height);
  }
}

std::vector<FloorLetter> letters_of(std::string_view name) {
  std::vector<FloorLetter> letters;
  if (name == "text") add_page({{0.0, 0.0}, {kPatch, kPatch}}, letters);
  if (name == "mixed") {
    add_page({{kQuarter, kQuarter}, {kPatch, kPatch}}, letters);
    for (std::size_t line = 0; line < 4; ++line) {
      const double y = 0.1 + 0.512 * static_cast<double>(line);  // within a row of tiles
      add_line({0.02, y, kQuarter - 0.04, 0.05, line + 2}, letters);
    }
  }
  return letters;
}

LinearColour background_at(std::string_view name, const Eigen::Vector2d& p, std::uint64_t seed) {
  if (name == "tiles") return tiles_at(p, seed);
  if (name == "carpet") return carpet_at(p, seed);
  if (name == "wood") return wood_at(p, seed);
  if (name == "text") return linoleum_at(p, seed);
  const bool is_right = p.x() >= kQuarter;
  const bool is_upper = p.y() >= kQuarter;
  if (is_right) return is_upper ? linoleum_at(p, seed) : carpet_at(p, seed + 100);
  return is_upper ? wood_at(p, seed + 200) : tiles_at(p, seed + 300);
}

/// Blends ink over the texels that a letter's dots cover, by the covered share of 4 x 4 points of
/// each.
void paint(const FloorLetter& letter, std::vector<LinearColour>& texels) {
  constexpr int kPoints = 4;
  const LinearColour ink(0.02F, 0.02F, 0.03F);
  const double dot = letter.height_m / kLetterRows;
  const Eigen::Vector2d low = letter.map_T_letter.translation();
  const auto first_x = static_cast<int>(std::floor(low.x() / kTexel));
  const auto first_y = static_cast<int>(std::floor(low.y() / kTexel));
  const auto last_x = static_cast<int>(std::floor((low.x() + kLetterColumns * dot) / kTexel));
  const auto last_y = static_cast<int>(std::floor((low.y() + letter.height_m) / kTexel));
  for (int y = first_y; y <= last_y; ++y) {
    for (int x = first_x; x <= last_x; ++x) {
      int inked = 0;
      for (int k = 0; k < kPoints * kPoints; ++k) {
        const double px = (x + (k % kPoints + 0.5) / kPoints) * kTexel - low.x();
        const double py = (y + (k / kPoints + 0.5) / kPoints) * kTexel - low.y();
        if (px < 0.0 || py < 0.0) continue;
        const auto row = kLetterRows - 1 - static_cast<int>(py / dot);
        if (is_inked(letter.letter, static_cast<int>(px / dot), row)) ++inked;
      }
      LinearColour& texel = texels[static_cast<std::size_t>(y & (kTexels - 1)) * kTexels +
                                   static_cast<std::size_t>(x & (kTexels - 1))];
      const float share = static_cast<float>(inked) / (kPoints * kPoints);
      texel = texel * (1.0F - share) + ink * share;
    }
  }
}

int power_of_two_at_least(int value, int most) {
  int power = 1;
  while (power < value && power < most) power *= 2;
  return power;
}

}  // namespace

const std::vector<std::string_view>& floor_names() {
  static const std::vector<std::string_view> names{"tiles", "carpet", "wood", "text", "mixed"};
  return names;
}

FloorPattern make_floor(std::string_view name, std::uint64_t seed) {
  const auto& names = floor_names();
  if (std::find(names.begin(), names.end(), name) == names.end()) {
    std::string known;
    for (const std::string_view other : names) {
      known += (known.empty() ? "" : ", ") + std::string(other);
    }
    throw UsageError("there is no floor \"" + std::string(name) + "\"; there are " + known +
                     ", or give a PNG picture");
  }
  std::vector<LinearColour> texels;
  texels.reserve(static_cast<std::size_t>(kTexels) * kTexels);
  for (int row = 0; row < kTexels; ++row) {
    for (int column = 0; column < kTexels; ++column) {
      texels.push_back(
          background_at(name, {(column + 0.5) * kTexel, (row + 0.5) * kTexel}, seed * 1000));
    }
  }
  std::vector<FloorLetter> letters = letters_of(name);
  for (const FloorLetter& letter : letters) paint(letter, texels);
  return FloorPattern(kTexels, kTexels, {kTexel, kTexel}, texels, std::move(letters));
}

FloorPattern make_floor(const ColourImage& picture, double width_m) {
  if (picture.empty() || picture.width <= 0 || picture.height <= 0 || !(width_m > 0.0)) {
    throw UsageError("the picture of a floor needs at least one pixel and a positive width");
  }
  constexpr int kMostTexels = 4096;
  constexpr int kPoints = 4;  // of each texel, in x and y
  const int columns = power_of_two_at_least(picture.width, kMostTexels);
  const int rows = power_of_two_at_least(picture.height, kMostTexels);
  std::array<float, 256> linear{};
  for (std::size_t i = 0; i < linear.size(); ++i) {
    linear[i] = static_cast<float>(linear_of_srgb(static_cast<double>(i) / 255.0));
  }
  std::vector<LinearColour> texels;
  texels.reserve(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  const double step_x = static_cast<double>(picture.width) / columns;
  const double step_y = static_cast<double>(picture.height) / rows;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      LinearColour sum = LinearColour::Zero();
      for (int k = 0; k < kPoints * kPoints; ++k) {
        const double x = (column + (k % kPoints + 0.5) / kPoints) * step_x;
        const double y = (row + (k / kPoints + 0.5) / kPoints) * step_y;
        // Row 0 of a picture is its top, row 0 of the floor is at low y.
        const std::uint8_t* pixel =
            picture.at(std::min(static_cast<int>(x), picture.width - 1),
                       picture.height - 1 - std::min(static_cast<int>(y), picture.height - 1));
        sum += LinearColour(linear[pixel[0]], linear[pixel[1]], linear[pixel[2]]);
      }
      texels.push_back(sum / static_cast<float>(kPoints * kPoints));
    }
  }
  const double height_m = width_m * picture.height / picture.width;
  return FloorPattern(columns, rows, {width_m / columns, height_m / rows}, texels);
}

}  // namespace loopstone
