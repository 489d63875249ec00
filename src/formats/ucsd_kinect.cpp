#include <cmath>
#include <memory>
#include <unordered_set>
#include <utility>

#include "formats/ucsd_sensors.hpp"

namespace loopstone {
namespace {

namespace fs = std::filesystem;

constexpr double kPairWithin_s = 0.05;

/// The pictures of one kind: which stamps have one, by the names in the folder.
struct Pictures {
  fs::path folder{};
  std::string prefix{};
  std::unordered_set<std::string> names{};

  /// Path of the picture of the stamp with this index, empty when it isn't there.
  [[nodiscard]] std::string path(std::int64_t index) const {
    const std::string name = prefix + std::to_string(index + 1) + ".png";
    return names.contains(name) ? (folder / name).string() : std::string();
  }
};

Pictures list_pictures(const fs::path& folder, const std::string& prefix) {
  Pictures pictures{folder, prefix, {}};
  std::error_code ignored;
  if (folder.empty()) return pictures;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    std::string name = entry.path().filename().string();
    if (name.starts_with(prefix) && name.ends_with(".png")) pictures.names.insert(std::move(name));
  }
  return pictures;
}

struct Frames {
  Pictures colour{};
  Pictures disparity{};
  bool disparity_leads = true;
  std::vector<std::int64_t>
      colour_of{};  ///< index of the colour picture of each disparity; -1: none
};

/// For each leading stamp the nearest stamp of the other kind, if near enough. Both rows increase.
std::vector<std::int64_t> nearest(const KeptStamps& leading, const KeptStamps& other,
                                  std::size_t records) {
  std::vector<std::int64_t> found(records, -1);
  std::size_t j = 0;
  for (std::size_t i = 0; i < leading.stamps.size() && !other.stamps.empty(); ++i) {
    const auto distance_s = [&](std::size_t k) {
      return std::abs((other.stamps[k] - leading.stamps[i]).seconds());
    };
    while (j + 1 < other.stamps.size() && distance_s(j + 1) <= distance_s(j)) ++j;
    if (distance_s(j) <= kPairWithin_s) {
      found[static_cast<std::size_t>(leading.indices[i])] = other.indices[j];
    }
  }
  return found;
}

}  // namespace

UcsdChannel open_ucsd_kinect(const NpzFile& file, const UcsdFiles& files) {
  const std::string path = files.kinect.string();
  UcsdChannel channel{path};
  const auto stamps = [&](const char* key) {
    return file.has(key) ? read_ucsd_stamps(file, path, key) : std::vector<double>{};
  };
  const std::vector<double> disparity_s = stamps("disparity_time_stamps");
  const std::vector<double> colour_s = stamps("rgb_time_stamps");
  const std::string set = std::to_string(files.set);
  auto frames = std::make_shared<Frames>();
  frames->colour = list_pictures(files.colour_folder, "rgb" + set + "_");
  frames->disparity = list_pictures(files.disparity_folder, "disparity" + set + "_");
  if (frames->colour.names.empty() && frames->disparity.names.empty()) {
    channel.notes.push_back("there are stamps of " + std::to_string(disparity_s.size()) +
                            " disparity and " + std::to_string(colour_s.size()) +
                            " colour pictures, but no pictures in dataRGBD");
    return channel;
  }

  frames->disparity_leads = !frames->disparity.names.empty() && !disparity_s.empty();
  KeptStamps disparity = keep_increasing(disparity_s);
  KeptStamps colour = keep_increasing(colour_s);
  if (frames->disparity_leads) {
    frames->colour_of = nearest(disparity, colour, disparity_s.size());
  }
  channel.kept = std::move(frames->disparity_leads ? disparity : colour);
  channel.make = [frames](Stamp stamp, std::int64_t index) {
    RgbdFrame frame{stamp, stamp, {}, {}};
    if (!frames->disparity_leads) {
      frame.colour_path = frames->colour.path(index);
      return frame;
    }
    frame.depth_path = frames->disparity.path(index);
    const std::int64_t colour_index = frames->colour_of[static_cast<std::size_t>(index)];
    if (colour_index >= 0) frame.colour_path = frames->colour.path(colour_index);
    return frame;
  };
  return channel;
}

}  // namespace loopstone
