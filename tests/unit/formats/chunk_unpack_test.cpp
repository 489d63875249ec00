#include "formats/chunk_unpack.hpp"

#include <gtest/gtest.h>

#include <random>

#include "support/recording_builder.hpp"

namespace loopstone {
namespace {

constexpr std::uint64_t kMost = std::uint64_t{1} << 27;

/// Half of it without any order.
std::string some_bytes(std::size_t size) {
  std::mt19937 random(7);
  std::string bytes(size, 'a');
  for (std::size_t i = 0; i < size; ++i) {
    if (i / 100 % 2 == 0) bytes[i] = static_cast<char>(random() & 0xffU);
  }
  return bytes;
}

TEST(ChunkUnpacker, what_comes_of_a_damaged_chunk_does_not_depend_on_the_chunks_before) {
  const std::string bytes = some_bytes(1'200'000);
  const std::string larger = some_bytes(2'000'000);
  for (const Packing packing : {Packing::kBzip2, Packing::kLz4, Packing::kZstd}) {
    ChunkUnpacker used;
    (void)used.unpack(packing, test::packed(packing, larger), larger.size(), kMost, [] {});
    const std::string whole = test::packed(packing, bytes);
    const std::size_t places = packing == Packing::kBzip2 ? 3 : 60;
    for (std::size_t i = 1; i <= places; ++i) {
      const std::string cut = whole.substr(0, whole.size() * i / (places + 1));
      const std::string spoiled = cut + std::string(whole.size() - cut.size(), 'x');
      for (const std::string& stored : {spoiled, cut}) {
        for (const std::size_t stated : {std::size_t{0}, std::size_t{300'000}, bytes.size()}) {
          ChunkUnpacker fresh;
          const UnpackedChunk first = fresh.unpack(packing, stored, stated, kMost, [] {});
          EXPECT_FALSE(first.damage.empty());
          const UnpackedChunk second = used.unpack(packing, stored, stated, kMost, [] {});
          EXPECT_TRUE(first.bytes == second.bytes)
              << first.bytes.size() << " and " << second.bytes.size() << " bytes, packing "
              << static_cast<int>(packing) << ", stated " << stated;
        }
      }
    }
  }
}

}  // namespace
}  // namespace loopstone
