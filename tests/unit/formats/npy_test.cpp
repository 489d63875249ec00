#include "formats/npy.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "formats/kept_stamps.hpp"
#include "formats/npz.hpp"
#include "formats/npz_writer.hpp"
#include "loopstone/base/error.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

NpyArray read(const std::string& bytes) { return read_npy(memory_byte_source(bytes), "test.npy"); }

template <typename T>
std::string raw(std::initializer_list<T> values) {
  std::string bytes(values.size() * sizeof(T), '\0');
  std::memcpy(bytes.data(), values.begin(), bytes.size());
  return bytes;
}

std::string file(const std::string& descr, std::initializer_list<std::int64_t> shape,
                 const std::string& data, bool fortran = false) {
  return npy_head(descr, fortran, std::span(shape.begin(), shape.size())) + data;
}

TEST(Npy, EveryNumericType) {
  const std::vector<double> wanted{1, 2, 3};
  EXPECT_EQ(read(file("<f8", {3}, raw<double>({1, 2, 3}))).values, wanted);
  EXPECT_EQ(read(file("<f4", {3}, raw<float>({1, 2, 3}))).values, wanted);
  EXPECT_EQ(read(file("<f2", {3}, raw<std::uint16_t>({0x3c00, 0x4000, 0x4200}))).values, wanted);
  EXPECT_EQ(read(file("<i8", {3}, raw<std::int64_t>({1, 2, 3}))).values, wanted);
  EXPECT_EQ(read(file("<i4", {3}, raw<std::int32_t>({1, 2, 3}))).values, wanted);
  EXPECT_EQ(read(file("<i2", {3}, raw<std::int16_t>({1, 2, 3}))).values, wanted);
  EXPECT_EQ(read(file("|i1", {3}, raw<std::int8_t>({1, 2, 3}))).values, wanted);
  EXPECT_EQ(read(file("<u8", {3}, raw<std::uint64_t>({1, 2, 3}))).values, wanted);
  EXPECT_EQ(read(file("<u4", {3}, raw<std::uint32_t>({1, 2, 3}))).values, wanted);
  EXPECT_EQ(read(file("<u2", {3}, raw<std::uint16_t>({1, 2, 3}))).values, wanted);
  EXPECT_EQ(read(file("|u1", {3}, raw<std::uint8_t>({1, 2, 3}))).values, wanted);
  EXPECT_EQ(read(file("|b1", {2}, raw<std::uint8_t>({1, 0}))).values, (std::vector<double>{1, 0}));
  EXPECT_EQ(read(file("<i2", {1}, raw<std::int16_t>({-7}))).values[0], -7.0);
  EXPECT_EQ(read(file("<f2", {2}, raw<std::uint16_t>({0x7c00, 0x8001}))).values,
            (std::vector<double>{HUGE_VAL, -std::ldexp(1.0, -24)}));
}

