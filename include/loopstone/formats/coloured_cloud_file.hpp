#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <string>

namespace loopstone {

/// Writes a cloud of coloured points point by point, in bounded memory: PLY, binary little-endian, x y z as 4-byte floats [m] and red
/// green blue as bytes (sRGB), which CloudCompare, MeshLab and Blender show as they stand. The file appears whole with
/// commit(); without it nothing is left. Every function throws DataError that names the file.
class ColouredCloudFile {
 public:
  explicit ColouredCloudFile(const std::string& path);
  ~ColouredCloudFile();
  ColouredCloudFile(const ColouredCloudFile&) = delete;
  ColouredCloudFile& operator=(const ColouredCloudFile&) = delete;

  void add(const Eigen::Vector3f& point_m, const std::array<std::uint8_t, 3>& rgb);
  [[nodiscard]] std::int64_t points() const { return points_; }
  void commit();

 private:
  struct File;

  std::unique_ptr<File> file_;
  std::int64_t points_ = 0;
};

}  // namespace loopstone
