#include "loopstone/formats/point_cloud_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <zlib.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>

#include "formats/lzf.hpp"
#include "formats/mat_file.hpp"
#include "formats/npy.hpp"
#include "loopstone/base/error.hpp"
#include "source_folder.hpp"
#include "support/recorded_data.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

using testing::HasSubstr;

std::string seed(const std::string& name) {
  return std::string(LOOPSTONE_SOURCE_DIR) + "/fuzz/corpus/" + name;
}

std::string bytes_of(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

template <typename T>
std::string raw(std::initializer_list<T> values) {
  std::string bytes(values.size() * sizeof(T), '\0');
  std::memcpy(bytes.data(), values.begin(), bytes.size());
  return bytes;
}

/// As rows, so that a failure shows numbers; NaN becomes -999, which equals itself.
std::vector<std::vector<double>> rows(const PointCloud& cloud) {
  std::vector<std::vector<double>> rows;
  for (const Eigen::Vector3d& p : cloud.points) {
    rows.push_back({p.x(), p.y(), p.z()});
    for (double& value : rows.back()) value = std::isnan(value) ? -999.0 : value;
  }
  return rows;
}
using Rows = std::vector<std::vector<double>>;

template <typename Call>
std::string error_of(Call call) {
  try {
    (void)call();
  } catch (const DataError& error) {
    return error.what();
  }
  return "no error";
}

std::string pcd(const std::string& data, const std::string& points = "POINTS 2\n") {
  return "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\n" +
         points + "DATA " + data;
}

TEST(Pcd, AsciiInAnyOrderWithFieldsOfSeveralNumbers) {
  const PointCloud cloud = read_point_cloud(seed("pcd/ascii_extra_fields.pcd"));
  EXPECT_EQ(rows(cloud), (Rows{{0.5, -1.25, 2}, {3, 4, -5.5}, {-999, -999, -999}, {7.25, 0, 1}}));
  EXPECT_FALSE(cloud.planar);
}

TEST(Pcd, BinaryOfEveryType) {
  const Rows wanted{{0.5, -1.25, 2}, {3, 4, -5}, {1.5, -999, 0}, {7.25, 0, 1}};
  EXPECT_EQ(rows(read_point_cloud(seed("pcd/binary_mixed_types.pcd"))), wanted);
  EXPECT_EQ(rows(read_point_cloud(seed("pcd/compressed_mixed_types.pcd"))), wanted);
  const auto one = [](const std::string& type, const std::string& size, const std::string& data) {
    return rows(decode_pcd("FIELDS x y\nSIZE " + size + " " + size + "\nTYPE " + type + " " + type +
                           "\nWIDTH 1\nDATA binary\n" + data));
  };
  const Rows seven{{7, -8, 0}};
  EXPECT_EQ(one("F", "8", raw<double>({7, -8})), seven);
  EXPECT_EQ(one("F", "4", raw<float>({7, -8})), seven);
  EXPECT_EQ(one("I", "8", raw<std::int64_t>({7, -8})), seven);
  EXPECT_EQ(one("I", "4", raw<std::int32_t>({7, -8})), seven);
  EXPECT_EQ(one("I", "2", raw<std::int16_t>({7, -8})), seven);
  EXPECT_EQ(one("I", "1", raw<std::int8_t>({7, -8})), seven);
  EXPECT_EQ(one("U", "8", raw<std::uint64_t>({7, 8})), (Rows{{7, 8, 0}}));
  EXPECT_EQ(one("U", "4", raw<std::uint32_t>({7, 8})), (Rows{{7, 8, 0}}));
  EXPECT_EQ(one("U", "2", raw<std::uint16_t>({7, 65535})), (Rows{{7, 65535, 0}}));
  EXPECT_EQ(one("U", "1", raw<std::uint8_t>({7, 255})), (Rows{{7, 255, 0}}));
}

TEST(Pcd, DamageIsNamedWithItsPlace) {
  EXPECT_THAT(error_of([] { return decode_pcd(pcd("ascii\n1 2 3\n4.00 5.00\n"), "a.pcd"); }),
              HasSubstr("a.pcd:11: has 2 numbers, a point has 3"));
  EXPECT_THAT(error_of([] { return decode_pcd(pcd("ascii\n1 2 3\n4 x 5\n"), "a.pcd"); }),
              HasSubstr("a.pcd:11: 'x' is no number"));
  EXPECT_THAT(error_of([] { return decode_pcd(pcd("ascii\n1 2 3\n   \n\n\n\n")); }),
              HasSubstr("holds 1 of the 2 points"));
  EXPECT_THAT(error_of([] { return decode_pcd(pcd("binary\n" + std::string(23, 'x'))); }),
              HasSubstr("cut off"));
  EXPECT_THAT(error_of([] { return decode_pcd(pcd("ascii\n1 2 3\n4 5 6\n", "POINTS 3\n")); }),
              HasSubstr("POINTS is 3, but WIDTH times HEIGHT is 2"));
  EXPECT_THAT(error_of([] { return decode_pcd(pcd("packed\n")); }), HasSubstr("'packed'"));
  EXPECT_THAT(error_of([] { return decode_pcd("FIELDS a b\nWIDTH 1\nDATA ascii\n1 2\n"); }),
              HasSubstr("x and y are missing"));
  // Promises what no memory holds: refused before anything is reserved.
  for (const char* kind : {"ascii", "binary", "binary_compressed"}) {
    const std::string head = "FIELDS x y\nWIDTH 1000000000000\nHEIGHT 1\nDATA ";
    EXPECT_THROW((void)decode_pcd(head + kind + "\n1 2 3 4 5 6 7 8 9"), DataError) << kind;
  }
}

TEST(Ply, AsciiBehindAnotherElement) {
  const PointCloud cloud = read_point_cloud(seed("ply/ascii_faces_first.ply"));
  EXPECT_EQ(rows(cloud), (Rows{{1.5, 2, 3}, {-1, 0.5, 4}, {-999, -999, 0}}));
}

TEST(Ply, BothByteOrdersWithListsToPassOver) {
  const Rows wanted{{1.5, 2, 3}, {-1, 0.5, 4}, {0, 0, -9}};
  EXPECT_EQ(rows(read_point_cloud(seed("ply/little_endian_lists.ply"))), wanted);
  EXPECT_EQ(rows(read_point_cloud(seed("ply/big_endian_lists.ply"))), wanted);
}

TEST(Ply, DamageIsNamedWithItsPlace) {
  const std::string head = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n";
  EXPECT_THAT(error_of([&] {
                return decode_ply(head + "property float y\nend_header\n1 2\n3\n", "a.ply");
              }),
              HasSubstr("a.ply:8: has fewer numbers"));
  EXPECT_THAT(error_of([&] { return decode_ply(head + "end_header\n1\n2\n"); }),
              HasSubstr("no properties x and y"));
  EXPECT_THAT(error_of([&] { return decode_ply(head + "property real y\nend_header\n", "a.ply"); }),
              HasSubstr("a.ply:5: 'real' is no type"));
  EXPECT_THAT(error_of([] { return decode_ply("ply\nformat ascii 1.0\n"); }),
              HasSubstr("ends within its head"));
  EXPECT_THAT(
      error_of([] {
        return decode_ply(
            "ply\nformat binary_big_endian 1.0\nelement vertex 1000000000000\n"
            "property float x\nproperty float y\nend_header\n12345678",
            "a.ply");
      }),
      HasSubstr("a.ply (byte 107): 1000000000000 of element 'vertex' need at least 8 bytes each"));
}

TEST(CloudText, ColumnsByNameOrByPlace) {
  EXPECT_EQ(rows(read_point_cloud(seed("cloud_text/comma_header.csv"))),
            (Rows{{3, 2, 4}, {4, 3, -999}}));
  EXPECT_EQ(rows(read_point_cloud(seed("cloud_text/semicolon.csv"))),
            (Rows{{1.5, 2.5, 0}, {-0.001, 4, 0}}));
  EXPECT_EQ(rows(read_point_cloud(seed("cloud_text/tabs_and_comment.txt"))),
            (Rows{{1, 2, 3}, {4, 5, 6}}));
  EXPECT_EQ(rows(read_point_cloud(seed("cloud_text/count_first.pts"))),
            (Rows{{0, 0, 1}, {1, 2, 3}}));
  const PointCloud planar = read_point_cloud(seed("cloud_text/two_columns.xyz"));
  EXPECT_EQ(rows(planar), (Rows{{1, 2, 0}, {3, 4, 0}}));
  EXPECT_TRUE(planar.planar);
  EXPECT_EQ(rows(decode_cloud_text("east,north\n1,2\n")), (Rows{{1, 2, 0}}));
  EXPECT_EQ(rows(decode_cloud_text("\"Points:0\",\"Points:1\",\"Points:2\"\n1,2,3\n")),
            (Rows{{1, 2, 3}}));
  EXPECT_EQ(rows(decode_cloud_text("id\tmy x\tx_m\ty (m)\n7\t8\t1\t2\n")), (Rows{{1, 2, 0}}));
  EXPECT_TRUE(decode_cloud_text("1 2 0\n3 4 0\n").planar) << "every z is 0";
  EXPECT_FALSE(decode_cloud_text("1 2 0\n3 4 1\n").planar);
}

TEST(CloudText, DamageIsNamedWithItsPlace) {
  EXPECT_THAT(error_of([] { return decode_cloud_text("1,2,3\n1,2\n", "a.csv"); }),
              HasSubstr("a.csv:2: has 2 columns; 3 are needed"));
  EXPECT_THAT(error_of([] { return decode_cloud_text("1;2\n1,5;2\n", "a.csv"); }),
              HasSubstr("a.csv:2: '1,5' is no number; write 1.5"));
  EXPECT_THAT(error_of([] { return decode_cloud_text("5\n7\n8\n"); }), HasSubstr("single column"));
  EXPECT_THAT(error_of([] { return decode_cloud_text("# nothing\n"); }),
              HasSubstr("holds no points"));
  EXPECT_THAT(error_of([] { return decode_cloud_text("nan nan\n"); }),
              HasSubstr("no point that is finite"));
  EXPECT_THAT(error_of([] { return decode_cloud_text(std::string(100, '\0')); }),
              HasSubstr("neither text"));
}

TEST(NpyCloud, RowsOrColumnsEitherByteOrder) {
  Rows wanted;
  for (int i = 0; i < 5; ++i) wanted.push_back({0.75 * i - 1, 0.75 * i - 0.75, 0.75 * i - 0.5});
  EXPECT_EQ(rows(read_point_cloud(seed("npy_cloud/rows_f8.npy"))), wanted);
  EXPECT_EQ(rows(read_point_cloud(seed("npy_cloud/columns_f4_big_endian.npy"))), wanted);
  for (auto& row : wanted) row[2] = 0.0;
  const PointCloud two = read_point_cloud(seed("npy_cloud/fortran_two_columns.npy"));
  EXPECT_EQ(rows(two), wanted);
  EXPECT_TRUE(two.planar);
  const PointCloud more = read_point_cloud(seed("npy_cloud/five_columns_i2.npy"));
  ASSERT_EQ(more.points.size(), 12u);
  EXPECT_EQ(more.points[11], Eigen::Vector3d(55, 56, 57));
}

TEST(NpyCloud, OtherShapesAreRefused) {
  const auto shape = [](std::initializer_list<std::int64_t> sizes, std::size_t count) {
    return npy_head("<f8", false, std::span(sizes.begin(), sizes.size())) +
           std::string(8 * count, '\0');
  };
  EXPECT_EQ(decode_npy_cloud(shape({3, 3}, 9)).points.size(), 3u);
  EXPECT_EQ(decode_npy_cloud(shape({2, 3}, 6)).points.size(), 2u) << "rows are points";
  EXPECT_THAT(error_of([&] {
                return decode_npy_cloud(shape({4, 9}, 36));
              }),
              HasSubstr("is of shape 4 x 9"));
  EXPECT_THROW((void)decode_npy_cloud(shape({6}, 6)), DataError);
  EXPECT_THROW((void)decode_npy_cloud(shape({0, 3}, 0)), DataError);
  EXPECT_THROW((void)decode_npy_cloud(shape({1 << 30, 3}, 9)), DataError);
}

TEST(Ply, TextTakesEveryWayToWriteANumber) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
      "property uchar red\nend_header\n";
  const PointCloud cloud = decode_ply(head +
                                      "1e3 -.5 7\n"
                                      "\t+2. 0.1 255\r\n"
                                      " \n"
                                      "123456789.12345678 0.0001234567890123456 0\n"
                                      "-0 nan 1\n");
  EXPECT_EQ(rows(cloud), (Rows{{1000, -0.5, 0},
                               {2, 0.1, 0},
                               {123456789.12345678, 0.0001234567890123456, 0},
                               {0, -999, 0}}));
  EXPECT_THAT(error_of([&] { return decode_ply(head + "1 2 3\n1.5.2 0 0\n"); }),
              HasSubstr(":9: '1.5.2' is no number"));
  EXPECT_THAT(error_of([&] { return decode_ply(head + "1 2\n"); }),
              HasSubstr("fewer numbers than the head promises"));
}

