#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/base/memory_budget.hpp"

namespace loopstone {

/// A real matrix of numbers in a MATLAB file.
struct MatMatrix {
  std::string name{};
  std::int64_t rows = 0;
  std::int64_t columns = 0;
  std::vector<double> values{};  ///< column after column
};

struct MatFile {
  std::vector<MatMatrix> matrices{};  ///< real, numeric, of two dimensions
  std::vector<std::string> others{};  ///< what else there is, in words: "names (cell array)"

  [[nodiscard]] std::uint64_t held_bytes() const {
    std::uint64_t bytes = 0;
    for (const MatMatrix& matrix : matrices) bytes += matrix.values.size() * sizeof(double);
    return bytes;
  }
};

/// Reads a MATLAB file of version 5, either byte order, compressed (-v7) or not (-v6), from memory.
/// Throws DataError with the byte offset in the file, also for the other versions (4, and 7.3,
/// which is HDF5). Source of the layout: MathWorks, "MAT-File Format", chapter 1.
/// \throws DataError also when the matrices would take more memory than the budget allows
[[nodiscard]] MatFile parse_mat(std::string_view bytes, const std::string& path_for_errors,
                                const MemoryBudget& budget = {});

}  // namespace loopstone
