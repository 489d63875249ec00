#pragma once

#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

namespace loopstone {

/// A list that is told by its changes: entries by their place, and how many there are.
template <typename T>
class ToldList {
 public:
  [[nodiscard]] const std::vector<T>& entries() const { return entries_; }

  /// Takes what is now; gives the places of what is to be told of it. An entry that differs too
  /// little stays as it was told, so that many small steps do not go unseen.
  /// \param keeps  (const T& told, T& now): whether it differs too little; then `now` gets what was
  ///               told
  template <typename Keeps>
  [[nodiscard]] std::vector<std::size_t> change(std::vector<T> now, const Keeps& keeps) {
    std::vector<std::size_t> places;
    for (std::size_t i = 0; i < now.size(); ++i) {
      if (i >= entries_.size() || !keeps(entries_[i], now[i])) places.push_back(i);
    }
    is_shorter_ = now.size() < entries_.size();
    entries_ = std::move(now);
    return places;
  }
  /// Whether the last change took entries away.
  [[nodiscard]] bool is_shorter() const { return is_shorter_; }

  [[nodiscard]] std::vector<std::size_t> all_places() const {
    std::vector<std::size_t> places(entries_.size());
    std::iota(places.begin(), places.end(), std::size_t{0});
    return places;
  }

 private:
  std::vector<T> entries_{};
  bool is_shorter_ = false;
};

}  // namespace loopstone
