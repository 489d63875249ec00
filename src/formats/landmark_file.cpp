#include "loopstone/formats/landmark_file.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <system_error>

#include "formats/atomic_file.hpp"
#include "formats/quoted_word.hpp"
#include "formats/text_lines.hpp"
#include "formats/text_numbers.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/mrclam.hpp"

namespace loopstone {
namespace {

namespace fs = std::filesystem;

constexpr double kFarthestM = 1e7;  ///< as for the poses of a log
constexpr const char* kExpected =
    "expected a line of column names, such as id,x_m,y_m,sigma_m,radius_m";

/// The lines below the column names.
class LandmarkTable {
 public:
  LandmarkTable(std::string_view names, const Location& location) : names_(split_cells(names)) {
    constexpr std::size_t kMostColumns = 100;
    if (names_.size() > kMostColumns) {
      throw DataError(location, fmt::format("names {} columns; {}", names_.size(), kExpected));
    }
    for (const char* const needed : {"id", "x_m", "y_m"}) {
      if (!column(needed))
        throw DataError(location, fmt::format("there is no column {}; {}", needed, kExpected));
    }
    for (std::size_t i = 0; i < names_.size(); ++i) {
      if (!names_[i].empty() && column(names_[i]) != i)
        throw DataError(location, fmt::format("two columns are {}", quoted(names_[i])));
    }
  }

  [[nodiscard]] MappedLandmark read(std::string_view line, const Location& location) const {
    const std::vector<std::string_view> cells = split_cells(line);
    if (cells.size() != names_.size()) {
      throw DataError(location, fmt::format("the line has {} values, the first line names {}",
                                            cells.size(), names_.size()));
    }
    const auto cell = [&](std::string_view name) {
      const auto at = column(name);
      return at ? cells[*at] : std::string_view{};
    };
    MappedLandmark landmark;
    landmark.id = id_of(cell("id"), location);
    landmark.position = {number(cell("x_m"), "x_m", location),
                         number(cell("y_m"), "y_m", location)};
    landmark.sigma_m = size(cell("sigma_m"), "sigma_m", location);
    landmark.radius_m = size(cell("radius_m"), "radius_m", location);
    return landmark;
  }

 private:
  [[nodiscard]] std::optional<std::size_t> column(std::string_view name) const {
    for (std::size_t i = 0; i < names_.size(); ++i) {
      if (names_[i] == name) return i;
    }
    return std::nullopt;
  }

  static int id_of(std::string_view word, const Location& location) {
    const auto id = parse_integer(word);
    if (id && *id >= std::numeric_limits<int>::min() && *id <= std::numeric_limits<int>::max())
      return static_cast<int>(*id);
    throw DataError(location, fmt::format("{} can't be an id; expected a whole number of at most "
                                          "nine digits",
                                          quoted(word)));
  }

  static double number(std::string_view word, std::string_view name, const Location& location) {
    const auto value = parse_number(word);
    if (value && std::abs(*value) <= kFarthestM) return *value;
    throw DataError(location, fmt::format("{} can't be {}; expected metres, 10,000 km at most",
                                          quoted(word), name));
  }

  /// 0 where nothing is said.
  static double size(std::string_view word, std::string_view name, const Location& location) {
    constexpr double kLargestM = 100.0;
    if (word.empty()) return 0.0;
    const auto value = parse_number(word);
    if (value && *value >= 0.0 && *value <= kLargestM) return *value;
    throw DataError(location,
                    fmt::format("{} can't be {}; expected metres, 0 to 100", quoted(word), name));
  }

  std::vector<std::string_view> names_;
};

bool is_folder(const std::string& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

}  // namespace

std::vector<MappedLandmark> parse_landmarks(std::string_view text,
                                            const std::string& path_for_errors) {
  std::vector<MappedLandmark> landmarks;
  std::optional<LandmarkTable> table;
  std::map<int, std::int64_t> line_of_id;
  for_each_line(text, [&](std::string_view line, std::int64_t number) {
    const std::string_view content = trim(line.substr(0, line.find('#')));
    if (content.empty()) return;
    const Location location{path_for_errors, number};
    if (!table) {
      table.emplace(content, location);
      return;
    }
    const MappedLandmark landmark = table->read(content, location);
    const auto [first, is_new] = line_of_id.emplace(landmark.id, number);
    if (!is_new) {
      throw DataError(location, fmt::format("landmark {} is in line {} already; give each its own "
                                            "number",
                                            landmark.id, first->second));
    }
    landmarks.push_back(landmark);
  });
  if (!table) throw DataError({path_for_errors}, fmt::format("is empty; {}", kExpected));
  if (landmarks.empty()) {
    throw DataError({path_for_errors}, "names columns but no landmark; add a line for each");
  }
  return landmarks;
}

std::string format_landmarks(const std::vector<MappedLandmark>& landmarks) {
  std::string text = "id,x_m,y_m,sigma_m,radius_m\n";
  for (const MappedLandmark& landmark : landmarks) {
    text += fmt::format("{},{},{},{},{}\n", landmark.id, landmark.position.x() + 0.0,
                        landmark.position.y() + 0.0, landmark.sigma_m, landmark.radius_m);
  }
  return text;
}

std::string format_found_landmarks(std::span<const FoundLandmark> landmarks) {
  std::vector<const FoundLandmark*> by_id;
  for (const FoundLandmark& landmark : landmarks) by_id.push_back(&landmark);
  std::ranges::stable_sort(by_id, {}, [](const FoundLandmark* landmark) { return landmark->id; });
  std::string text = "id,x_m,y_m,sigma_m,radius_m,xx_m2,xy_m2,yy_m2,sightings,visits\n";
  for (const FoundLandmark* landmark : by_id) {
    const Eigen::Matrix2d& c = landmark->covariance;
    text += fmt::format("{},{:.6f},{:.6f},{:.6f},{:.3f},{:.5g},{:.5g},{:.5g},{},{}\n", landmark->id,
                        landmark->position.x() + 0.0, landmark->position.y() + 0.0,
                        landmark->sigma_m, landmark->radius_m, c(0, 0) + 0.0, c(0, 1) + 0.0,
                        c(1, 1) + 0.0, landmark->sightings, landmark->visits);
  }
  return text;
}

std::vector<MappedLandmark> read_landmarks(const std::string& path, const MemoryBudget& budget) {
  if (is_folder(path)) {
    const fs::path own = fs::path(path) / "landmarks.csv";
    if (is_file(own)) return read_landmarks(own.string(), budget);
    if (is_file(fs::path(path) / kMrclamLandmarks)) return read_mrclam_landmarks(path, budget);
    throw DataError({path}, fmt::format("there is neither landmarks.csv nor {} in this folder",
                                        kMrclamLandmarks));
  }
  if (fs::path(path).filename() == kMrclamLandmarks) {
    const fs::path folder = fs::path(path).parent_path();
    return read_mrclam_landmarks(folder.empty() ? "." : folder.string(), budget);
  }
  return parse_landmarks(read_whole_file(path, budget.most_text_bytes()), path);
}

void write_landmarks(const std::string& path, const std::vector<MappedLandmark>& landmarks) {
  write_file_atomically(path, format_landmarks(landmarks));
}

}  // namespace loopstone