TEST(Npy, BigEndian) {
  std::string bytes = raw<double>({3, 2, 1});
  std::reverse(bytes.begin(), bytes.end());
  EXPECT_EQ(read(file(">f8", {3}, bytes)).values, (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(read(file(">i2", {2}, std::string("\x01\x02\xff\xfe", 4))).values,
            (std::vector<double>{258, -2}));
}

TEST(Npy, BothOrdersAndSingleNumbers) {
  const NpyArray c = read(file("<f8", {2, 3}, raw<double>({1, 2, 3, 4, 5, 6})));
  const NpyArray fortran = read(file("<f8", {2, 3}, raw<double>({1, 4, 2, 5, 3, 6}), true));
  for (int row = 0; row < 2; ++row) {
    for (int column = 0; column < 3; ++column) {
      EXPECT_EQ(c.at(row, column), 3 * row + column + 1);
      EXPECT_EQ(fortran.at(row, column), c.at(row, column));
    }
  }
  EXPECT_EQ(read(file("<f8", {}, raw<double>({42}))).at(0), 42.0);
  EXPECT_TRUE(read(file("<f8", {4, 0}, "")).values.empty());
}

TEST(Npy, VersionsTwoAndThree) {
  for (const char version : {'\x02', '\x03'}) {
    const std::string dict = "{'descr': '<i2', 'fortran_order': False, 'shape': (2,), }\n";
    std::string bytes("\x93NUMPY");
    bytes.push_back(version);
    bytes.push_back('\0');
    bytes.append(raw<std::uint32_t>({static_cast<std::uint32_t>(dict.size())}));
    bytes.append(dict);
    EXPECT_EQ(read(bytes + raw<std::int16_t>({5, 6})).values, (std::vector<double>{5, 6}));
  }
}

TEST(Npy, DamageIsRefused) {
  const std::string good = file("<f8", {3}, raw<double>({1, 2, 3}));
  for (std::size_t length = 0; length < good.size(); ++length) {
    EXPECT_THROW((void)read(good.substr(0, length)), DataError) << length;
  }
  EXPECT_THROW((void)read(file("|O", {3}, "")), DataError);
  EXPECT_THROW((void)read(file("<c8", {3}, std::string(100, 'x'))), DataError);
  EXPECT_THROW((void)read(file("<U3", {3}, std::string(100, 'x'))), DataError);
  EXPECT_THROW((void)read(file("<f8", {1, 1, 1}, raw<double>({1}))), DataError);
  // Promises terabytes: must fail at the end of the data, without having reserved them.
  EXPECT_THROW((void)read(file("<f8", {1 << 20, 1 << 20}, raw<double>({1}))), DataError);
  EXPECT_THROW((void)read(file("<f8", {std::int64_t{1} << 40, std::int64_t{1} << 40}, "")),
               DataError);
  EXPECT_THROW((void)read(file("<f8", {-1}, "")), DataError);
}

TEST(Npz, WrittenAndReadBack) {
  const test::TempDir folder;
  NpzWriter writer(folder / "a.npz");
  writer.add_number("one", 1.5);
  const std::vector<double> row(10'000, 2.0);
  writer.add_row("row", row);
  writer.write().commit();
  const NpzFile read(folder / "a.npz");
  EXPECT_TRUE(read.has("one"));
  EXPECT_FALSE(read.has("two"));
  EXPECT_EQ(read.read("one").at(0), 1.5);
  EXPECT_EQ(read.read("row").values, row);
  EXPECT_EQ(read.keys().size(), 2u);
  try {
    (void)read.read("two");
    FAIL();
  } catch (const DataError& error) {
    EXPECT_NE(std::string(error.what()).find("one, row"), std::string::npos) << error.what();
  }
}

TEST(Npz, RubbishIsRefused) {
  const test::TempDir folder;
  EXPECT_THROW(NpzFile("/does/not/exist.npz"), DataError);
  EXPECT_THROW(NpzFile{folder.path().string()}, DataError);
  EXPECT_THROW(NpzFile(folder.write("a.npz", "PK\x03\x04 and then nothing")), DataError);
}

TEST(KeptStamps, KeepsAllThatIsInOrder) {
  const double nan = std::nan("");
  const double seconds[] = {1, 2, 900, 3, 3, nan, 4, 0.5, 1e30, 5};
  const KeptStamps kept = keep_increasing(seconds);
  EXPECT_EQ(kept.indices, (std::vector<std::int64_t>{0, 1, 3, 6, 9}));
  ASSERT_EQ(kept.refused.size(), 5u);
  EXPECT_EQ(kept.refused[0].index, 2);
  EXPECT_NE(kept.refused[1].reason.find("same stamp"), std::string::npos);
  EXPECT_NE(kept.refused[2].reason.find("not finite"), std::string::npos);
}

TEST(KeptStamps, AsManyAsAnExhaustiveSearchKeeps) {
  // Every row of seven stamps out of 0..3.
  for (int code = 0; code < 4 * 4 * 4 * 4 * 4 * 4 * 4; ++code) {
    double seconds[7];
    for (int i = 0, rest = code; i < 7; ++i, rest /= 4) seconds[i] = rest % 4;
    std::size_t best = 0;
    for (unsigned subset = 0; subset < 128; ++subset) {
      double last = -1.0;
      std::size_t size = 0;
      for (int i = 0; i < 7; ++i) {
        if ((subset >> i & 1U) == 0) continue;
        size = seconds[i] > last ? size + 1 : 0;
        if (size == 0) break;
        last = seconds[i];
      }
      best = std::max(best, size);
    }
    ASSERT_EQ(keep_increasing(seconds).stamps.size(), best) << code;
  }
}

}  // namespace
}  // namespace loopstone