TEST(MatCloud, WhatMatioWrote) {
  for (const char* name : {"mat_cloud/matio_plain.mat", "mat_cloud/matio_compressed.mat"}) {
    const std::string path = seed(name);
    const MatFile file = parse_mat(bytes_of(path), name);
    ASSERT_EQ(file.matrices.size(), 3u);
    EXPECT_EQ(file.matrices[0].name, "points");
    EXPECT_EQ(file.matrices[2].values, std::vector<double>{1.0});
    EXPECT_THAT(file.others,
                testing::ElementsAre("about (struct)", "waves (complex)", "word (text)"));
    EXPECT_THAT(error_of([&] { return read_point_cloud(path); }),
                HasSubstr("several clouds; choose one by FILE#NAME: points (5 x 3), flat (4 x 2)"));
    const PointCloud cloud = read_point_cloud(path + "#points");
    ASSERT_EQ(cloud.points.size(), 5u);
    EXPECT_EQ(cloud.points[1], Eigen::Vector3d(-0.75, 0.5, 1.75));
    EXPECT_EQ(rows(read_point_cloud(path + "#flat")),
              (Rows{{1, 5, 0}, {2, -6, 0}, {3, 7, 0}, {4, 8, 0}}));
    EXPECT_THAT(error_of([&] { return read_point_cloud(path + "#n"); }), HasSubstr("'n' is 1 x 1"));
    EXPECT_THAT(error_of([&] { return read_point_cloud(path + "#waves"); }),
                HasSubstr("no real matrix 'waves'"));
  }
}

