#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "loopstone/formats/log_reader.hpp"
#include "pace.hpp"

namespace loopstone::app {

/// A log whose messages come when a robot would have had them.
class PacedLog final : public LogReader {
 public:
  /// \param speed  1: as recorded
  PacedLog(std::unique_ptr<LogReader> log, double speed, std::function<bool()> stop)
      : log_(std::move(log)), pace_(speed), stop_(std::move(stop)) {}

  [[nodiscard]] std::optional<SensorMessage> next() override {
    auto message = log_->next();
    if (message) pace_.wait_for(stamp_of(*message), [this] { return !stop_ || !stop_(); });
    return message;
  }
  [[nodiscard]] ReadProgress progress() const override { return log_->progress(); }
  [[nodiscard]] std::string format() const override { return log_->format(); }
  [[nodiscard]] RobotModel robot(RobotModel base) const override {
    return log_->robot(std::move(base));
  }
  [[nodiscard]] WheelModel wheels(WheelModel base) const override { return log_->wheels(base); }
  [[nodiscard]] const SkippedRecords& skipped() const override { return log_->skipped(); }
  [[nodiscard]] std::vector<std::string> choices() const override { return log_->choices(); }

 private:
  std::unique_ptr<LogReader> log_;
  Pace pace_;
  std::function<bool()> stop_;
};

}  // namespace loopstone::app
