#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "formats/picture_pairs.hpp"
#include "formats/text_numbers.hpp"
#include "formats/ucsd_sensors.hpp"

namespace loopstone {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 3> kColourEndings{".png", ".ppm", ".pgm"};
constexpr std::array<std::string_view, 5> kDepthEndings{".png", ".tiff", ".tif", ".pfm", ".pgm"};

/// The pictures of a folder by the number in their names, which counts from 1.
std::map<std::int64_t, std::string> list_pictures(const std::optional<fs::path>& folder,
                                                  const std::string& prefix,
                                                  std::span<const std::string_view> endings) {
  std::map<std::int64_t, std::string> paths;
  std::error_code ignored;
  if (!folder) return paths;
  for (const auto& entry : fs::directory_iterator(*folder, ignored)) {
    const std::string name = entry.path().filename().string();
    const std::string ending = entry.path().extension().string();
    if (!name.starts_with(prefix) ||
        std::find(endings.begin(), endings.end(), ending) == endings.end()) {
      continue;
    }
    const auto number = parse_integer(
        std::string_view(name).substr(prefix.size(), name.size() - prefix.size() - ending.size()));
    if (!number || *number < 1) continue;
    // Of two with the same number the first by name, so that the order of the folder does not
    // matter.
    std::string& path = paths[*number];
    if (path.empty() || entry.path().string() < path) path = entry.path().string();
  }
  return paths;
}

/// One camera: the stamps that have a picture, and what became of the others.
struct Stream {
  std::vector<Stamp> stamps{};
  std::vector<std::string> paths{};
  std::vector<KeptStamps::Refused> refused{};
  std::vector<std::int64_t> numbers{};  ///< of the pictures, from 1
  std::size_t stamps_without_picture = 0;
  std::size_t pictures_without_stamp = 0;
};

Stream open_stream(const std::vector<double>& seconds,
                   const std::map<std::int64_t, std::string>& pictures) {
  Stream stream;
  KeptStamps kept = keep_increasing(seconds);
  stream.refused = std::move(kept.refused);
  for (std::size_t i = 0; i < kept.stamps.size(); ++i) {
    const auto picture = pictures.find(kept.indices[i] + 1);
    if (picture == pictures.end()) {
      ++stream.stamps_without_picture;
      continue;
    }
    stream.stamps.push_back(kept.stamps[i]);
    stream.paths.push_back(picture->second);
    stream.numbers.push_back(picture->first);
  }
  const auto beyond = pictures.upper_bound(static_cast<std::int64_t>(seconds.size()));
  stream.pictures_without_stamp = static_cast<std::size_t>(std::distance(beyond, pictures.end()));
  return stream;
}

/// What a user should know about a stream that is not complete.
void note_gaps(const Stream& stream, const std::string& kind, const std::optional<fs::path>& folder,
               std::vector<std::string>& notes) {
  const std::string place = folder ? folder->filename().string() : "dataRGBD";
  if (stream.stamps_without_picture > 0) {
    notes.push_back(std::to_string(stream.stamps_without_picture) + " of " +
                    std::to_string(stream.stamps_without_picture + stream.stamps.size()) + " " +
                    kind + " pictures are not in " + place);
  }
  if (stream.pictures_without_stamp > 0) {
    notes.push_back(std::to_string(stream.pictures_without_stamp) + " " + kind + " pictures in " +
                    place + " have no stamp and are left out");
  }
}

/// Puts the refused pictures of a stream between the frames, where they would have stood.
void add_refused(const Stream& stream, const std::string& kind, bool is_depth,
                 const std::vector<PicturePair>& pairs, std::vector<KeptStamps::Refused>& refused) {
  std::size_t frame = 0;
  for (const KeptStamps::Refused& picture : stream.refused) {
    // Frames are in the order of each stream's numbers.
    for (; frame < pairs.size(); ++frame) {
      const auto place = is_depth ? pairs[frame].depth : pairs[frame].colour;
      if (place && stream.numbers[*place] > picture.index) break;
    }
    refused.push_back({static_cast<std::int64_t>(frame) - 1, picture.reason,
                       kind + " picture " + std::to_string(picture.index + 1)});
  }
}

struct Frames {
  Stream depth{};
  Stream colour{};
  std::vector<PicturePair> pairs{};

  [[nodiscard]] RgbdFrame frame(std::size_t index) const {
    const PicturePair& pair = pairs[index];
    RgbdFrame frame;
    if (pair.colour) {
      frame.stamp = frame.colour_stamp = colour.stamps[*pair.colour];
      frame.colour_path = colour.paths[*pair.colour];
    }
    if (pair.depth) {
      frame.stamp = depth.stamps[*pair.depth];
      frame.depth_path = depth.paths[*pair.depth];
      if (!pair.colour) frame.colour_stamp = frame.stamp;
    }
    return frame;
  }
};

}  // namespace

UcsdChannel open_ucsd_kinect(const NpzFile& file, const UcsdFiles& files) {
  const std::string path = files.kinect.value().string();
  UcsdChannel channel{path};
  const auto stamps = [&](const char* key) {
    return file.has(key) ? read_ucsd_stamps(file, path, key) : std::vector<double>{};
  };
  const std::string set = std::to_string(files.set);
  const bool is_disparity = holds_disparity(files);
  const auto& depth_folder = is_disparity ? files.disparity_folder : files.depth_folder;
  const std::string kind = is_disparity ? "disparity" : "depth";
  const bool has_depth_stamps = !is_disparity && file.has("depth_time_stamps");
  const std::vector<double> depth_s =
      stamps(has_depth_stamps ? "depth_time_stamps" : "disparity_time_stamps");
  const std::vector<double> colour_s = stamps("rgb_time_stamps");

  const auto depth_pictures = list_pictures(depth_folder, kind + set + "_", kDepthEndings);
  const auto colour_pictures =
      list_pictures(files.colour_folder, "rgb" + set + "_", kColourEndings);
  if (depth_pictures.empty() && colour_pictures.empty()) {
    channel.notes.push_back("there are stamps of " + std::to_string(depth_s.size()) + " " + kind +
                            " and " + std::to_string(colour_s.size()) +
                            " colour pictures, but no pictures in dataRGBD");
    return channel;
  }

  auto frames = std::make_shared<Frames>();
  frames->depth = open_stream(depth_s, depth_pictures);
  frames->colour = open_stream(colour_s, colour_pictures);
  note_gaps(frames->depth, kind, depth_folder, channel.notes);
  note_gaps(frames->colour, "colour", files.colour_folder, channel.notes);
  frames->pairs = pair_pictures(frames->depth.stamps, frames->colour.stamps,
                                longest_pair_offset(frames->depth.stamps, frames->colour.stamps));

  KeptStamps& kept = channel.kept;
  for (std::size_t i = 0; i < frames->pairs.size(); ++i) {
    kept.stamps.push_back(frames->frame(i).stamp);
    kept.indices.push_back(static_cast<std::int64_t>(i));
  }
  add_refused(frames->depth, kind, true, frames->pairs, kept.refused);
  add_refused(frames->colour, "colour", false, frames->pairs, kept.refused);
  std::stable_sort(kept.refused.begin(), kept.refused.end(),
                   [](const auto& a, const auto& b) { return a.index < b.index; });
  channel.make = [frames](Stamp, std::int64_t index) {
    return frames->frame(static_cast<std::size_t>(index));
  };
  return channel;
}

}  // namespace loopstone
