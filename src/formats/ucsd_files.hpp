#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace loopstone {

/// What the files of the sensors are named, before the number of the set.
inline constexpr std::array<std::string_view, 5> kUcsdSensors{"Encoders", "Imu", "Hokuyo", "Kinect",
                                                              "Odometry"};

/// Where the parts of one set of the UCSD layout are, of those that are there.
struct UcsdFiles {
  std::filesystem::path folder{};
  int set = 0;
  std::optional<std::filesystem::path> encoders{};
  std::optional<std::filesystem::path> imu{};
  std::optional<std::filesystem::path> hokuyo{};
  std::optional<std::filesystem::path> kinect{};
  std::optional<std::filesystem::path>
      odometry{};  ///< OdometryN.npz: our addition, see docs/formats.md
  std::optional<std::filesystem::path> colour_folder{};     ///< .../dataRGBD/RGBN
  std::optional<std::filesystem::path> disparity_folder{};  ///< .../dataRGBD/DisparityN
  std::optional<std::filesystem::path>
      depth_folder{};  ///< .../dataRGBD/DepthN: our addition, plain depth
};

/// Whether the depth camera's numbers are disparities: unless there is a folder of plain depth and
/// none of disparity.
[[nodiscard]] bool holds_disparity(const UcsdFiles& files);

/// The numbers of the sets in a folder (or its sensors/ or data/), in order.
[[nodiscard]] std::vector<int> ucsd_sets(const std::filesystem::path& folder);

/// Throws UsageError when `set` is empty and there are several, or when there is no such set;
/// DataError when the folder holds none at all.
[[nodiscard]] UcsdFiles find_ucsd_files(const std::filesystem::path& folder,
                                        std::optional<int> set);

}  // namespace loopstone
