#include <array>
#include <variant>

#include "loopstone/formats/log_format.hpp"

namespace loopstone {
namespace {

/// Gives a format's writer what the format has a place for, and counts the rest.
class HeldMessages final : public LogWriter {
 public:
  HeldMessages(const LogFormat& format, std::unique_ptr<LogWriter> writer)
      : format_(format), writer_(std::move(writer)) {}

  void write(const SensorMessage& message) override {
    if (!holds(format_.holds, message)) {
      ++left_out_[message.index()];
      return;
    }
    if (const auto* scan = std::get_if<LaserScan>(&message)) {
      if (scan->time_increment_s != 0.0 && !format_.holds.beam_times) ++sweeps_;
    }
    writer_->write(message);
  }

  void use_pictures(std::shared_ptr<const PictureStore> pictures) override {
    writer_->use_pictures(std::move(pictures));
  }
  void finish() override { writer_->finish(); }

  std::vector<std::string> notes() const override {
    const std::string noun(format_.noun);
    std::vector<std::string> notes;
    for (std::size_t kind = 0; kind < left_out_.size(); ++kind) {
      if (left_out_[kind] == 0) continue;
      notes.push_back(std::to_string(left_out_[kind]) + " " +
                      std::string(message_kinds()[kind].name) + " are left out: " + noun +
                      " has no place for them");
    }
    if (sweeps_ > 0) {
      notes.push_back(std::to_string(sweeps_) + " scans lose the time between their beams, which " +
                      noun + " does not state");
    }
    for (std::string& note : writer_->notes()) notes.push_back(std::move(note));
    return notes;
  }

 private:
  const LogFormat& format_;
  std::unique_ptr<LogWriter> writer_;
  std::array<std::int64_t, std::variant_size_v<SensorMessage>> left_out_{};
  std::int64_t sweeps_ = 0;  ///< scans whose beams came one after the other
};

}  // namespace

std::unique_ptr<LogWriter> create_log(const LogTarget& target, const RobotModel& robot) {
  const LogFormat& format = *target.format;
  if (!format.can_be_written()) {
    throw UsageError("logs of the format " + std::string(format.name) + " are only read");
  }
  return std::make_unique<HeldMessages>(format, format.create(target, robot));
}

std::unique_ptr<LogWriter> create_log(const std::string& path, const std::string& format,
                                      const RobotModel& robot, int set) {
  return create_log(LogTarget{&log_format(format), path, set}, robot);
}

}  // namespace loopstone
