#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

namespace loopstone::test {

/// A list as whoever gets its messages has it: how many there are, and those that changed.
class SeenList {
 public:
  /// \param message  {"count": ..., NAME: [{"id": ...}, ...]}
  /// Throws std::runtime_error where entries are missing.
  void take(const nlohmann::json& message, const std::string& name) {
    const auto count = message.at("count").get<std::size_t>();
    while (entries_.size() > count) entries_.erase(entries_.size() - 1);
    for (const nlohmann::json& entry : message.at(name)) {
      const auto id = entry.at("id").get<std::size_t>();
      if (id >= count || id > entries_.size()) throw std::runtime_error("an entry out of place");
      if (id == entries_.size()) entries_.push_back(nullptr);
      entries_[id] = entry;
    }
    if (entries_.size() != count) throw std::runtime_error("entries are missing");
  }
  [[nodiscard]] const nlohmann::json& entries() const { return entries_; }

 private:
  nlohmann::json entries_ = nlohmann::json::array();
};

}  // namespace loopstone::test
