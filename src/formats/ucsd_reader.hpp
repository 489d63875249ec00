#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "loopstone/formats/log_reader.hpp"

namespace loopstone {

/// Reads one set of a folder in the UCSD layout (EncodersN.npz, ImuN.npz, HokuyoN.npz, KinectN.npz,
/// dataRGBD), its sensors merged by their stamps. Sensors may be missing as long as the robot's
/// motion or the laser is there.
[[nodiscard]] std::unique_ptr<LogReader> open_ucsd_log(const std::filesystem::path& folder,
                                                       std::optional<int> set,
                                                       const LogOptions& options);

}  // namespace loopstone
