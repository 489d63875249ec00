#include "map_target.hpp"
#include "refusal.hpp"

namespace {

/// A room with a door, free inside and unknown outside.
loopstone::Image room() {
  constexpr int kSide = 24;
  constexpr int kWallAt = 3;
  loopstone::Image image = loopstone::make_image(kSide, kSide, 1);
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      const int inside = std::min({row, column, kSide - 1 - row, kSide - 1 - column}) - kWallAt;
      const bool door = inside == 0 && row > 10 && row < 14;
      const std::uint8_t grey = inside < 0 ? 205 : inside == 0 && !door ? 0 : 254;
      image.bytes[static_cast<std::size_t>(row * kSide + column)] = grey;
    }
  }
  return image;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace loopstone;
  static const Image image = room();
  return fuzz::expect_work_or_refusal(fuzz::text_of(data, size), [&] {
    fuzz::use_map(interpret_map(image, parse_map_yaml(fuzz::text_of(data, size))));
  });
}
