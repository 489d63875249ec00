#include <fmt/format.h>

#include <array>
#include <bit>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/cloud_columns.hpp"
#include "formats/cloud_parts.hpp"
#include "formats/mat_file.hpp"
#include "formats/npy.hpp"
#include "loopstone/formats/point_cloud_file.hpp"

namespace loopstone {
namespace {

/// How an array of numbers holds a cloud.
struct CloudShape {
  bool points_are_columns = false;
  std::int64_t points = 0;
  bool has_z = false;
};

/// Rows are points wherever that is possible, as everybody stores them; columns where rows can't
/// be.
std::optional<CloudShape> cloud_shape(std::int64_t rows, std::int64_t columns) {
  const auto two_or_three = [](std::int64_t n) { return n == 2 || n == 3; };
  if (two_or_three(columns)) return CloudShape{false, rows, columns == 3};
  if (two_or_three(rows)) return CloudShape{true, columns, rows == 3};
  if (columns >= 4 && columns <= 8 && rows > 8) return CloudShape{false, rows, true};
  return std::nullopt;
}

/// \param values  of an array that is stored row after row, or else column after column
PointCloud make_cloud(const CloudShape& shape, std::span<const double> values, std::int64_t rows,
                      std::int64_t columns, bool by_columns, const std::string& path) {
  const auto row_step = static_cast<std::size_t>(by_columns ? 1 : columns);
  const auto column_step = static_cast<std::size_t>(by_columns ? rows : 1);
  const std::size_t point_step = shape.points_are_columns ? column_step : row_step;
  const std::size_t axis_step = shape.points_are_columns ? row_step : column_step;
  std::array<std::optional<CloudColumn>, 3> axes;
  for (std::size_t axis = 0; axis < (shape.has_z ? 3U : 2U) && shape.points > 0; ++axis) {
    axes[axis] = CloudColumn{reinterpret_cast<const char*>(values.data() + axis * axis_step),
                             point_step * sizeof(double),
                             {'f', sizeof(double)}};
  }
  return finish_cloud(
      read_columns(axes, static_cast<std::size_t>(shape.points), std::endian::native), shape.has_z,
      path);
}

std::string list_of(const MatFile& file) {
  std::string list;
  for (const MatMatrix& matrix : file.matrices) {
    list += fmt::format("{}{} ({} x {})", list.empty() ? "" : ", ", matrix.name, matrix.rows,
                        matrix.columns);
  }
  for (const std::string& other : file.others) list += (list.empty() ? "" : ", ") + other;
  return list.empty() ? "nothing" : list;
}

constexpr const char* kExpected = "a cloud is N x 2 or N x 3 (or 2 x N, 3 x N)";

const MatMatrix& choose(const MatFile& file, const std::string& path, const std::string& variable) {
  const MatMatrix* chosen = nullptr;
  for (const MatMatrix& matrix : file.matrices) {
    if (variable.empty() ? !cloud_shape(matrix.rows, matrix.columns) : matrix.name != variable)
      continue;
    if (chosen != nullptr && variable.empty()) {
      throw DataError({path}, "holds several clouds; choose one by FILE#NAME: " + list_of(file));
    }
    chosen = &matrix;
  }
  if (chosen != nullptr) return *chosen;
  if (!variable.empty()) {
    throw DataError({path},
                    "has no real matrix " + show_word(variable) + "; it holds " + list_of(file));
  }
  throw DataError({path}, fmt::format("holds no cloud: {}; it holds {}", kExpected, list_of(file)));
}

}  // namespace

PointCloud decode_npy_cloud(std::string_view bytes, const std::string& path,
                            const MemoryBudget& budget) {
  const NpyArray array = read_npy(memory_byte_source(bytes, path), path, budget, bytes.size());
  const auto shape = cloud_shape(array.rows(), array.columns());
  if (!shape || array.shape.size() != 2) {
    throw DataError({path}, fmt::format("is of shape {}; {}",
                                        array.shape.size() == 2
                                            ? fmt::format("{} x {}", array.rows(), array.columns())
                                            : std::to_string(array.rows()),
                                        kExpected));
  }
  require_points(static_cast<std::uint64_t>(shape->points), array.values.size() * sizeof(double),
                 bytes.size(), budget, {path});
  return make_cloud(*shape, array.values, array.rows(), array.columns(), array.fortran_order, path);
}

PointCloud decode_mat_cloud(std::string_view bytes, const std::string& path,
                            const std::string& variable, const MemoryBudget& budget) {
  const MatFile file = parse_mat(bytes, path, budget);
  const MatMatrix& matrix = choose(file, path, variable);
  const auto shape = cloud_shape(matrix.rows, matrix.columns);
  if (!shape) {
    throw DataError({path}, fmt::format("{} is {} x {}; {}", show_word(matrix.name), matrix.rows,
                                        matrix.columns, kExpected));
  }
  require_points(static_cast<std::uint64_t>(shape->points), file.held_bytes(), bytes.size(), budget,
                 {path});
  return make_cloud(*shape, matrix.values, matrix.rows, matrix.columns, true, path);
}

}  // namespace loopstone
