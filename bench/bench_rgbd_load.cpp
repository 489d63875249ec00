// How many RGB-D frames a second one core loads from files: 640 x 480 colour (8 bits a channel) and
// disparity (16 bits), with the noise of a camera. SUB is how OpenCV and our simulator write PNG
// (level 1), ALL how libpng does by itself (level 6).

#include <benchmark/benchmark.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/formats/rgbd_files.hpp"
#include "loopstone/sensor/camera_geometry.hpp"

namespace loopstone {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 480;

/// A tiled floor with shading, each channel with noise of 3 grey levels.
Image colour_picture() {
  Rng rng(1);
  Image image = make_image(kWidth, kHeight, 3);
  std::size_t at = 0;
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      const bool dark = ((column / 80) + (row / 60)) % 2 == 0;
      const double shade = (dark ? 90.0 : 170.0) + 0.05 * column + 0.08 * row;
      for (int channel = 0; channel < 3; ++channel) {
        const double value = shade - 12.0 * channel + 3.0 * rng.normal();
        image.bytes[at++] = static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L));
      }
    }
  }
  return image;
}

/// A plane seen at an angle, with noise of one disparity step and holes.
Image disparity_picture() {
  Rng rng(2);
  Image image = make_image(kWidth, kHeight, 1, 2);
  for (std::size_t i = 0; i < image.sample_count(); ++i) {
    const double row = static_cast<double>(i / kWidth);
    const double value = 950.0 - 0.8 * row + rng.normal();
    const bool hole = rng.below(50) == 0;
    const auto number = static_cast<std::uint16_t>(hole ? 0 : std::lround(value));
    std::memcpy(image.bytes.data() + 2 * i, &number, sizeof number);
  }
  return image;
}

void colour_png(benchmark::State& state) {
  const std::string bytes = encode_png(colour_picture(), static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(decode_colour(bytes));
  state.counters["bytes"] = static_cast<double>(bytes.size());
}

void depth_png(benchmark::State& state) {
  const std::string bytes = encode_png(disparity_picture(), static_cast<int>(state.range(0)));
  const DepthEncoding encoding;
  const std::vector<float> table = inverse_depth_table(encoding);
  for (auto _ : state) benchmark::DoNotOptimize(decode_depth(bytes, encoding, table));
  state.counters["bytes"] = static_cast<double>(bytes.size());
}

void frame_from_files(benchmark::State& state) {
  const auto folder = std::filesystem::temp_directory_path();
  const std::string own = "loopstone-bench-" + std::to_string(::getpid());
  const std::string colour = (folder / (own + "-c.png")).string();
  const std::string depth = (folder / (own + "-d.png")).string();
  write_png(colour, colour_picture(), static_cast<int>(state.range(0)));
  write_png(depth, disparity_picture(), static_cast<int>(state.range(0)));
  const RgbdLoader loader{CameraModel{}};
  const RgbdFrame frame{.colour_path = colour, .depth_path = depth};
  for (auto _ : state) benchmark::DoNotOptimize(loader.load(frame));
  state.counters["frames/s"] =
      benchmark::Counter(static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
  std::filesystem::remove(colour);
  std::filesystem::remove(depth);
}

BENCHMARK(colour_png)->ArgName("level")->Arg(1)->Arg(6)->Unit(benchmark::kMillisecond);
BENCHMARK(depth_png)->ArgName("level")->Arg(1)->Arg(6)->Unit(benchmark::kMillisecond);
BENCHMARK(frame_from_files)->ArgName("level")->Arg(1)->Arg(6)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace loopstone
