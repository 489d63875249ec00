#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

#include "loopstone/graph/outlier_rejection.hpp"

namespace loopstone {

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

using Adjacent = std::vector<std::vector<bool>>;

/// Steps after which the exact search gives up.
constexpr std::int64_t kMostSteps = 2'000'000;

/// Nodes from which the greedy search begins.
constexpr std::size_t kMostStarts = 60;

/// Branch and bound with greedy colouring as the bound: Tomita and Seki 2003, "An efficient
/// branch-and-bound algorithm for finding a maximum clique".
class ExactSearch {
 public:
  ExactSearch(const Adjacent& adjacent, std::vector<int> best)
      : adjacent_(adjacent), best_(std::move(best)) {}

  Clique run() {
    std::vector<int> candidates(adjacent_.size());
    std::iota(candidates.begin(), candidates.end(), 0);
    std::vector<int> degree(adjacent_.size(), 0);
    for (std::size_t i = 0; i < adjacent_.size(); ++i) {
      degree[i] = static_cast<int>(std::count(adjacent_[i].begin(), adjacent_[i].end(), true));
    }
    std::stable_sort(candidates.begin(), candidates.end(),
                     [&](int a, int b) { return degree[at(a)] > degree[at(b)]; });
    expand(candidates);
    std::sort(best_.begin(), best_.end());
    return {best_, steps_ < kMostSteps};
  }

 private:
  struct Coloured {
    std::vector<int> nodes;
    std::vector<int>
        colour;  ///< ascending; a clique of the nodes up to one is no larger than its colour
  };

  [[nodiscard]] Coloured colour(const std::vector<int>& candidates) const {
    std::vector<std::vector<int>> classes;
    for (const int node : candidates) {
      auto fits = std::find_if(classes.begin(), classes.end(), [&](const std::vector<int>& c) {
        return std::none_of(c.begin(), c.end(),
                            [&](int other) { return adjacent_[at(node)][at(other)]; });
      });
      if (fits == classes.end()) fits = classes.emplace(classes.end());
      fits->push_back(node);
    }
    Coloured result;
    for (std::size_t c = 0; c < classes.size(); ++c) {
      for (const int node : classes[c]) {
        result.nodes.push_back(node);
        result.colour.push_back(static_cast<int>(c) + 1);
      }
    }
    return result;
  }

  void expand(const std::vector<int>& candidates) {
    const Coloured coloured = colour(candidates);
    for (std::size_t i = coloured.nodes.size(); i-- > 0;) {
      if (++steps_ >= kMostSteps) return;
      if (current_.size() + at(coloured.colour[i]) <= best_.size()) return;
      const int node = coloured.nodes[i];
      current_.push_back(node);
      std::vector<int> next;
      for (std::size_t k = 0; k < i; ++k) {
        if (adjacent_[at(node)][at(coloured.nodes[k])]) next.push_back(coloured.nodes[k]);
      }
      if (next.empty()) {
        if (current_.size() > best_.size()) best_ = current_;
      } else {
        expand(next);
      }
      current_.pop_back();
    }
  }

  const Adjacent& adjacent_;
  std::vector<int> current_;
  std::vector<int> best_;
  std::int64_t steps_ = 0;
};

/// From each of the nodes with most neighbours on, always the neighbour with most neighbours:
/// Pattabiraman et al. 2015, "Fast algorithms for the maximum clique problem on massive graphs",
/// algorithm 2.
std::vector<int> greedy_clique(const Adjacent& adjacent) {
  std::vector<std::vector<int>> neighbours(adjacent.size());
  for (std::size_t i = 0; i < adjacent.size(); ++i) {
    for (std::size_t j = 0; j < adjacent.size(); ++j) {
      if (i != j && adjacent[i][j]) neighbours[i].push_back(static_cast<int>(j));
    }
  }
  std::vector<int> starts(adjacent.size());
  std::iota(starts.begin(), starts.end(), 0);
  std::stable_sort(starts.begin(), starts.end(), [&](int a, int b) {
    return neighbours[at(a)].size() > neighbours[at(b)].size();
  });
  if (starts.size() > kMostStarts) starts.resize(kMostStarts);
  std::vector<int> best;
  for (const int start : starts) {
    if (neighbours[at(start)].size() < best.size()) break;
    std::vector<int> clique{start};
    std::vector<int> candidates = neighbours[at(start)];
    while (!candidates.empty() && clique.size() + candidates.size() > best.size()) {
      const int next = *std::max_element(candidates.begin(), candidates.end(), [&](int a, int b) {
        return neighbours[at(a)].size() < neighbours[at(b)].size();
      });
      clique.push_back(next);
      std::erase_if(candidates,
                    [&](int other) { return other == next || !adjacent[at(next)][at(other)]; });
    }
    if (candidates.empty() && clique.size() > best.size()) best = std::move(clique);
  }
  std::sort(best.begin(), best.end());
  return best;
}

}  // namespace

Clique greatest_clique(const std::vector<std::vector<bool>>& adjacent, int exact_up_to) {
  std::vector<int> greedy = greedy_clique(adjacent);
  if (adjacent.size() > at(std::max(exact_up_to, 0))) return {std::move(greedy), false};
  return ExactSearch(adjacent, std::move(greedy)).run();
}

}  // namespace loopstone
