#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "loopstone/base/error.hpp"
#include "loopstone/base/memory_budget.hpp"
#include "loopstone/sensor/point_cloud.hpp"

namespace loopstone {

/// A word of a damaged file as it can be shown: in quotes, short, printable.
[[nodiscard]] std::string show_word(std::string_view word);

/// Asked before so many points are allocated, beside `held_bytes` that the file became on the way.
/// Throws DataError.
void require_points(std::uint64_t points, std::uint64_t held_bytes, std::uint64_t file_bytes,
                    const MemoryBudget& budget, const Location& where);

/// What all readers of clouds do at the end: refuses one without a single finite point, or with one
/// that is nowhere (kFarthestCoordinateM), notes whether it is planar.
/// \param has_z  the file has a third coordinate
[[nodiscard]] PointCloud finish_cloud(PointCloud cloud, bool has_z, const std::string& path);

/// Text at the front of a file that may be binary further on, line by line.
class HeadLines {
 public:
  HeadLines(std::string_view bytes, std::string path) : bytes_(bytes), path_(std::move(path)) {}

  /// The next line without its end, trimmed; throws DataError when the file ends or the line can't
  /// be one of a head.
  [[nodiscard]] std::string_view next();
  [[nodiscard]] Location here() const { return {path_, line_}; }
  /// Where the bytes after the last line begin.
  [[nodiscard]] std::size_t offset() const { return offset_; }
  [[nodiscard]] std::int64_t line() const { return line_; }
  [[noreturn]] void fail(const std::string& reason) const { throw DataError(here(), reason); }

 private:
  std::string_view bytes_;
  std::string path_;
  std::size_t offset_ = 0;
  std::int64_t line_ = 0;
};

}  // namespace loopstone
