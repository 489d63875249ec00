#pragma once

#include <string>
#include <string_view>

#include "loopstone/base/memory_budget.hpp"
#include "loopstone/sensor/point_cloud.hpp"

namespace loopstone {

// Clouds of points, from every format in which they are passed around. Coordinates are taken as
// they stand, in metres; whatever else a file says of its points (normals, colours, intensity) is
// passed over. A cloud is planar when its file has x and y alone, or when every z is 0. All readers
// throw DataError with the line or byte offset, also for a point that is nowhere
// (kFarthestCoordinateM), and when the cloud would take more memory than the budget allows.

/// Point Cloud Library: ascii, binary, binary_compressed; fields in any order, of any type and
/// count.
[[nodiscard]] PointCloud decode_pcd(std::string_view bytes,
                                    const std::string& path_for_errors = "cloud.pcd",
                                    const MemoryBudget& budget = {});

/// Polygon file: ascii, binary little and big endian; the element `vertex` wherever it stands,
/// lists passed over.
[[nodiscard]] PointCloud decode_ply(std::string_view bytes,
                                    const std::string& path_for_errors = "cloud.ply",
                                    const MemoryBudget& budget = {});

/// NumPy array of numbers, N x 2 or N x 3 (or 2 x N, 3 x N with N > 3); of N x 4 to N x 8 with N >
/// 8, the first three columns.
[[nodiscard]] PointCloud decode_npy_cloud(std::string_view bytes,
                                          const std::string& path_for_errors = "cloud.npy",
                                          const MemoryBudget& budget = {});

/// MATLAB file of version 5 (also what MATLAB calls -v6 and -v7): the real matrix that has the
/// shape of a cloud, as for NumPy.
/// \param variable  its name; empty when there is only one
[[nodiscard]] PointCloud decode_mat_cloud(std::string_view bytes,
                                          const std::string& path_for_errors = "cloud.mat",
                                          const std::string& variable = {},
                                          const MemoryBudget& budget = {});

/// Rows of numbers between commas, semicolons, tabs or blanks. A first line of names says which
/// columns are x, y and z; without one, or when it names no x and y, they are the first three (two
/// when there are two). Lines that begin with #, % or // are comments, unless they are such a line
/// of names.
[[nodiscard]] PointCloud decode_cloud_text(std::string_view text,
                                           const std::string& path_for_errors = "cloud.txt",
                                           const MemoryBudget& budget = {});

/// Any of these, found out by the content. A name that ends in .pcd, .ply, .npy or .mat must keep
/// that promise.
/// \param path "FILE.mat#variable" picks one of several matrices
[[nodiscard]] PointCloud read_point_cloud(const std::string& path, const MemoryBudget& budget = {});
/// Whether the name ends like that of a point cloud: .pcd .ply .npy .mat .csv .xyz .txt .asc .pts
/// (and #variable after .mat).
[[nodiscard]] bool is_point_cloud_name(std::string_view path);

/// Little-endian binary with x, y, z as doubles: read_point_cloud gives the same points back, to
/// the bit.
[[nodiscard]] std::string encode_ply(const PointCloud& cloud);
/// Binary with x, y, z as 4-byte floats, which is what PCL's own programs expect: exact to 4 um at
/// 60 m.
[[nodiscard]] std::string encode_pcd(const PointCloud& cloud);
/// Whether the name ends in .ply or .pcd.
[[nodiscard]] bool can_write_point_cloud(std::string_view path);
/// PLY or PCD by the ending of the name; throws UsageError for any other.
void write_point_cloud(const std::string& path, const PointCloud& cloud);

}  // namespace loopstone
