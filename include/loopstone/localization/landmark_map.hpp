#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <unordered_map>
#include <vector>

namespace loopstone {

/// A landmark whose place is known, and how well.
struct MappedLandmark {
  int id = 0;
  Eigen::Vector2d position{0.0, 0.0};  ///< of its centre, map frame [m]
  double sigma_m = 0.0;                ///< standard deviation of x and of y
  double radius_m = 0.0;               ///< of a round one, which sensors meet at its surface
};

/// Landmarks that can be asked for by number and by place. Immutable.
class LandmarkMap {
 public:
  /// Throws UsageError for no landmarks, an id that occurs twice, and numbers that are not finite
  /// or negative.
  explicit LandmarkMap(std::vector<MappedLandmark> landmarks);

  [[nodiscard]] const std::vector<MappedLandmark>& landmarks() const { return landmarks_; }
  [[nodiscard]] std::size_t size() const { return landmarks_.size(); }
  [[nodiscard]] const MappedLandmark& operator[](std::size_t index) const {
    return landmarks_[index];
  }
  [[nodiscard]] std::optional<std::size_t> index_of(int id) const;
  [[nodiscard]] double largest_sigma_m() const { return largest_sigma_m_; }
  [[nodiscard]] double largest_radius_m() const { return largest_radius_m_; }
  /// Indices of those no farther from a point than this, ascending. Cost: O(log n + those of about
  /// the same x).
  [[nodiscard]] std::vector<std::size_t> within(const Eigen::Vector2d& point, double reach_m) const;

 private:
  std::vector<MappedLandmark> landmarks_;
  std::unordered_map<int, std::size_t> index_of_id_;
  std::vector<std::size_t> by_x_;
  double largest_sigma_m_ = 0.0;
  double largest_radius_m_ = 0.0;
};

}  // namespace loopstone
