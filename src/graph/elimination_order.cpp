#include "graph/elimination_order.hpp"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cstddef>
#include <utility>

namespace loopstone {

namespace {

constexpr int kNone = -1;
/// Nodes with more neighbours wait for the minimum degree order.
constexpr std::size_t kFewNeighbours = 2;

using Neighbours = std::vector<std::vector<int>>;

Neighbours neighbours_of(int size, std::span<const std::pair<int, int>> pairs) {
  Neighbours result(static_cast<std::size_t>(size));
  const auto add = [&result](int a, int b) {
    std::vector<int>& known = result[static_cast<std::size_t>(a)];
    if (std::find(known.begin(), known.end(), b) == known.end()) known.push_back(b);
  };
  for (const auto& [a, b] : pairs) {
    if (a == b) continue;
    add(a, b);
    add(b, a);
  }
  return result;
}

void forget(std::vector<int>& neighbours, int node) {
  neighbours.erase(std::find(neighbours.begin(), neighbours.end(), node));
}

void join(Neighbours& neighbours, int a, int b) {
  std::vector<int>& of_a = neighbours[static_cast<std::size_t>(a)];
  if (std::find(of_a.begin(), of_a.end(), b) != of_a.end()) return;
  of_a.push_back(b);
  neighbours[static_cast<std::size_t>(b)].push_back(a);
}

/// Takes the nodes of few neighbours out of the graph until none is left, and gives them their
/// places.
int eliminate_chains(Neighbours& neighbours, std::vector<int>& place) {
  int next_place = 0;
  std::vector<int> candidates(neighbours.size());
  for (std::size_t i = 0; i < candidates.size(); ++i) candidates[i] = static_cast<int>(i);
  std::vector<int> touched_in(neighbours.size(), kNone);
  for (int round = 0; !candidates.empty(); ++round) {
    std::vector<int> later;
    for (const int node : candidates) {
      const auto n = static_cast<std::size_t>(node);
      if (place[n] != kNone || neighbours[n].size() > kFewNeighbours) continue;
      if (touched_in[n] == round) {
        later.push_back(node);
        continue;
      }
      place[n] = next_place++;
      const std::vector<int> around = std::move(neighbours[n]);
      neighbours[n].clear();
      for (const int other : around) {
        forget(neighbours[static_cast<std::size_t>(other)], node);
        if (touched_in[static_cast<std::size_t>(other)] != round) later.push_back(other);
        touched_in[static_cast<std::size_t>(other)] = round;
      }
      if (around.size() == 2) join(neighbours, around[0], around[1]);
    }
    std::sort(later.begin(), later.end());
    later.erase(std::unique(later.begin(), later.end()), later.end());
    candidates = std::move(later);
  }
  return next_place;
}

/// Approximate minimum degree of the nodes that have no place yet.
void order_rest(const Neighbours& neighbours, int first_place, std::vector<int>& place) {
  using Pattern = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;
  std::vector<int> rest;
  std::vector<int> number(place.size(), kNone);
  for (std::size_t i = 0; i < place.size(); ++i) {
    if (place[i] != kNone) continue;
    number[i] = static_cast<int>(rest.size());
    rest.push_back(static_cast<int>(i));
  }
  if (rest.empty()) return;
  const auto size = static_cast<int>(rest.size());
  Pattern pattern(size, size);
  std::size_t entries = 0;
  for (const int node : rest) entries += neighbours[static_cast<std::size_t>(node)].size() + 1;
  pattern.reserve(static_cast<Eigen::Index>(entries));
  std::vector<int> column;
  for (int j = 0; j < size; ++j) {
    column.assign(1, j);
    const int node = rest[static_cast<std::size_t>(j)];
    for (const int other : neighbours[static_cast<std::size_t>(node)]) {
      column.push_back(number[static_cast<std::size_t>(other)]);
    }
    std::sort(column.begin(), column.end());
    pattern.startVec(j);
    for (const int i : column) pattern.insertBack(i, j) = 1.0;
  }
  pattern.finalize();
  Eigen::AMDOrdering<int>::PermutationType order(size);
  // Of a pattern that is known to be symmetric.
  Eigen::AMDOrdering<int>{}(pattern.selfadjointView<Eigen::Lower>(), order);
  // Eigen gives the inverse permutation: indices()[place] = node.
  for (int i = 0; i < size; ++i) {
    place[static_cast<std::size_t>(rest[static_cast<std::size_t>(order.indices()[i])])] =
        first_place + i;
  }
}

std::vector<int> order_of(int size, Neighbours neighbours) {
  std::vector<int> place(static_cast<std::size_t>(size), kNone);
  const int eliminated = eliminate_chains(neighbours, place);
  order_rest(neighbours, eliminated, place);
  return place;
}

}  // namespace

std::vector<int> fill_reducing_order(int size, std::span<const std::pair<int, int>> pairs) {
  return order_of(size, neighbours_of(size, pairs));
}

std::vector<int> fill_reducing_order_of_unique(int size,
                                               std::span<const std::pair<int, int>> pairs) {
  Neighbours neighbours(static_cast<std::size_t>(size));
  for (const auto& [a, b] : pairs) {
    neighbours[static_cast<std::size_t>(a)].push_back(b);
    neighbours[static_cast<std::size_t>(b)].push_back(a);
  }
  return order_of(size, std::move(neighbours));
}

}  // namespace loopstone
