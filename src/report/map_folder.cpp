#include "loopstone/report/map_folder.hpp"

#include <algorithm>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <system_error>

#include "formats/atomic_file.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/formats/texture_files.hpp"
#include "loopstone/formats/tum.hpp"
#include "report/csv_table.hpp"

namespace loopstone {
namespace {

namespace fs = std::filesystem;

/// Pictures that go to browsers as text.
constexpr std::size_t kMostPictureBytes = std::size_t{24} << 20U;
constexpr int kPngCompression = 1;

/// Cells are read before the matrix is begun: Eigen's comma aborts when a refusal leaves it half
/// full.
Eigen::Matrix3d covariance_in(const CsvRow& row) {
  const double xx = row.number("xx_m2");
  const double xy = row.number("xy_m2");
  const double xyaw = row.number("xyaw_m_rad");
  const double yy = row.number("yy_m2");
  const double yyaw = row.number("yyaw_m_rad");
  const double yawyaw = row.number("yawyaw_rad2");
  Eigen::Matrix3d p;
  p << xx, xy, xyaw, xy, yy, yyaw, xyaw, yyaw, yawyaw;
  return p;
}

template <typename Enum>
Enum word_in(const CsvRow& row, std::string_view column) {
  const auto word = find_word<Enum>(row.text(column));
  if (!word) row.refuse(column, "has an unknown word");
  return *word;
}

Image cropped(const Image& image, int width, int height) {
  Image part = make_image(width, height, image.channels, image.bytes_per_sample);
  const auto row_bytes = [](const Image& of) {
    return static_cast<std::size_t>(of.width) * static_cast<std::size_t>(of.channels) *
           static_cast<std::size_t>(of.bytes_per_sample);
  };
  for (int row = 0; row < height; ++row) {
    const auto from = image.bytes.begin() +
                      static_cast<std::ptrdiff_t>(static_cast<std::size_t>(row) * row_bytes(image));
    std::copy_n(from, row_bytes(part),
                part.bytes.begin() +
                    static_cast<std::ptrdiff_t>(static_cast<std::size_t>(row) * row_bytes(part)));
  }
  return part;
}

/// summary.json says which part of the picture is the map; nothing when it does not.
std::optional<PlacedPicture> quality_of(const std::string& png, const std::string& summary,
                                        const MemoryBudget& budget) {
  const auto json = nlohmann::json::parse(summary, nullptr, /*allow_exceptions=*/false);
  const nlohmann::json::json_pointer place("/quality/picture");
  if (!json.is_object() || !json.contains(place) || !json[place].is_object()) return {};
  const auto number = [&](const char* name) {
    const auto found = json[place].find(name);
    return found != json[place].end() && found->is_number() ? found->get<double>() : 0.0;
  };
  const Image image = decode_png(png, "quality.png", budget);
  const double width = number("width_px");
  const double height = number("height_px");
  if (!(width >= 1.0 && width <= image.width && height >= 1.0 && height <= image.height)) return {};
  return PlacedPicture{
      .png = encode_png(cropped(image, static_cast<int>(width), static_cast<int>(height)),
                        kPngCompression),
      .corner = {number("x_m"), number("y_m")},
      .resolution_m = number("resolution_m")};
}

std::optional<PlacedPicture> texture_of(const std::string& yaml) {
  const TextureInfo info = read_texture_yaml(yaml);
  return PlacedPicture{.png = read_whole_file(info.image, kMostPictureBytes),
                       .corner = info.map_T_corner.translation(),
                       .resolution_m = info.resolution_m};
}

}  // namespace

std::vector<StampedClosure> parse_closure_csv(std::string_view text,
                                              const std::string& path_for_errors) {
  std::vector<StampedClosure> closures;
  for_each_csv_row(text, path_for_errors, [&](const CsvRow& row) {
    StampedClosure read{.from = row.stamp_or_nothing("from_t_s"),
                        .to = row.stamp_or_nothing("to_t_s")};
    LoopClosure& closure = read.closure;
    closure.from = NodeId{row.count("from_node")};
    closure.to = NodeId{row.count("to_node")};
    closure.from_submap = {static_cast<std::size_t>(row.count("from_submap"))};
    closure.to_submap = {static_cast<std::size_t>(row.count("to_submap"))};
    closure.from_T_to = {row.number("x_m"), row.number("y_m"), row.number("yaw_rad")};
    closure.covariance = covariance_in(row);
    closure.score = row.number("score");
    closure.second_score = row.number_or_nothing("second_score");
    closure.overlap = row.number("overlap");
    closure.agreement = row.number("agreement");
    closure.chi2 = row.number_or_nothing("chi2");
    closure.by_appearance = row.number("by_appearance") != 0.0;
    closure.state = word_in<ClosureState>(row, "state");
    closure.reason = word_in<ClosureReason>(row, "reason");
    closures.push_back(std::move(read));
  });
  return closures;
}

std::vector<Eigen::Matrix3d> parse_covariance_csv(std::string_view text,
                                                  const Trajectory& trajectory,
                                                  const std::string& path_for_errors) {
  std::vector<Eigen::Matrix3d> covariances;
  for_each_csv_row(text, path_for_errors, [&](const CsvRow& row) {
    const auto stamp = row.stamp_or_nothing("t_s");
    if (covariances.size() >= trajectory.size() || !stamp ||
        trajectory.poses()[covariances.size()].stamp != *stamp)
      row.refuse("t_s", "is not the time of the pose in trajectory.tum");
    covariances.push_back(covariance_in(row));
  });
  if (covariances.size() != trajectory.size())
    throw DataError({path_for_errors}, "has fewer poses than trajectory.tum");
  return covariances;
}

MapFolder read_map_folder(const std::string& folder, const MemoryBudget& budget) {
  const auto path_of = [&](const char* name) { return (fs::path(folder) / name).string(); };
  MapFolder read;
  read.trajectory = read_tum(path_of("trajectory.tum"), budget);
  const auto attempt = [&](const char* name, const std::function<void(const std::string&)>& take) {
    const std::string path = path_of(name);
    std::error_code ignored;
    if (!fs::exists(path, ignored)) return;
    try {
      take(path);
    } catch (const std::exception& error) {
      read.left_out.emplace_back(error.what());
    }
  };
  const std::size_t most_text = budget.most_text_bytes();
  attempt("trajectory.csv", [&](const std::string& path) {
    read.covariances =
        parse_covariance_csv(read_whole_file(path, most_text), read.trajectory, path);
  });
  attempt("loop_closures.csv", [&](const std::string& path) {
    read.closures = parse_closure_csv(read_whole_file(path, most_text), path);
  });
  attempt("map.yaml", [&](const std::string& path) { read.cells = read_ros_map(path, budget); });
  attempt("summary.json",
          [&](const std::string& path) { read.summary_json = read_whole_file(path, most_text); });
  attempt("quality.png", [&](const std::string& path) {
    read.quality = quality_of(read_whole_file(path, kMostPictureBytes), read.summary_json, budget);
  });
  attempt("texture.yaml", [&](const std::string& path) { read.texture = texture_of(path); });
  return read;
}

}  // namespace loopstone
