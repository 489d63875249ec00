// Small files that claim to be, or unpack to be, far more than an honest file of their size. Each
// is refused before the memory is asked for; the tests that follow each refusal show that the same
// reader takes what is honest.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <cstring>
#include <functional>
#include <initializer_list>

#include "formats/atomic_file.hpp"
#include "formats/float_image.hpp"
#include "formats/npz.hpp"
#include "formats/npz_writer.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/formats/point_cloud_file.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

using test::TempDir;
using testing::AllOf;
using testing::HasSubstr;

std::string error_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const DataError& error) {
    return error.what();
  }
  return "no error";
}

template <typename Number>
std::string raw(Number number, bool big_endian = false) {
  std::string bytes(sizeof number, '\0');
  std::memcpy(bytes.data(), &number, sizeof number);
  return big_endian ? std::string(bytes.rbegin(), bytes.rend()) : bytes;
}

std::string deflated(const std::string& plain) {
  std::string packed(compressBound(plain.size()), '\0');
  uLongf size = packed.size();
  compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
            reinterpret_cast<const Bytef*>(plain.data()), plain.size(), 9);
  packed.resize(size);
  return packed;
}

std::string png_chunk(const std::string& type, const std::string& data) {
  const std::string checked = type + data;
  const auto crc =
      crc32(0, reinterpret_cast<const Bytef*>(checked.data()), static_cast<uInt>(checked.size()));
  return raw(static_cast<std::uint32_t>(data.size()), true) + checked +
         raw(static_cast<std::uint32_t>(crc), true);
}

/// Grey, all of it 0.
std::string png(std::uint32_t width, std::uint32_t height, int bits) {
  const std::size_t row = 1 + (std::size_t{width} * static_cast<std::size_t>(bits) + 7) / 8;
  return std::string("\x89PNG\r\n\x1a\n", 8) +
         png_chunk("IHDR", raw(width, true) + raw(height, true) + static_cast<char>(bits) +
                               std::string(4, '\0')) +
         png_chunk("IDAT", deflated(std::string(row * height, '\0'))) + png_chunk("IEND", "");
}