TEST(MatCloud, BigEndianSmallElementsAndPackedNumbers) {
  // MATLAB stores doubles that are whole numbers as bytes, and short elements inside their tags.
  const auto word = [](std::uint32_t value) {
    std::string bytes;
    for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift);
    return bytes;
  };
  std::string matrix = word(6) + word(8) + word(6) + word(0);        // flags: double
  matrix += word(5) + word(8) + word(2) + word(3);                   // 2 x 3
  matrix += word(1 << 16 | 1) + std::string("p\0\0\0", 4);           // name, small
  matrix += word(2) + word(6) + std::string("\1\4\2\5\3\6\0\0", 8);  // uint8 for double
  std::string file = "MATLAB 5.0 by hand";
  file.resize(124, ' ');
  file += std::string("\1\0MI", 4);
  file += word(14) + word(static_cast<std::uint32_t>(matrix.size())) + matrix;
  EXPECT_EQ(rows(decode_mat_cloud(file)), (Rows{{1, 2, 3}, {4, 5, 6}}));
}

/// Little-endian, as a compressed variable of a MATLAB file whose tag promises `more` bytes than
/// there are.
std::string compressed_variable(const std::string& matrix, std::uint32_t more) {
  const auto tag = [](std::uint32_t type, std::size_t size) {
    return raw<std::uint32_t>({type, static_cast<std::uint32_t>(size)});
  };
  const std::string plain = tag(14, matrix.size() + more) + matrix;
  uLongf size = compressBound(static_cast<uLong>(plain.size()));
  std::string packed(size, '\0');
  EXPECT_EQ(
      compress(reinterpret_cast<Bytef*>(packed.data()), &size,
               reinterpret_cast<const Bytef*>(plain.data()), static_cast<uLong>(plain.size())),
      Z_OK);
  packed.resize(size);
  return tag(15, packed.size()) + packed;
}

