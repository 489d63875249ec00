#include "graph/small_order.hpp"

#include <algorithm>
#include <bit>

namespace loopstone {

namespace {

constexpr int kNone = -1;
constexpr std::size_t kWordBits = 64;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

std::uint64_t bit_of(int node) { return std::uint64_t{1} << (at(node) % kWordBits); }

/// std::popcount is a call where the processor need not have an instruction for it.
int count_bits(std::uint64_t word) {
  word -= (word >> 1U) & 0x5555555555555555U;
  word = (word & 0x3333333333333333U) + ((word >> 2U) & 0x3333333333333333U);
  word = (word + (word >> 4U)) & 0x0F0F0F0F0F0F0F0FU;
  return static_cast<int>((word * 0x0101010101010101U) >> 56U);
}

}  // namespace

SmallGraph::SmallGraph(int size)
    : words_((at(size) + kWordBits - 1) / kWordBits),
      bits_(at(size) * words_),
      degree_(at(size)),
      joined_(at(size)),
      fill_(at(size)) {}

void SmallGraph::join(int a, int b) {
  if (a == b) return;
  row(a)[at(b) / kWordBits] |= bit_of(b);
  row(b)[at(a) / kWordBits] |= bit_of(a);
}

void SmallGraph::join_all(std::span<const int> nodes) {
  std::vector<std::uint64_t> all(words_);
  for (const int node : nodes) all[at(node) / kWordBits] |= bit_of(node);
  int others = -1;
  for (const std::uint64_t word : all) others += count_bits(word);
  for (const int node : nodes) {
    joined_[at(node)] = std::max(joined_[at(node)], others);
    std::uint64_t* to = row(node);
    for (std::size_t w = 0; w < words_; ++w) to[w] |= all[w];
    to[at(node) / kWordBits] &= ~bit_of(node);
  }
}

void SmallGraph::rate(int node) {
  const std::int64_t neighbours = degree_[at(node)];
  const std::int64_t joined = joined_[at(node)];
  fill_[at(node)] = neighbours * (neighbours - 1) - joined * (joined - 1);
}

void SmallGraph::eliminate(int node) {
  const std::uint64_t* around = row(node);
  for (std::size_t w = 0; w < words_; ++w) {
    for (std::uint64_t left = around[w]; left != 0; left &= left - 1) {
      const int other = static_cast<int>(w * kWordBits) + std::countr_zero(left);
      std::uint64_t* to = row(other);
      to[at(node) / kWordBits] &= ~bit_of(node);
      --degree_[at(other)];
      for (std::size_t k = 0; k < words_; ++k) {
        std::uint64_t added = around[k] & ~to[k];
        if (k == w) added &= ~bit_of(other);
        if (added == 0) continue;
        to[k] |= added;
        degree_[at(other)] += count_bits(added);
      }
      // The set that it was known to be joined with may have had the node that goes.
      joined_[at(other)] = std::max(joined_[at(other)] - 1, degree_[at(node)] - 1);
      rate(other);
    }
  }
}

std::vector<int> SmallGraph::minimum_fill_order() && {
  const auto size = static_cast<int>(degree_.size());
  for (int i = 0; i < size; ++i) {
    degree_[at(i)] = 0;
    for (std::size_t w = 0; w < words_; ++w) degree_[at(i)] += count_bits(row(i)[w]);
    joined_[at(i)] = std::max(joined_[at(i)], std::min(1, degree_[at(i)]));
    rate(i);
  }
  std::vector<int> place(at(size), kNone);
  std::vector<int> left(at(size));
  for (int i = 0; i < size; ++i) left[at(i)] = i;
  for (int next = 0; next < size; ++next) {
    const auto least = std::min_element(
        left.begin(), left.end(), [this](int a, int b) { return fill_[at(a)] < fill_[at(b)]; });
    const int node = *least;
    left.erase(least);
    place[at(node)] = next;
    // When it joins all that are left with one another, their order does not matter any more.
    if (degree_[at(node)] == static_cast<int>(left.size())) {
      for (const int other : left) place[at(other)] = ++next;
      break;
    }
    eliminate(node);
  }
  return place;
}

}  // namespace loopstone
