#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "formats/kept_stamps.hpp"
#include "formats/npz.hpp"
#include "formats/ucsd_files.hpp"
#include "loopstone/sensor/messages.hpp"

namespace loopstone {

/// One sensor of a log: its records in the order of their stamps, made one at a time.
struct UcsdChannel {
  std::string path{};
  KeptStamps kept{};
  /// The message of a record; asked for in increasing order of index.
  std::function<SensorMessage(Stamp stamp, std::int64_t index)> make{};
  std::vector<std::string> notes{};
};

/// Encoders: `counts` 4 x N [FR, FL, RR, RL] since the reading before, `time_stamps` N [s].
[[nodiscard]] UcsdChannel open_ucsd_encoders(const NpzFile& file, const std::string& path);

/// Imu: `angular_velocity` 3 x N [rad/s], `linear_acceleration` 3 x N in units of g (told by its
/// size: 1 at rest), `time_stamps`.
[[nodiscard]] UcsdChannel open_ucsd_imu(const NpzFile& file, const std::string& path);

/// Hokuyo: `angle_min`, `angle_max`, `angle_increment` [rad], `range_min`, `range_max` [m],
/// `ranges` beams x N, `time_stamps`; ours may add `time_increment` [s] and `robot_T_lidar` (x, y,
/// yaw). Memory: in Fortran order (as numpy writes MATLAB's) one scan; in C order all ranges as
/// float, for in that order a scan is spread over the whole file.
[[nodiscard]] UcsdChannel open_ucsd_hokuyo(const NpzFile& file, const std::string& path);

/// Odometry (ours): `poses` 3 x N (x, y, yaw), `time_stamps`.
[[nodiscard]] UcsdChannel open_ucsd_odometry(const NpzFile& file, const std::string& path);

/// Kinect: `disparity_time_stamps` (or `depth_time_stamps`) and `rgb_time_stamps`; picture i of
/// dataRGBD/RGBN is rgbN_{i+1}.png. A frame is a depth picture with the colour picture nearest in
/// time (picture_pairs.hpp), or either of them alone. Only names are looked at.
[[nodiscard]] UcsdChannel open_ucsd_kinect(const NpzFile& file, const UcsdFiles& files);

/// `sensor` x N matrices, as numpy or its transpose holds them. Throws DataError naming the shapes
/// when neither fits.
struct UcsdMatrix {
  NpyArray array;
  bool records_are_rows = false;
  [[nodiscard]] double at(std::int64_t component, std::int64_t record) const {
    return records_are_rows ? array.at(record, component) : array.at(component, record);
  }
};
[[nodiscard]] UcsdMatrix read_ucsd_matrix(const NpzFile& file, const std::string& path,
                                          const std::string& key, std::int64_t components,
                                          std::int64_t records);

/// The stamps under a key, one-dimensional.
[[nodiscard]] std::vector<double> read_ucsd_stamps(const NpzFile& file, const std::string& path,
                                                   const std::string& key = "time_stamps");

/// "1081 x 4962", for messages.
[[nodiscard]] std::string shape_text(const std::vector<std::int64_t>& shape);

}  // namespace loopstone