TEST(MatCloud, CompressedVariablesMayPromiseMoreThanTheyNeed) {
  // Flags, sizes, name, values: text as matio writes it, and a matrix of doubles.
  const std::string text =
      raw<std::uint32_t>({6, 8, 4, 0, 5, 8, 1, 5, 1 << 16 | 1, 't', 16, 5, 'a', 'b'});
  const std::string matrix = raw<std::uint32_t>({6, 8, 6, 0, 5, 8, 2, 3, 1 << 16 | 1, 'p', 9, 48}) +
                             raw<double>({1, 4, 2, 5, 3, 6});
  std::string head = "MATLAB 5.0 by hand";
  head.resize(124, ' ');
  head += std::string("\0\1IM", 4);
  const std::string file = head + compressed_variable(text, 8) + compressed_variable(matrix, 0);
  EXPECT_EQ(rows(decode_mat_cloud(file)), (Rows{{1, 2, 3}, {4, 5, 6}}));
  EXPECT_THAT(parse_mat(file, "a.mat").others, testing::ElementsAre("t (text)"));
  const std::string short_of_values = matrix.substr(0, matrix.size() - 8);
  EXPECT_THAT(
      error_of([&] { return parse_mat(head + compressed_variable(short_of_values, 8), "m"); }),
      HasSubstr("48 bytes begins here and 40 are left"));
  EXPECT_THAT(error_of([&] { return parse_mat(head + compressed_variable("ab", 6), "m"); }),
              HasSubstr("ends within a tag"));
}

