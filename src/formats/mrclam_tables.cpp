#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <set>
#include <utility>

#include "formats/atomic_file.hpp"
#include "formats/mrclam_line.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/mrclam.hpp"
#include "loopstone/geometry/angle.hpp"

namespace loopstone {

namespace fs = std::filesystem;

namespace {

constexpr double kFarthestM = 1e7;

}  // namespace

std::optional<int> BarcodeTable::subject_of(int barcode) const {
  const auto found = subjects.find(barcode);
  if (found == subjects.end()) return std::nullopt;
  return found->second;
}

BarcodeTable parse_barcodes(std::string_view text, const std::string& path_for_errors) {
  BarcodeTable table;
  for_each_line(text, [&](std::string_view line, std::int64_t number) {
    const std::string_view content = without_comment(line);
    if (content.empty()) return;
    const Location location{path_for_errors, number};
    const std::vector<std::string_view> words = split_words(content);
    if (words.size() != 2) {
      throw DataError(location,
                      fmt::format("expected 2 values (subject, barcode), found {}", words.size()));
    }
    const auto subject = whole(parse_finite(words[0], location));
    const auto barcode = whole(parse_finite(words[1], location));
    if (!subject || !barcode) throw DataError(location, "subject and barcode are whole numbers");
    if (table.subject_of(*barcode)) {
      throw DataError(location, fmt::format("barcode {} is carried by subject {} already", *barcode,
                                            *table.subject_of(*barcode)));
    }
    table.subjects.emplace(*barcode, *subject);
  });
  if (table.subjects.empty()) {
    throw DataError({path_for_errors}, "holds no barcodes; expected lines of subject and barcode");
  }
  return table;
}

std::vector<MappedLandmark> parse_mrclam_landmarks(std::string_view text,
                                                   const std::string& path_for_errors) {
  std::vector<MappedLandmark> landmarks;
  std::set<int> known;
  for_each_line(text, [&](std::string_view line, std::int64_t number) {
    const std::string_view content = without_comment(line);
    if (content.empty()) return;
    const Location location{path_for_errors, number};
    const std::vector<std::string_view> words = split_words(content);
    if (words.size() != 5) {
      throw DataError(location,
                      fmt::format("expected 5 values (subject, x, y, sigma x, sigma y), found {}",
                                  words.size()));
    }
    std::array<double, 5> v{};
    for (std::size_t i = 0; i < v.size(); ++i) v[i] = parse_finite(words[i], location);
    const auto id = whole(v[0]);
    if (!id) throw DataError(location, "the subject is a whole number");
    if (std::abs(v[1]) > kFarthestM || std::abs(v[2]) > kFarthestM)
      throw DataError(location, "the landmark is farther than 10,000 km away");
    if (v[3] < 0.0 || v[4] < 0.0) throw DataError(location, "standard deviations are 0 or more");
    if (!known.insert(*id).second)
      throw DataError(location, fmt::format("landmark {} is given twice", *id));
    landmarks.push_back({.id = *id, .position = {v[1], v[2]}, .sigma_m = std::max(v[3], v[4])});
  });
  if (landmarks.empty()) {
    throw DataError({path_for_errors},
                    "holds no landmarks; expected lines of subject, x, y, sigma x, sigma y");
  }
  return landmarks;
}

Trajectory parse_mrclam_truth(std::string_view text, const std::string& path_for_errors) {
  std::vector<StampedPose2> poses;
  for_each_line(text, [&](std::string_view line, std::int64_t number) {
    const std::string_view content = without_comment(line);
    if (content.empty()) return;
    const auto read = timed_line<3>(content, "time, x, y, heading");
    if (!read.fault.empty()) throw DataError({path_for_errors, number}, read.fault);
    poses.push_back({read.stamp, {read.values[0], read.values[1], wrap_angle(read.values[2])}});
  });
  if (poses.empty()) {
    throw DataError({path_for_errors}, "holds no poses; expected lines of time, x, y, heading");
  }
  return Trajectory(std::move(poses));
}

std::vector<MappedLandmark> read_mrclam_landmarks(const std::string& folder,
                                                  const MemoryBudget& budget) {
  const fs::path path = fs::path(folder) / kMrclamLandmarks;
  return parse_mrclam_landmarks(read_whole_file(path.string(), budget.most_text_bytes()),
                                path.string());
}

bool is_mrclam_truth(const std::string& path) {
  const std::string name = fs::path(path).filename().string();
  return name.starts_with("Robot") && name.ends_with("_Groundtruth.dat");
}

Trajectory read_mrclam_truth(const std::string& path, const MemoryBudget& budget) {
  return parse_mrclam_truth(read_whole_file(path, budget.most_text_bytes()), path);
}

}  // namespace loopstone
