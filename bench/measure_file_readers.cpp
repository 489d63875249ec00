// Our readers of pictures, clouds and arrays, measured and tried as reader_trials.hpp tells.

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "formats/atomic_file.hpp"
#include "formats/byte_source.hpp"
#include "formats/float_image.hpp"
#include "formats/mat_file.hpp"
#include "formats/npy.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/formats/point_cloud_file.hpp"
#include "reader_trials.hpp"

namespace loopstone::bench {
namespace {

/// As `--max-memory 512M` has it, and no file more than its size may ask for.
const MemoryBudget kBudget{std::uint64_t{512} << 20U};

void digest_image(const Image& image, ValueDigest* digest) {
  if (digest == nullptr) return;
  digest->add_sizes("", static_cast<std::size_t>(image.height),
                    static_cast<std::size_t>(image.width));
  for (int row = 0; row < image.height; ++row) {
    for (int column = 0; column < image.width; ++column) {
      for (int channel = 0; channel < image.channels; ++channel) {
        digest->add(image.sample(row, column, channel));
      }
    }
  }
}

void read_tiff(const std::string& path, ValueDigest* digest) {
  const auto picture = decode_tiff(read_whole_file(path, kBudget.ceiling_bytes), path, kBudget);
  if (const auto* image = std::get_if<Image>(&picture)) return digest_image(*image, digest);
  const auto& floats = std::get<FloatImage>(picture);
  if (digest == nullptr) return;
  digest->add_sizes("", static_cast<std::size_t>(floats.height),
                    static_cast<std::size_t>(floats.width));
  digest->add_all(floats.values);
}

void read_pnm(const std::string& path, ValueDigest* digest) {
  digest_image(decode_pnm(read_whole_file(path, kBudget.ceiling_bytes), path, kBudget), digest);
}

void read_mat(const std::string& path, ValueDigest* digest) {
  const MatFile file = parse_mat(read_whole_file(path, kBudget.ceiling_bytes), path, kBudget);
  if (digest == nullptr) return;
  for (const MatMatrix& matrix : file.matrices) {
    digest->add_sizes(matrix.name, static_cast<std::size_t>(matrix.rows),
                      static_cast<std::size_t>(matrix.columns));
    digest->add_all(matrix.values);
  }
}

void read_npy_file(const std::string& path, ValueDigest* digest) {
  const std::string bytes = read_whole_file(path, kBudget.ceiling_bytes);
  const NpyArray array = read_npy(memory_byte_source(bytes, path), path, kBudget, bytes.size());
  if (digest == nullptr) return;
  digest->add_sizes("", static_cast<std::size_t>(array.rows()),
                    static_cast<std::size_t>(array.columns()));
  for (std::int64_t row = 0; row < array.rows(); ++row) {
    for (std::int64_t column = 0; column < array.columns(); ++column) {
      digest->add(array.at(row, column));
    }
  }
}

template <PointCloud (*kDecode)(std::string_view, const std::string&, const MemoryBudget&)>
void read_cloud(const std::string& path, ValueDigest* digest) {
  const std::string bytes = read_whole_file(path, kBudget.ceiling_bytes);
  digest_cloud(kDecode(bytes, path, kBudget).points, digest);
}

}  // namespace
}  // namespace loopstone::bench

int main(int argc, char** argv) {
  using namespace loopstone;
  using namespace loopstone::bench;
  return reader_main(argc, argv,
                     {{".tif", read_tiff},
                      {".mat", read_mat},
                      {".pcd", read_cloud<decode_pcd>},
                      {".ply", read_cloud<decode_ply>},
                      {".npy", read_npy_file},
                      {".pnm", read_pnm}});
}