TEST(MatCloud, OtherVersionsAreRefusedWithAdvice) {
  EXPECT_THAT(error_of([] { return decode_mat_cloud("MATLAB 7.3 MAT-file"); }),
              HasSubstr("save it with -v7"));
  EXPECT_THAT(error_of([] { return decode_mat_cloud(std::string(200, ' ')); }),
              HasSubstr("version 5"));
}

TEST(PointCloudFile, NoPrefixOfAFileIsReadAsTheWhole) {
  for (const char* name :
       {"pcd/binary_mixed_types.pcd", "pcd/compressed_mixed_types.pcd", "ply/big_endian_lists.ply",
        "npy_cloud/rows_f8.npy", "mat_cloud/matio_plain.mat", "mat_cloud/matio_compressed.mat"}) {
    const std::string whole = bytes_of(seed(name));
    const std::string kind(name, 3);
    const auto decode = [&](const std::string& bytes) {
      if (kind == "pcd") return decode_pcd(bytes);
      if (kind == "ply") return decode_ply(bytes);
      if (kind == "npy") return decode_npy_cloud(bytes);
      return decode_mat_cloud(bytes, "cut.mat", "flat");
    };
    const PointCloud all = decode(whole);
    for (std::size_t length = 0; length < whole.size(); ++length) {
      try {
        // What comes behind the points may be missing, and nothing else.
        EXPECT_EQ(rows(decode(whole.substr(0, length))), rows(all)) << name << " cut to " << length;
      } catch (const DataError&) {
      }
    }
  }
}

TEST(PointCloudFile, NamesMustNotLie) {
  const test::TempDir folder;
  EXPECT_THAT(error_of([&] { return read_point_cloud(folder.write("a.pcd", "ply\n")); }),
              HasSubstr("is named .pcd and holds .ply"));
  EXPECT_THAT(error_of([&] { return read_point_cloud(folder.write("a.ply", "1 2 3\n")); }),
              HasSubstr("doesn't begin with a line 'ply'"));
  EXPECT_THAT(error_of([&] { return read_point_cloud(folder.write("a.npy", "1 2 3\n4 5 6\n")); }),
              HasSubstr("is no NumPy array"));
  EXPECT_THAT(error_of([&] { return read_point_cloud(folder.write("empty.csv", "")); }),
              HasSubstr("the file is empty"));
  EXPECT_THAT(error_of([&] { return read_point_cloud(folder / "none.csv"); }),
              HasSubstr("none.csv"));
  // A name without an ending is no promise.
  EXPECT_EQ(read_point_cloud(folder.write("cloud", encode_ply({{{1, 2, 3}}}))).points.size(), 1u);
  EXPECT_TRUE(is_point_cloud_name("a/b.PLY"));
  EXPECT_TRUE(is_point_cloud_name("model.mat#points"));
  EXPECT_FALSE(is_point_cloud_name("log.clf#12"));
  EXPECT_THROW(write_point_cloud(folder / "a.obj", {{{1, 2, 3}}}), UsageError);
}

RC_GTEST_PROP(PointCloudFile, PlyKeepsEveryBit,
              (const std::vector<std::array<double, 3>>& values)) {
  PointCloud cloud;
  cloud.points.emplace_back(0.1, -0.2, 1e-300);
  for (const auto& v : values) {
    const Eigen::Vector3d point(v[0], v[1], v[2]);
    if (is_usable_point(point)) cloud.points.push_back(point);
  }
  const PointCloud back = decode_ply(encode_ply(cloud));
  RC_ASSERT(back.points.size() == cloud.points.size());
  for (std::size_t i = 0; i < back.points.size(); ++i) RC_ASSERT(back.points[i] == cloud.points[i]);
}

