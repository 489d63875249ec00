#include "loopstone/formats/ros_map.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "formats/atomic_file.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

constexpr double kOccupiedProbability = 0.65;

std::uint8_t grey_of(std::int8_t state) {
  if (state == kUnknownCell) return 205;
  return state == kOccupiedCell ? 0 : 254;
}

/// One pixel by the rules of nav2's map_io.
class PixelRule {
 public:
  PixelRule(const Image& image, const RosMapInfo& info) : image_(image), info_(info) {}

  [[nodiscard]] std::int8_t state_at(int row, int column) const {
    const int colours = image_.has_alpha() ? image_.channels - 1 : image_.channels;
    double sum = 0.0;
    for (int channel = 0; channel < colours; ++channel) sum += image_.sample(row, column, channel);
    const double grey = sum / (colours * static_cast<double>(image_.max_value));  // [0, 1]
    if (info_.mode == MapMode::kRaw) {
      const auto value = std::lround(grey * 255.0);
      return value > 100 ? kUnknownCell : static_cast<std::int8_t>(value);
    }
    if (image_.has_alpha() && image_.sample(row, column, colours) < image_.max_value)
      return kUnknownCell;
    const double occupancy = info_.negate ? grey : 1.0 - grey;
    if (occupancy >= info_.occupied_threshold) return kOccupiedCell;
    if (occupancy <= info_.free_threshold) return kFreeCell;
    if (info_.mode == MapMode::kTrinary) return kUnknownCell;
    const double share =
        (occupancy - info_.free_threshold) / (info_.occupied_threshold - info_.free_threshold);
    return static_cast<std::int8_t>(std::lround(100.0 * share));
  }

 private:
  const Image& image_;
  const RosMapInfo& info_;
};

/// The grid along the axes of the map frame that covers a rotated picture.
GridFrame rotated_frame(const Image& image, const RosMapInfo& info) {
  Eigen::Vector2d low = info.map_T_corner.translation();
  Eigen::Vector2d high = low;
  const Eigen::Vector2d size(image.width * info.resolution_m, image.height * info.resolution_m);
  for (const auto& corner :
       {Eigen::Vector2d(size.x(), 0.0), Eigen::Vector2d(0.0, size.y()), size}) {
    low = low.cwiseMin(info.map_T_corner * corner);
    high = high.cwiseMax(info.map_T_corner * corner);
  }
  return frame_covering(low, high, info.resolution_m);
}

/// How many cells a picture becomes. Throws DataError when no grid has so many.
std::uint64_t cells_of(const Image& image, const RosMapInfo& info, const std::string& path) {
  const std::uint64_t pixels =
      static_cast<std::uint64_t>(image.width) * static_cast<std::uint64_t>(image.height);
  if (info.map_T_corner.yaw == 0.0) return pixels;
  try {
    return pixels + rotated_frame(image, info).cell_count();
  } catch (const UsageError& error) {
    throw DataError({path}, error.what());
  }
}

CellStates rotated_to_axes(const CellStates& corner_cells, const GridFrame& frame,
                           const Pose2& map_T_corner) {
  const GridFrame& source = corner_cells.frame();
  CellStates result(frame, kUnknownCell);
  const Pose2 corner_T_map = map_T_corner.inverse();
  for (int row = 0; row < result.frame().rows; ++row) {
    for (int column = 0; column < result.frame().columns; ++column) {
      const Cell from = source.cell_of(corner_T_map * result.frame().centre_of({column, row}));
      result[{column, row}] = corner_cells.value_or(from, kUnknownCell);
    }
  }
  return result;
}

RosMapInfo read_map_yaml(const std::string& path) {
  return parse_map_yaml(read_whole_file(path, std::size_t{1} << 20), path);
}

std::string picture_of(const std::string& yaml_path, const RosMapInfo& info) {
  return (std::filesystem::path(yaml_path).parent_path() / info.image).string();
}

}  // namespace

CellStates cell_states(const OccupancyMap& map) {
  // Compared in log-odds; equal to comparing probabilities.
  const auto occupied =
      static_cast<float>(std::log(kOccupiedProbability / (1.0 - kOccupiedProbability)));
  CellStates states(map.log_odds.frame(), kUnknownCell);
  for (std::size_t i = 0; i < states.cells().size(); ++i) {
    const float log_odds = map.log_odds.cells()[i];
    if (map.observed.cells()[i] == 0) continue;
    if (log_odds >= occupied) states.cells()[i] = kOccupiedCell;
    if (log_odds < 0.0F) states.cells()[i] = kFreeCell;
  }
  return states;
}

Image map_image(const CellStates& cells) {
  const GridFrame& frame = cells.frame();
  Image image = make_image(frame.columns, frame.rows, 1);
  std::size_t i = 0;
  for (int row = frame.rows - 1; row >= 0; --row) {
    for (int column = 0; column < frame.columns; ++column)
      image.bytes[i++] = grey_of(cells[{column, row}]);
  }
  return image;
}

std::string format_map_yaml(const GridFrame& frame, const std::string& image_name) {
  return fmt::format(
      "image: {}\nmode: trinary\nresolution: {}\norigin: [{}, {}, 0]\nnegate: 0\noccupied_thresh: "
      "0.65\n"
      "free_thresh: 0.196\n",
      image_name, frame.resolution, frame.origin.x(), frame.origin.y());
}

void write_ros_map(const std::string& yaml_path, const CellStates& cells) {
  const std::filesystem::path image_path =
      std::filesystem::path(yaml_path).replace_extension(".pgm");
  AtomicFile image(image_path.string());
  image.write(encode_pgm(map_image(cells)));
  image.finish_writing();
  AtomicFile yaml(yaml_path);
  yaml.write(format_map_yaml(cells.frame(), image_path.filename().string()));
  yaml.finish_writing();
  image.commit();
  yaml.commit();
}

CellStates interpret_map(const Image& image, const RosMapInfo& info) {
  const bool along_axes = info.map_T_corner.yaw == 0.0;
  const GridFrame frame{
      .origin = along_axes ? info.map_T_corner.translation() : Eigen::Vector2d::Zero().eval(),
      .resolution = info.resolution_m,
      .columns = image.width,
      .rows = image.height};
  CellStates cells(frame, kUnknownCell);
  const PixelRule rule(image, info);
  for (int row = 0; row < frame.rows; ++row) {
    for (int column = 0; column < frame.columns; ++column) {
      cells[{column, row}] = rule.state_at(frame.rows - 1 - row, column);
    }
  }
  return along_axes ? cells : rotated_to_axes(cells, rotated_frame(image, info), info.map_T_corner);
}

std::string ros_map_picture(const std::string& yaml_path) {
  return picture_of(yaml_path, read_map_yaml(yaml_path));
}

CellStates read_ros_map(const std::string& yaml_path, const MemoryBudget& budget,
                        std::uint64_t work_bytes_per_cell) {
  const RosMapInfo info = read_map_yaml(yaml_path);
  const std::string path = picture_of(yaml_path, info);
  const std::string bytes = read_whole_file(path, budget.ceiling_bytes);
  const Image image = decode_image(bytes, path, budget);
  const std::uint64_t cells = cells_of(image, info, path);
  budget.require(saturated_product(cells, work_bytes_per_cell + 1) + image.bytes.size(),
                 bytes.size(), Growth::kMap, {path});
  return interpret_map(image, info);
}

}  // namespace loopstone
