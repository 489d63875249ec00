#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "loopstone/formats/log_reader.hpp"

namespace loopstone::test {

/// A log reader over messages in memory. Its progress counts messages.
class MemoryLog final : public LogReader {
 public:
  explicit MemoryLog(std::vector<SensorMessage> messages) : messages_(std::move(messages)) {}

  std::optional<SensorMessage> next() override {
    if (next_ == messages_.size()) return std::nullopt;
    return messages_[next_++];
  }
  ReadProgress progress() const override {
    return {static_cast<std::int64_t>(next_), static_cast<std::int64_t>(messages_.size())};
  }
  std::string format() const override { return "memory"; }
  RobotModel robot(RobotModel base) const override { return base; }
  const SkippedRecords& skipped() const override { return skipped_; }

 private:
  std::vector<SensorMessage> messages_;
  std::size_t next_ = 0;
  SkippedRecords skipped_;
};

}  // namespace loopstone::test
