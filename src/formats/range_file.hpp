#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "formats/atomic_file.hpp"

namespace loopstone {

/// The array `ranges` (beams x scans, Fortran order, float) while it grows, as a .npy file beside
/// its archive-to-be. The file disappears with the object.
class RangeFile {
 public:
  RangeFile(const std::string& path, std::int64_t beams);

  void append(std::span<const float> ranges_m);
  /// Ends the file; its name.
  [[nodiscard]] std::string finish();

 private:
  AtomicFile file_;
  std::int64_t beams_;
  std::int64_t scans_ = 0;
};

}  // namespace loopstone
