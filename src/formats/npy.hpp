#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/byte_source.hpp"
#include "loopstone/base/memory_budget.hpp"

namespace loopstone {

/// What the head of a .npy file says (versions 1 to 3; numpy/lib/format.py). Numbers only: bool,
/// signed, unsigned and floating point of 1 to 8 bytes, in either byte order. Anything that numpy
/// would have to unpickle is refused.
struct NpyHeader {
  char kind = 'f';  ///< 'b', 'i', 'u', 'f'
  int element_bytes = 8;
  bool big_endian = false;
  bool fortran_order = false;         ///< the first index runs fastest
  std::vector<std::int64_t> shape{};  ///< empty: a single number

  /// Product of the shape; throws nothing, the parser has checked that it fits.
  [[nodiscard]] std::int64_t count() const;
};

/// Reads an array front to back, converting to the type asked for, without ever holding all of it.
class NpyReader {
 public:
  /// Throws DataError when the head is not that of a numeric array.
  NpyReader(std::unique_ptr<ByteSource> source, std::string name);

  [[nodiscard]] const NpyHeader& header() const { return header_; }
  /// The next values.size() elements, in the order of the file. Throws DataError when the file ends
  /// before.
  void read(std::span<double> values);
  void read(std::span<float> values);

 private:
  template <typename T>
  void read_as(std::span<T> values);
  void fill(std::span<char> bytes);
  void parse_head();

  std::unique_ptr<ByteSource> source_;
  std::string name_;
  std::int64_t offset_ = 0;
  NpyHeader header_;
};

/// A whole array of at most two dimensions as doubles.
struct NpyArray {
  std::vector<std::int64_t> shape{};
  bool fortran_order = false;
  std::vector<double> values{};

  [[nodiscard]] std::int64_t rows() const { return shape.empty() ? 1 : shape[0]; }
  [[nodiscard]] std::int64_t columns() const { return shape.size() < 2 ? 1 : shape[1]; }
  [[nodiscard]] double at(std::int64_t row, std::int64_t column = 0) const {
    const std::int64_t index = fortran_order ? column * rows() + row : row * columns() + column;
    return values[static_cast<std::size_t>(index)];
  }
};

/// Throws DataError, also when the array would take more memory than a file of that size may.
/// \param file_bytes  the size of what holds it, as stored; absent: the source's
[[nodiscard]] NpyArray read_npy(std::unique_ptr<ByteSource> source, const std::string& name,
                                const MemoryBudget& budget = {},
                                std::optional<std::uint64_t> file_bytes = {});

/// The head of a version 1 file, padded as numpy does so that the data begins at a multiple of 64
/// bytes.
/// \param descr  "<f8" and the like
[[nodiscard]] std::string npy_head(const std::string& descr, bool fortran_order,
                                   std::span<const std::int64_t> shape);

}  // namespace loopstone
