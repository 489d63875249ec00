#include "registration/search_lattice.hpp"

#include <algorithm>
#include <cmath>

#include "loopstone/geometry/angle.hpp"

namespace loopstone {

Pose2 SearchLattice::pose_at(std::size_t heading, int column, int row) const {
  const Pose2 rotation{0.0, 0.0, headings[heading]};
  const Eigen::Vector2d moved_pivot = pivot_in_target + resolution_m * Eigen::Vector2d(column, row);
  const Eigen::Vector2d translation = moved_pivot - rotation * pivot;
  return {translation.x(), translation.y(), wrap_angle(headings[heading])};
}

SearchLattice make_search_lattice(std::span<const Eigen::Vector2d> source, const GridFrame& frame,
                                  const SearchWindow& window) {
  SearchLattice lattice;
  lattice.resolution_m = frame.resolution;
  lattice.pivot = Eigen::Vector2d::Zero();
  for (const auto& point : source) lattice.pivot += point;
  lattice.pivot /= static_cast<double>(source.size());
  lattice.pivot_in_target = window.centre * lattice.pivot;
  double reach = frame.resolution;
  for (const auto& point : source) reach = std::max(reach, (point - lattice.pivot).norm());
  const double step = frame.resolution / reach;
  lattice.heading_step_rad = step;
  const int half_headings = std::min(static_cast<int>(std::ceil(window.half_yaw_rad / step)),
                                     static_cast<int>(std::floor(kPi / step)));
  for (int i = -half_headings; i <= half_headings; ++i)
    lattice.headings.push_back(window.centre.yaw + i * step);
  lattice.half_cells = static_cast<int>(std::ceil(window.half_xy_m / frame.resolution));
  return lattice;
}

std::vector<Eigen::Vector2d> arms_of(std::span<const Eigen::Vector2d> source,
                                     const SearchLattice& lattice) {
  std::vector<Eigen::Vector2d> arms;
  arms.reserve(source.size());
  for (const auto& point : source) arms.emplace_back(point - lattice.pivot);
  return arms;
}

CellList cells_at(std::span<const Eigen::Vector2d> arms, const GridFrame& frame,
                  const SearchLattice& lattice, std::size_t heading) {
  const double cosine = std::cos(lattice.headings[heading]);
  const double sine = std::sin(lattice.headings[heading]);
  CellList list;
  list.columns.resize(arms.size());
  list.rows.resize(arms.size());
  for (std::size_t i = 0; i < arms.size(); ++i) {
    const double x = lattice.pivot_in_target.x() + (cosine * arms[i].x() - sine * arms[i].y());
    const double y = lattice.pivot_in_target.y() + (sine * arms[i].x() + cosine * arms[i].y());
    list.columns[i] = floor_to_int((x - frame.origin.x()) / frame.resolution);
    list.rows[i] = floor_to_int((y - frame.origin.y()) / frame.resolution);
  }
  return list;
}

}  // namespace loopstone
