#pragma once

#include <optional>
#include <string>
#include <vector>

#include "formats/rosbag2_metadata.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {

/// What a folder of rosbag2 consists of: as metadata.yaml says where that is right, otherwise what
/// lies there.
struct Rosbag2Folder {
  std::vector<std::string> files{};    ///< that are there, in their order
  std::vector<std::string> missing{};  ///< that metadata.yaml names
  std::optional<Rosbag2Metadata> metadata{};
  std::vector<std::string> notes{};
  std::vector<Problem> problems{};
};

[[nodiscard]] Rosbag2Folder look_at_rosbag2_folder(const std::string& folder);

/// By name: a database or a file of MCAP, packed or not.
[[nodiscard]] bool has_rosbag2_ending(const std::string& name);

/// Whether a name stands before another when the numbers in them count as numbers: "a_2" before
/// "a_10".
[[nodiscard]] bool is_before_by_number(const std::string& a, const std::string& b);

}  // namespace loopstone