TEST(MemoryBombs, PicturesOfFarMorePixelsThanTheirFileSays) {
  const std::string one_bit = png(16384, 16384, 1);
  EXPECT_LT(one_bit.size(), 60'000u);
  EXPECT_THAT(error_of([&] { (void)decode_png(one_bit, "m.png"); }),
              AllOf(HasSubstr("m.png: "), HasSubstr("537 MB"), HasSubstr("--max-memory")));
  EXPECT_THAT(error_of([&] { (void)decode_png(png(1 << 20, 2000, 1), "m.png"); }),
              HasSubstr("2^30 pixels"));
  EXPECT_EQ(decode_png(png(2000, 1000, 8)).width, 2000);
}

TEST(MemoryBombs, LargeHonestMapsAreAllowed) {
  // 20,000 x 20,000 pixels of a real map take some megabytes; of one that is empty but for a wall,
  // 0.4.
  const MemoryBudget budget;
  EXPECT_GE(budget.allowed_bytes(400'000, Growth::kPicture), 2 * 400'000'000ull);
  EXPECT_GE(budget.allowed_bytes(2'000'000, Growth::kMap), 27 * 400'000'000ull);
}

TEST(MemoryBombs, MapsAreJudgedByWhatIsMadeOfThem) {
  const TempDir folder;
  folder.write("m.png", png(4000, 4000, 1));
  const std::string yaml =
      "image: m.png\nresolution: 0.05\norigin: [0, 0, YAW]\nnegate: 0\n"
      "occupied_thresh: 0.65\nfree_thresh: 0.196\n";
  const auto with_yaw = [&](const std::string& yaw) {
    return folder.write("m.yaml", std::string(yaml).replace(yaml.find("YAW"), 3, yaw));
  };
  const std::string straight = with_yaw("0");
  EXPECT_EQ(read_ros_map(straight).cells().size(), 16'000'000u);
  EXPECT_THAT(error_of([&] { (void)read_ros_map(straight, {}, 26); }),
              AllOf(HasSubstr("m.png: "), HasSubstr("448 MB")));
  EXPECT_NO_THROW((void)read_ros_map(straight, {.by_file_size = false}, 26));
  folder.write("m.png", png(30'000, 1, 8));
  EXPECT_THAT(error_of([&] { (void)read_ros_map(with_yaw("0.785")); }),
              AllOf(HasSubstr("m.png: "), HasSubstr("450 MB")));
  folder.write("m.png", png(60'000, 1, 8));
  EXPECT_THAT(error_of([&] { (void)read_ros_map(with_yaw("0.785")); }),
              AllOf(HasSubstr("m.png: "), HasSubstr("too large")));
}

TEST(MemoryBombs, DevicesEnd) {
  EXPECT_THAT(error_of([] { (void)read_image("/dev/zero"); }), HasSubstr("a pipe or a device"));
  EXPECT_EQ(read_whole_file("/dev/null"), "");
}

TEST(MemoryBombs, TiffTilesThatAreTheSameBytes) {
  // 64 x 64 tiles of 16 x 16 pixels, each said to lie at the front of the file.
  constexpr std::uint32_t kTiles = 4096;
  std::string file = "II*" + std::string(1, '\0') + raw(std::uint32_t{8});
  std::string entries;
  std::uint16_t count = 0;
  const auto add = [&](std::uint16_t tag, std::uint16_t type, std::uint32_t number,
                       std::uint32_t value) {
    entries += raw(tag) + raw(type) + raw(number) + raw(value);
    ++count;
  };
  const std::uint32_t lists = 8 + 2 + 12 * 11 + 4;
  add(256, 4, 1, 1024);
  add(257, 4, 1, 1024);
  add(258, 3, 1, 16);
  add(259, 3, 1, 1);
  add(262, 3, 1, 1);
  add(277, 3, 1, 1);
  add(322, 3, 1, 16);
  add(323, 3, 1, 16);
  add(324, 4, kTiles, lists);
  add(325, 4, kTiles, lists + 4 * kTiles);
  add(339, 3, 1, 1);
  file += raw(count) + entries + raw(std::uint32_t{0});
  for (std::uint32_t i = 0; i < kTiles; ++i) file += raw(std::uint32_t{0});
  for (std::uint32_t i = 0; i < kTiles; ++i) file += raw(std::uint32_t{512});
  EXPECT_THAT(error_of([&] { (void)decode_tiff(file, "d.tiff"); }), HasSubstr("overlap"));
}

TEST(MemoryBombs, ArraysThatUnpackToGigabytes) {
  const TempDir folder;
  const std::int64_t shape[] = {40'000'000};
  const std::string array = npy_head("|u1", false, shape) + std::string(40'000'000, '\0');
  const std::string member = folder.write("a.npy", array);
  const std::string path = folder / "a.npz";
  NpzWriter writer(path);
  writer.add_file("a", member);
  writer.write().commit();
  EXPECT_THAT(error_of([&] { (void)NpzFile(path).read("a"); }),
              AllOf(HasSubstr("a.npz:a: "), HasSubstr("320 MB"), HasSubstr("--max-memory")));
  EXPECT_EQ(NpzFile(path, {.by_file_size = false}).read("a").values.size(), 40'000'000u);
}

TEST(MemoryBombs, MatricesThatUnpackToGigabytes) {
  const auto element = [](std::uint32_t type, const std::string& data) {
    const std::size_t filling = (8 - data.size() % 8) % 8;
    return raw(type) + raw(static_cast<std::uint32_t>(data.size())) + data +
           std::string(filling, '\0');
  };
  const auto file = [&](std::int32_t rows) {
    const std::string flags = element(6, raw(std::uint32_t{6}) + raw(std::uint32_t{0}));
    const std::string sizes = element(5, raw(rows) + raw(std::int32_t{3}));
    const std::string values = element(2, std::string(3 * static_cast<std::size_t>(rows), '\0'));
    const std::string packed = deflated(element(14, flags + sizes + element(1, "m") + values));
    std::string head("MATLAB 5.0 MAT-file");
    head.resize(124, ' ');
    return head + std::string("\0\1IM", 4) + raw(std::uint32_t{15}) +
           raw(static_cast<std::uint32_t>(packed.size())) + packed;
  };
  EXPECT_EQ(decode_mat_cloud(file(1000)).points.size(), 1000u);
  EXPECT_THAT(error_of([&] { (void)decode_mat_cloud(file(20'000'000), "c.mat"); }),
              AllOf(HasSubstr("c.mat"), HasSubstr("of memory"), HasSubstr("--max-memory")));
}

TEST(MemoryBombs, PackedPoints) {
  // 10 million points of one byte an axis: LZF copies of three bytes that make 264 each.
  constexpr std::size_t kPoints = 10'000'000;
  std::string packed(2, '\0');  // one literal byte
  std::size_t size = 1;
  for (; size + 264 <= 2 * kPoints; size += 264) packed += std::string("\xe0\xff\0", 3);
  const std::string head =
      "VERSION 0.7\nFIELDS x y\nSIZE 1 1\nTYPE U U\nCOUNT 1 1\nWIDTH 10000000\nHEIGHT 1\n"
      "POINTS 10000000\nDATA binary_compressed\n";
  const std::string file = head + raw(static_cast<std::uint32_t>(packed.size())) +
                           raw(static_cast<std::uint32_t>(2 * kPoints)) + packed;
  EXPECT_THAT(error_of([&] { (void)decode_pcd(file, "c.pcd"); }),
              AllOf(HasSubstr("c.pcd: "), HasSubstr("260 MB")));
}

TEST(MemoryBombs, ListsLongerThanAnyFile) {
  const std::string head =
      "ply\nformat binary_little_endian 1.0\nelement face 1\nproperty list uint double i\n"
      "element vertex 1\nproperty float x\nproperty float y\nend_header\n";
  EXPECT_THAT(error_of([&] {
                (void)decode_ply(head + raw(std::uint32_t{0xffffffff}) + std::string(16, '\0'));
              }),
              HasSubstr("cut off"));
}

}  // namespace
}  // namespace loopstone
