#include "loopstone/formats/point_cloud_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cstring>
#include <filesystem>

#include "formats/atomic_file.hpp"
#include "formats/cloud_parts.hpp"

namespace loopstone {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are written as they stand");

std::string ending_of(std::string_view path) {
  const std::size_t dot = path.rfind('.');
  std::string ending(dot == path.npos ? "" : path.substr(dot));
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending;
}

struct CloudPath {
  std::string file;
  std::string variable;
};

/// Cuts off "#variable" after .mat, unless a file has that very name.
CloudPath split_variable(const std::string& path) {
  const std::size_t hash = path.rfind('#');
  std::error_code ignored;
  if (hash == path.npos || ending_of(path.substr(0, hash)) != ".mat" ||
      std::filesystem::exists(path, ignored)) {
    return {path, {}};
  }
  return {path.substr(0, hash), path.substr(hash + 1)};
}

/// The ending that the content deserves; empty for text.
std::string ending_by_content(std::string_view bytes) {
  if (bytes.starts_with("ply\n") || bytes.starts_with("ply\r\n")) return ".ply";
  if (bytes.starts_with("\x93NUMPY")) return ".npy";
  if (bytes.starts_with("MATLAB ") || bytes.starts_with("\x89HDF\r\n")) return ".mat";
  const std::string_view front = bytes.substr(0, 4096);
  const std::size_t version = front.find("VERSION");
  const bool after_line = version == 0 || (version != front.npos && front[version - 1] == '\n');
  if (front.starts_with("# .PCD") || (after_line && front.find("FIELDS") != front.npos)) {
    return ".pcd";
  }
  return {};
}

template <typename T>
void append_numbers(std::string& bytes, const Eigen::Vector3d& point) {
  std::array<T, 3> values{};
  for (std::size_t i = 0; i < 3; ++i) {
    values[i] = static_cast<T>(point(static_cast<Eigen::Index>(i)));
  }
  std::array<char, sizeof values> raw{};
  std::memcpy(raw.data(), values.data(), sizeof values);
  bytes.append(raw.data(), raw.size());
}

}  // namespace

bool is_point_cloud_name(std::string_view path) {
  static constexpr std::array<std::string_view, 9> kEndings{".pcd", ".ply", ".npy", ".mat", ".csv",
                                                            ".xyz", ".txt", ".asc", ".pts"};
  const std::string file = split_variable(std::string(path)).file;
  return std::find(kEndings.begin(), kEndings.end(), ending_of(file)) != kEndings.end();
}

PointCloud read_point_cloud(const std::string& path, const MemoryBudget& budget) {
  const CloudPath name = split_variable(path);
  const std::string bytes = read_whole_file(name.file, budget.ceiling_bytes);
  if (bytes.empty()) throw DataError({name.file}, "the file is empty");
  const std::string by_content = ending_by_content(bytes);
  const std::string by_name = ending_of(name.file);
  const bool promises =
      by_name == ".pcd" || by_name == ".ply" || by_name == ".npy" || by_name == ".mat";
  // A wrong name decides when the content tells nothing: its reader says what is missing.
  const std::string format = by_content.empty() && promises ? by_name : by_content;
  if (promises && format != by_name) {
    throw DataError({name.file}, fmt::format("is named {} and holds {}; give it its right name",
                                             by_name, format));
  }
  if (format == ".pcd") return decode_pcd(bytes, name.file, budget);
  if (format == ".ply") return decode_ply(bytes, name.file, budget);
  if (format == ".npy") return decode_npy_cloud(bytes, name.file, budget);
  if (format == ".mat") return decode_mat_cloud(bytes, name.file, name.variable, budget);
  return decode_cloud_text(bytes, name.file, budget);
}

std::string encode_ply(const PointCloud& cloud) {
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment written by loopstone, metres\n"
      "element vertex {}\nproperty double x\nproperty double y\nproperty double z\nend_header\n",
      cloud.points.size());
  for (const Eigen::Vector3d& point : cloud.points) append_numbers<double>(bytes, point);
  return bytes;
}

std::string encode_pcd(const PointCloud& cloud) {
  std::string bytes = fmt::format(
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\n"
      "TYPE F F F\nCOUNT 1 1 1\nWIDTH {0}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {0}\n"
      "DATA binary\n",
      cloud.points.size());
  for (const Eigen::Vector3d& point : cloud.points) append_numbers<float>(bytes, point);
  return bytes;
}

bool can_write_point_cloud(std::string_view path) {
  const std::string ending = ending_of(path);
  return ending == ".ply" || ending == ".pcd";
}

void write_point_cloud(const std::string& path, const PointCloud& cloud) {
  const std::string ending = ending_of(path);
  if (ending == ".ply") return write_file_atomically(path, encode_ply(cloud));
  if (ending == ".pcd") return write_file_atomically(path, encode_pcd(cloud));
  throw UsageError("'" + path + "': a cloud is written as .ply or .pcd");
}

}  // namespace loopstone
