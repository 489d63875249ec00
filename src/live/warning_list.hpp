#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "loopstone/live/view_contents.hpp"

namespace loopstone {

/// What was said of a drive so far. Of a long one the oldest are only counted.
class WarningList {
 public:
  static constexpr std::size_t kMost = 200;

  void add(std::optional<Stamp> when, std::string text) {
    list_.push_back({when, std::move(text)});
    if (list_.size() <= kMost) return;
    list_.pop_front();
    ++left_out_;
  }
  void clear() { *this = {}; }
  /// In their order.
  [[nodiscard]] std::vector<ViewWarning> shown() const {
    std::vector<ViewWarning> all;
    if (left_out_ > 0) all.push_back({{}, std::to_string(left_out_) + " earlier ones"});
    all.insert(all.end(), list_.begin(), list_.end());
    return all;
  }

 private:
  std::deque<ViewWarning> list_{};
  std::size_t left_out_ = 0;
};

}  // namespace loopstone