RC_GTEST_PROP(PointCloudFile, PcdKeepsFloats, (const std::vector<std::array<float, 3>>& values)) {
  PointCloud cloud;
  cloud.points.emplace_back(0.5, -0.25, 1.0);
  for (const auto& v : values) {
    const Eigen::Vector3d point(v[0], v[1], v[2]);
    if (is_usable_point(point)) cloud.points.push_back(point);
  }
  const PointCloud back = decode_pcd(encode_pcd(cloud));
  RC_ASSERT(back.points.size() == cloud.points.size());
  for (std::size_t i = 0; i < back.points.size(); ++i) RC_ASSERT(back.points[i] == cloud.points[i]);
}

TEST(PointCloudFile, WritesByTheEndingOfTheName) {
  const test::TempDir folder;
  const PointCloud cloud{{{1.5, 2.5, -3.5}, {0.25, 0, 4}}};
  for (const char* name : {"a.ply", "b.PCD"}) {
    write_point_cloud(folder / name, cloud);
    EXPECT_EQ(rows(read_point_cloud(folder / name)), rows(cloud)) << name;
  }
}

TEST(Lzf, CopiesOverlapAndDamageIsFound) {
  EXPECT_EQ(lzf_decompress(std::string("\0a\x40\0", 4), 5), "aaaaa");
  EXPECT_EQ(lzf_decompress(std::string("\2abc\xe0\3\2", 7), 15), "abcabcabcabcabc");
  EXPECT_EQ(lzf_decompress("", 0), "");
  EXPECT_FALSE(lzf_decompress(std::string("\0a\x40\1", 4), 5)) << "reaches before the beginning";
  EXPECT_FALSE(lzf_decompress(std::string("\0a\x40\0", 4), 4)) << "makes too much";
  EXPECT_FALSE(lzf_decompress(std::string("\0a\x40\0", 4), 6)) << "makes too little";
  EXPECT_FALSE(lzf_decompress(std::string("\0a\x40", 3), 5)) << "cut off";
  EXPECT_FALSE(lzf_decompress("abc", std::size_t{1} << 60)) << "can't make that much";
}

/// Every cloud that was recorded can be read.
TEST(PointCloudFile, RecordedClouds) {
  const std::string clouds = test::recorded_data("clouds");
  const std::string warm_up = test::recorded_data("ucsd/icp_warm_up");
  if (clouds.empty() || warm_up.empty()) GTEST_SKIP() << "the recorded clouds are not here";
  const auto size = [](const std::string& path) { return read_point_cloud(path).points.size(); };
  EXPECT_EQ(size(clouds + "/source.ply"), 69792u);
  EXPECT_GT(size(clouds + "/target.ply"), 60000u);
  EXPECT_EQ(size(warm_up + "/drill/0.npy"), 11690u);
  EXPECT_EQ(size(warm_up + "/liq_container/3.npy"), 19544u);
  EXPECT_GT(size(warm_up + "/drill/model.mat"), 1000u);
  EXPECT_GT(size(warm_up + "/liq_container/model.mat"), 1000u);
  const PointCloud car = read_point_cloud(clouds + "/car_cloud400.csv");
  EXPECT_EQ(car.points[0], Eigen::Vector3d(-3.5376, 0.639553, -1.37678));
  EXPECT_GT(size(clouds + "/car_cloud401.csv"), 10000u);
  for (const char* name : {"/2D_oneBox.csv", "/2D_twoBoxes.csv"}) {
    const PointCloud flat = read_point_cloud(clouds + name);
    EXPECT_TRUE(flat.planar) << name;
    EXPECT_GT(flat.points.size(), 300u) << name;
  }
}

TEST(PointCloudFile, CoordinatesThatAreNoPlaceAreRefusedWithTheirPoint) {
  EXPECT_THAT(error_of([] { return decode_cloud_text("0 0 0\n1 3.4e38 0\n", "a.xyz"); }),
              HasSubstr("a.xyz: point 2 has a coordinate of 3.4e+38"));
  EXPECT_THAT(error_of([] { return decode_cloud_text("0 0 0\n1 -1e300 0\n", "a.xyz"); }),
              HasSubstr("write nan"));
  EXPECT_EQ(decode_cloud_text("0 0 0\n1 inf 0\n1 nan 0\n").points.size(), 3u);
  EXPECT_EQ(decode_cloud_text("0 0 0\n500000.5 5000000.25 0\n").points.size(), 2u);
}

}  // namespace
}  // namespace loopstone
