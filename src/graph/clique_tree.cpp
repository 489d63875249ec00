#include "graph/clique_tree.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "graph/elimination_order.hpp"
#include "graph/small_order.hpp"

namespace loopstone {

namespace {

constexpr int kNone = -1;
/// Parts up to this size are ordered as rows of bits.
constexpr int kSmall = 1500;
constexpr std::size_t kLeastValues = 64;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

using MapVector = Eigen::Map<Eigen::Vector3d>;

}  // namespace

std::size_t CliqueTree::Clique::value_count() const {
  const std::size_t panel = pivot_count() * padded_rows(pivot_count() + below_count());
  const std::size_t update = below_count() * padded_rows(below_count());
  return panel + update + 2 * pivot_count() + padded_rows(below_count()) + kFrontSlack;
}

DenseFront CliqueTree::Clique::dense() {
  double* panel = values.data();
  double* update = panel + pivot_count() * padded_rows(pivot_count() + below_count());
  return {panel, update, update + below_count() * padded_rows(below_count()),
          pivot_count() + below_count(), pivot_count()};
}

double* CliqueTree::Clique::forward() { return dense().inverse_diagonal + pivot_count(); }
double* CliqueTree::Clique::left_over() { return forward() + pivot_count(); }

CliqueTree::SpareValues::Shelf CliqueTree::SpareValues::shelf(std::size_t count) {
  // Four capacities to each doubling.
  Shelf result{0, kLeastValues};
  std::size_t quarter = kLeastValues / 4;
  while (result.capacity < count) {
    result.capacity += quarter;
    if (++result.index % 4 == 0) quarter *= 2;
  }
  if (shelves_.size() <= result.index) shelves_.resize(result.index + 1);
  return result;
}

std::vector<double> CliqueTree::SpareValues::zeros(std::size_t count) {
  const Shelf where = shelf(count);
  std::vector<double> values;
  if (std::vector<std::vector<double>>& spare = shelves_[where.index]; !spare.empty()) {
    values = std::move(spare.back());
    spare.pop_back();
  } else {
    values.reserve(where.capacity);
  }
  values.assign(count, 0.0);
  return values;
}

void CliqueTree::SpareValues::take_back(std::vector<double> values) {
  shelves_[shelf(values.size()).index].push_back(std::move(values));
}

void CliqueTree::clear() { *this = CliqueTree(); }

void CliqueTree::resize(std::size_t variables) {
  for (std::size_t i = clique_of_.size(); i < variables; ++i) {
    unattached_.push_back(static_cast<int>(i));
  }
  clique_of_.resize(variables, kNone);
  delta_.resize(variables, Eigen::Vector3d::Zero());
  passed_on_.resize(variables, Eigen::Vector3d::Zero());
  local_.resize(variables, kNone);
  changed_in_.resize(variables, 0);
}

int CliqueTree::new_clique() {
  if (free_.empty()) {
    cliques_.emplace_back();
    return static_cast<int>(cliques_.size()) - 1;
  }
  const int clique = free_.back();
  free_.pop_back();
  return clique;
}

CliqueTree::Part CliqueTree::detach(std::span<const int> touched) {
  Part part;
  std::vector<int> removed;
  for (const int variable : touched) {
    for (int c = clique_of_[at(variable)]; c != kNone && cliques_[at(c)].alive;
         c = cliques_[at(c)].parent) {
      cliques_[at(c)].alive = false;
      removed.push_back(c);
    }
  }
  for (const int c : removed) {
    Clique& clique = cliques_[at(c)];
    for (const int child : clique.children) {
      if (!cliques_[at(child)].alive) continue;
      cliques_[at(child)].parent = kNone;
      part.orphans.push_back(child);
    }
    for (const int variable : clique.pivots) {
      clique_of_[at(variable)] = kNone;
      part.variables.push_back(variable);
    }
    // What was allocated is used again.
    clique.pivots.clear();
    clique.rows.clear();
    clique.children.clear();
    clique.parent = kNone;
    clique.queued = false;
    spare_.take_back(std::move(clique.values));
    free_.push_back(c);
  }
  part.variables.insert(part.variables.end(), unattached_.begin(), unattached_.end());
  unattached_.clear();
  std::sort(part.variables.begin(), part.variables.end());
  std::sort(part.orphans.begin(), part.orphans.end());
  return part;
}

void CliqueTree::order(const Part& part, int newest, std::span<const LinearFactor> factors,
                       const std::vector<std::vector<int>>& factors_of) {
  // The newest pose is where the next edge will begin, so it goes last, in the root, and is left
  // out of the ordering.
  const int last = local_[at(newest)];
  if (part.variables.size() <= kSmall) {
    order_small(part, last, factors, factors_of);
  } else {
    order_large(part, last, factors, factors_of);
  }
  if (last == kNone) return;
  const int place = order_[at(last)];
  for (int& p : order_) {
    if (p > place) --p;
  }
  order_[at(last)] = static_cast<int>(part.variables.size()) - 1;
}

void CliqueTree::order_small(const Part& part, int last, std::span<const LinearFactor> factors,
                             const std::vector<std::vector<int>>& factors_of) {
  SmallGraph graph(static_cast<int>(part.variables.size()));
  std::vector<int> joined;
  for (const int variable : part.variables) {
    for (const int f : factors_of[at(variable)]) {
      const LinearFactor& factor = factors[at(f)];
      if (factor.first != variable || factor.second == kNone) continue;
      const int other = local_[at(factor.second)];
      const int here = local_[at(variable)];
      if (other != kNone && other != last && here != last) graph.join(here, other);
    }
  }
  for (const int orphan : part.orphans) {
    joined.clear();
    for (const int row : cliques_[at(orphan)].rows) {
      if (local_[at(row)] != last) joined.push_back(local_[at(row)]);
    }
    graph.join_all(joined);
  }
  order_ = std::move(graph).minimum_fill_order();
}

void CliqueTree::order_large(const Part& part, int last, std::span<const LinearFactor> factors,
                             const std::vector<std::vector<int>>& factors_of) {
  const auto size = static_cast<int>(part.variables.size());
  std::vector<std::vector<int>> orphans_of(at(size));
  for (std::size_t o = 0; o < part.orphans.size(); ++o) {
    for (const int row : cliques_[at(part.orphans[o])].rows) {
      orphans_of[at(local_[at(row)])].push_back(static_cast<int>(o));
    }
  }
  std::vector<std::pair<int, int>> pairs;
  std::vector<int> seen_by(at(size), kNone);
  for (int i = 0; i < size; ++i) {
    seen_by[at(i)] = i;
    const int variable = part.variables[at(i)];
    const auto add = [&](int other) {
      if (other == kNone || other == last || seen_by[at(other)] == i) return;
      seen_by[at(other)] = i;
      if (other < i && i != last) pairs.emplace_back(i, other);
    };
    for (const int f : factors_of[at(variable)]) {
      const LinearFactor& factor = factors[at(f)];
      if (factor.second == kNone) continue;
      add(local_[at(factor.first == variable ? factor.second : factor.first)]);
    }
    for (const int o : orphans_of[at(i)]) {
      for (const int row : cliques_[at(part.orphans[at(o)])].rows) add(local_[at(row)]);
    }
  }
  order_ = fill_reducing_order_of_unique(size, pairs);
}

void CliqueTree::solve_clique(int c, double negligible, std::vector<int>& changed) {
  Clique& clique = cliques_[at(c)];
  below_.resize(std::max(below_.size(), padded_rows(clique.below_count())));
  for (std::size_t i = 0; i < clique.rows.size(); ++i) {
    MapVector(below_.data() + 3 * i) = delta_[at(clique.rows[i])];
  }
  x_.assign(clique.forward(), clique.forward() + clique.pivot_count());
  solve_front_backward(clique.dense(), x_.data(), below_.data());
  for (std::size_t i = 0; i < clique.pivots.size(); ++i) {
    const int variable = clique.pivots[i];
    delta_[at(variable)] = MapVector(x_.data() + 3 * i);
    changed.push_back(variable);
    // Small changes add up until they are passed on.
    const Eigen::Vector3d change = delta_[at(variable)] - passed_on_[at(variable)];
    if (!(change.lpNorm<Eigen::Infinity>() > negligible)) continue;
    passed_on_[at(variable)] = delta_[at(variable)];
    changed_in_[at(variable)] = update_;
  }
}

void CliqueTree::solve_new_cliques(double negligible, std::vector<int>& changed) {
  std::vector<bool> is_new(cliques_.size(), false);
  for (const int c : new_cliques_) is_new[at(c)] = true;
  for (std::size_t i = new_cliques_.size(); i-- > 0;) {
    const int c = new_cliques_[i];
    solve_clique(c, negligible, changed);
    for (const int child : cliques_[at(c)].children) {
      if (!is_new[at(child)]) queue(child, update_);
    }
  }
}

void CliqueTree::queue(int c, std::uint32_t since) {
  Clique& clique = cliques_[at(c)];
  if (clique.queued) {
    clique.since = std::min(clique.since, since);
    return;
  }
  clique.queued = true;
  clique.since = since;
  queue_.push_back(c);
}

std::vector<int> CliqueTree::pass_on(double negligible, std::size_t most) {
  std::vector<int> changed;
  while (next_queued_ < queue_.size() && changed.size() < most) {
    const int c = queue_[next_queued_++];
    Clique& clique = cliques_[at(c)];
    // A clique that has been eliminated since then is queued no more.
    if (!clique.queued) continue;
    clique.queued = false;
    const std::uint32_t since = clique.since;
    const bool any_moved = std::any_of(clique.rows.begin(), clique.rows.end(), [&](int variable) {
      return changed_in_[at(variable)] >= since;
    });
    if (!any_moved) continue;
    solve_clique(c, negligible, changed);
    for (const int child : clique.children) queue(child, since);
  }
  queue_.erase(queue_.begin(), queue_.begin() + static_cast<std::ptrdiff_t>(next_queued_));
  next_queued_ = 0;
  return changed;
}

CliqueTree::Result CliqueTree::update(std::span<const int> touched, int newest,
                                      std::span<const LinearFactor> factors,
                                      const std::vector<std::vector<int>>& factors_of,
                                      double negligible, std::size_t most) {
  Result result;
  ++update_;
  const Part part = detach(touched);
  result.eliminated = part.variables.size();
  for (std::size_t i = 0; i < part.variables.size(); ++i) {
    local_[at(part.variables[i])] = static_cast<int>(i);
  }
  order(part, newest, factors, factors_of);
  result.solved = eliminate(part, factors, factors_of);
  for (const int variable : part.variables) local_[at(variable)] = kNone;
  if (!result.solved) return result;
  solve_new_cliques(negligible, result.changed);
  const std::vector<int> farther = pass_on(negligible, most - std::min(most, result.eliminated));
  result.changed.insert(result.changed.end(), farther.begin(), farther.end());
  return result;
}

}  // namespace loopstone
