#include "slam/surface_segments.hpp"

#include <algorithm>
#include <utility>

#include "slam/surface_adjustment_numbers.hpp"

namespace loopstone {

/// What one segment saw of a patch: sums over its sights, as if they were of one rigid body.
struct SurfaceSegments::Group {
  int segment;
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();                          // sum w J^T J
  Eigen::Matrix<double, 3, 2> b = Eigen::Matrix<double, 3, 2>::Zero();  // sum w J^T (1, t)
};

SurfaceSegments::SurfaceSegments(std::span<const Pose2> map_T_key, std::span<const int> places,
                                 std::size_t size, const std::vector<bool>& ends) {
  members_.resize(size);
  constexpr auto kKeys = static_cast<std::size_t>(kSurfaceAdjustment.keys_per_segment);
  std::size_t inside = kKeys;
  std::vector<std::size_t> counts;
  std::vector<int> segment_of(places.size(), -1);
  for (std::size_t key = 0; key < places.size(); ++key) {
    if (places[key] < 0) continue;
    if (inside == kKeys || (!ends.empty() && ends[key] && inside > 0)) {
      centres_.emplace_back(Eigen::Vector2d::Zero());
      counts.push_back(0);
      inside = 0;
    }
    ++inside;
    segment_of[key] = static_cast<int>(centres_.size()) - 1;
    centres_.back() += map_T_key[key].translation();
    ++counts.back();
  }
  for (std::size_t i = 0; i < counts.size(); ++i) centres_[i] /= static_cast<double>(counts[i]);

  for (std::size_t key = 0; key < places.size(); ++key) {
    if (places[key] < 0) continue;
    const Eigen::Vector2d offset =
        map_T_key[key].translation() - centres_[static_cast<std::size_t>(segment_of[key])];
    members_[static_cast<std::size_t>(places[key])] = {segment_of[key], offset.x(), offset.y()};
  }
  moved_.resize(centres_.size());
}

Eigen::Matrix3d SurfaceSegments::motion_of(const Member& member) {
  Eigen::Matrix3d p = Eigen::Matrix3d::Identity();
  p(0, 2) = -member.y;
  p(1, 2) = member.x;
  return p;
}

template <typename Visitor>
void SurfaceSegments::for_each_patch(const SurfaceSystem& surfaces, Visitor&& visit) const {
  std::vector<Group> groups;
  const SurfacePatches& patches = surfaces.patches();
  for (std::size_t i = 0; i < patches.patches.size(); ++i) {
    const SharedSurface& patch = patches.patches[i];
    groups.clear();
    for (std::size_t k = patch.first; k < patch.last; ++k) {
      const SurfaceSystem::Row& row = surfaces.rows()[k];
      if (row.place < 0) continue;
      const Member& member = members_[static_cast<std::size_t>(row.place)];
      if (groups.empty() || groups.back().segment != member.segment)
        groups.push_back({.segment = member.segment});
      Group& group = groups.back();
      const Eigen::Vector3d jacobian =
          motion_of(member).transpose() * surfaces.jacobian(patch.normal, row);
      const Eigen::Vector3d weighted = static_cast<double>(row.weight) * jacobian;
      group.a += weighted * jacobian.transpose();
      group.b.col(0) += weighted;
      group.b.col(1) += static_cast<double>(row.along) * weighted;
    }
    visit(i, std::as_const(groups));
  }
}

Eigen::Matrix3d SurfaceSegments::motion_at(int place, const Eigen::Vector2d& offset) const {
  Member member = members_[static_cast<std::size_t>(place)];
  member.x += offset.x();
  member.y += offset.y();
  return motion_of(member);
}

void SurfaceSegments::build_pattern(const SurfaceSystem* surfaces,
                                    std::span<const std::pair<int, int>> linked) {
  const std::size_t count = centres_.size();
  std::vector<bool> joined(count * count, false);
  std::vector<std::pair<int, int>> pairs;
  const auto join = [&](int a, int b) {
    if (a == b) return;
    const auto [low, high] = std::minmax(a, b);
    const std::size_t bit = static_cast<std::size_t>(low) * count + static_cast<std::size_t>(high);
    if (joined[bit]) return;
    joined[bit] = true;
    pairs.emplace_back(low, high);
  };
  if (surfaces != nullptr) {
    for_each_patch(*surfaces, [&](std::size_t, const std::vector<Group>& groups) {
      for (std::size_t a = 0; a < groups.size(); ++a) {
        for (std::size_t b = 0; b < a; ++b) join(groups[a].segment, groups[b].segment);
      }
    });
  }
  for (const auto& [a, b] : linked) join(segment_of(a), segment_of(b));
  const std::vector<int> order = fill_reducing_order(static_cast<int>(count), pairs);
  for (Member& member : members_) {
    if (member.segment >= 0) member.segment = order[static_cast<std::size_t>(member.segment)];
  }
  for (auto& [a, b] : pairs) {
    a = order[static_cast<std::size_t>(a)];
    b = order[static_cast<std::size_t>(b)];
  }
  matrix_ = block_matrix(static_cast<int>(count), std::move(pairs));
}

void SurfaceSegments::add(int row, int column, const Eigen::Matrix3d& value) {
  if (row == column) {
    matrix_.diagonal[static_cast<std::size_t>(row)] += value;
    return;
  }
  const auto [low, high] = std::minmax(row, column);
  const auto begin = matrix_.rows.begin() + matrix_.column_start[static_cast<std::size_t>(low)];
  const auto end = matrix_.rows.begin() + matrix_.column_start[static_cast<std::size_t>(low) + 1];
  const auto at =
      static_cast<std::size_t>(std::lower_bound(begin, end, high) - matrix_.rows.begin());
  if (row == high) {
    matrix_.below[at] += value;
  } else {
    matrix_.below[at] += value.transpose();
  }
}

void SurfaceSegments::add_surfaces(const SurfaceSystem& surfaces) {
  for_each_patch(surfaces, [&](std::size_t index, const std::vector<Group>& groups) {
    const Eigen::Matrix2d inverse = surfaces.inverse(index);
    for (std::size_t a = 0; a < groups.size(); ++a) {
      const Eigen::Matrix<double, 3, 2> left = groups[a].b * inverse;
      add(groups[a].segment, groups[a].segment, groups[a].a - left * groups[a].b.transpose());
      for (std::size_t b = 0; b < a; ++b) {
        const Eigen::Matrix3d value = -left * groups[b].b.transpose();
        add(groups[a].segment, groups[b].segment, value);
        // A segment may come back to a patch.
        if (groups[a].segment == groups[b].segment)
          add(groups[a].segment, groups[a].segment, value.transpose());
      }
    }
  });
}

bool SurfaceSegments::factorise(const SurfaceSystem& surfaces, const BlockMatrix& graph) {
  std::vector<std::pair<int, int>> linked;
  for (std::size_t column = 0; column < graph.diagonal.size(); ++column) {
    for (int k = graph.column_start[column]; k < graph.column_start[column + 1]; ++k) {
      const int row = graph.rows[static_cast<std::size_t>(k)];
      const int other = static_cast<int>(column);
      if (segment_of(row) >= 0 && segment_of(other) >= 0) linked.emplace_back(row, other);
    }
  }
  build_pattern(&surfaces, linked);
  add_surfaces(surfaces);
  for (std::size_t column = 0; column < graph.diagonal.size(); ++column) {
    const Member& to = members_[column];
    if (to.segment < 0) continue;
    const Eigen::Matrix3d right = motion_of(to);
    add(to.segment, to.segment, right.transpose() * graph.diagonal[column] * right);
    for (int k = graph.column_start[column]; k < graph.column_start[column + 1]; ++k) {
      const auto at = static_cast<std::size_t>(k);
      const Member& from = members_[static_cast<std::size_t>(graph.rows[at])];
      if (from.segment < 0) continue;
      const Eigen::Matrix3d value = motion_of(from).transpose() * graph.below[at] * right;
      add(from.segment, to.segment, value);
      if (from.segment == to.segment) add(to.segment, to.segment, value.transpose());
    }
  }
  solver_.emplace(matrix_);
  return solver_->factorise(matrix_);
}

void SurfaceSegments::add_links(std::span<const Link> links) {
  for (const Link& link : links) {
    const int to = segment_of(link.to);
    const Eigen::Matrix3d of_to = motion_at(link.to, link.to_T_point);
    const Eigen::Matrix3d weighted = of_to.transpose() * link.information;
    add(to, to, weighted * of_to);
    if (link.from < 0) continue;
    const int from = segment_of(link.from);
    const Eigen::Matrix3d of_from = motion_at(link.from, link.from_T_point);
    add(from, from, of_from.transpose() * link.information * of_from);
    const Eigen::Matrix3d across = -weighted * of_from;
    add(to, from, across);
    if (to == from) add(to, to, across.transpose());
  }
}

bool SurfaceSegments::factorise(const SurfaceSystem* surfaces, std::span<const Link> links) {
  std::vector<std::pair<int, int>> linked;
  for (const Link& link : links) {
    if (link.from >= 0) linked.emplace_back(link.from, link.to);
  }
  build_pattern(surfaces, linked);
  if (surfaces != nullptr) add_surfaces(*surfaces);
  add_links(links);
  solver_.emplace(matrix_);
  return solver_->factorise(matrix_);
}

void SurfaceSegments::gather(const SurfaceSystem& surfaces) {
  std::vector<int> first_place(size(), -1);
  for (std::size_t place = 0; place < members_.size(); ++place) {
    const int segment = members_[place].segment;
    if (segment >= 0) first_place[static_cast<std::size_t>(segment)] = static_cast<int>(place);
  }
  std::vector<std::pair<int, int>> linked;
  for (std::size_t i = 0; i + 1 < first_place.size(); ++i)
    linked.emplace_back(first_place[i], first_place[i + 1]);
  build_pattern(&surfaces, linked);
  add_surfaces(surfaces);
}

bool SurfaceSegments::factorise_along(std::span<const Link> links) {
  BlockMatrix of_surfaces = matrix_;
  add_links(links);
  solver_.emplace(matrix_);
  const bool done = solver_->factorise(matrix_);
  matrix_ = std::move(of_surfaces);
  return done;
}

std::vector<Eigen::Vector3d> SurfaceSegments::response_to(std::span<const Link> links,
                                                          std::span<const Eigen::Vector2d> off) {
  std::vector<Eigen::Vector3d> moved(size(), Eigen::Vector3d::Zero());
  for (std::size_t i = 0; i < links.size(); ++i) {
    const Link& link = links[i];
    const Eigen::Vector3d pull = link.information.leftCols<2>() * off[i];
    moved[static_cast<std::size_t>(segment_of(link.to))] +=
        motion_at(link.to, link.to_T_point).transpose() * pull;
    if (link.from < 0) continue;
    moved[static_cast<std::size_t>(segment_of(link.from))] -=
        motion_at(link.from, link.from_T_point).transpose() * pull;
  }
  solver_->solve_in_place(moved);
  return moved;
}

void SurfaceSegments::add_correction(std::span<const Eigen::Vector3d> r,
                                     std::span<Eigen::Vector3d> z) {
  std::fill(moved_.begin(), moved_.end(), Eigen::Vector3d::Zero());
  for (std::size_t i = 0; i < members_.size(); ++i) {
    const Member& m = members_[i];
    if (m.segment < 0) continue;
    moved_[static_cast<std::size_t>(m.segment)] +=
        Eigen::Vector3d(r[i].x(), r[i].y(), r[i].z() - m.y * r[i].x() + m.x * r[i].y());
  }
  solver_->solve_in_place(moved_);
  for (std::size_t i = 0; i < members_.size(); ++i) {
    const Member& m = members_[i];
    if (m.segment < 0) continue;
    const Eigen::Vector3d& d = moved_[static_cast<std::size_t>(m.segment)];
    z[i] += Eigen::Vector3d(d.x() - m.y * d.z(), d.y() + m.x * d.z(), d.z());
  }
}

}  // namespace loopstone
