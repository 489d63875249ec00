#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/base/memory_budget.hpp"
#include "loopstone/localization/landmark_map.hpp"
#include "loopstone/localization/landmark_mapping.hpp"

namespace loopstone {

/// Landmarks as comma-separated values: a line of column names, then one line a landmark.
///
///   id         a whole number, no other landmark's
///   x_m,y_m    of its centre, map frame
///   sigma_m    standard deviation of x and of y; 0 when the column or the value is absent
///   radius_m   of a round one, whose surface a laser meets; 0, a flat one, when absent
///
/// Columns in any order, unknown ones are passed over; empty lines and what follows # are, too.
/// Throws DataError with the line for anything else, for an id that occurs twice (with both lines)
/// and for no landmarks.
[[nodiscard]] std::vector<MappedLandmark> parse_landmarks(
    std::string_view text, const std::string& path_for_errors = "landmarks");

/// What parse_landmarks reads; numbers have as many digits as bring the same value back.
[[nodiscard]] std::string format_landmarks(const std::vector<MappedLandmark>& landmarks);

/// Landmarks that were found, in the order of their ids. What parse_landmarks reads, and behind it
/// columns that it passes over:
///
///   xx_m2,xy_m2,yy_m2  covariance against the first pose, axes of the map; sigma_m is its largest
///   sightings,visits   how often it was seen, and how often it came into view
///
/// With every landmark left out, as where none was found, the line of names alone.
[[nodiscard]] std::string format_found_landmarks(std::span<const FoundLandmark> landmarks);

/// From a file, or of a folder its landmarks.csv; or UTIAS MRCLAM's Landmark_Groundtruth.dat, by
/// that name or the folder that holds it (mrclam.hpp).
[[nodiscard]] std::vector<MappedLandmark> read_landmarks(const std::string& path,
                                                         const MemoryBudget& budget = {});
void write_landmarks(const std::string& path, const std::vector<MappedLandmark>& landmarks);

}  // namespace loopstone
