#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "loopstone/formats/log_reader.hpp"

namespace loopstone {

/// Something that measures, or tells what others measure, while it does.
struct LiveSource {
  std::string name{};  ///< for messages: "tcp://10.0.0.5:9000"
  /// Opens it; returns when it knows what the source has to tell of the robot. Called by a thread
  /// of its own, again and again when the source ends or fails. Throws DataError; UsageError for
  /// what will never work; ReadingStopped.
  std::function<std::unique_ptr<LogReader>(const LogOptions&)> open{};
  bool is_opened_again = true;  ///< when it ends or fails; else it is over then
  /// Waits for whoever is too slow; else the oldest scans are left out, since what measures does
  /// not wait.
  bool waits = true;
};

/// What a user should know of a source.
struct LiveNews {
  std::string source{};
  std::string text{};  ///< "no scan for 3 s"
  bool is_trouble = true;
};

struct LiveLogOptions {
  LogOptions reading{};
  /// After so long without a scan a source that had some is told of.
  double silence_s = 3.0;
  /// After so long without any message the log is at its end; nothing: never.
  std::optional<double> end_after_s{};
  /// Told by whoever calls next(). May be empty.
  std::function<void(const LiveNews&)> on_news{};
  /// Called by next() some twenty times a second while nothing comes. May be empty.
  std::function<void()> idle{};
  std::size_t most_waiting = 4000;  ///< messages
  double again_s = 0.5;             ///< the first wait before a source is opened again,
  double again_most_s = 5.0;        ///< and the longest: each is twice the one before
};

/// Sources that are read live, as one log: each by a thread of its own, their messages in the order
/// in which they come, on one clock. It goes on whatever happens to a source: one that is lost is
/// opened again, clocks that jump are taken up, whoever falls silent is told of.
///
///   LiveLog log(sources, {.reading = {.stop = interrupted}, .on_news = say});
///   if (!log.wait_for_sources()) return;
///   Mapper mapper(log.robot({}), options, threads);
///   while (auto message = log.next()) mapper.add(*message);
///
/// Lasers are numbered in the order of the sources. Messages of cameras are left out.
class LiveLog final : public LogReader {
 public:
  LiveLog(std::vector<LiveSource> sources, LiveLogOptions options);
  ~LiveLog() override;
  LiveLog(const LiveLog&) = delete;
  LiveLog& operator=(const LiveLog&) = delete;

  /// Returns when each source was opened, and has had a second to send its first scan. False when
  /// LogOptions::stop said so, or when all are over without a message. Throws what can't be opened
  /// ever.
  [[nodiscard]] bool wait_for_sources();

  [[nodiscard]] std::optional<SensorMessage> next() override;
  [[nodiscard]] ReadProgress progress() const override;
  [[nodiscard]] std::string format() const override { return "live"; }
  [[nodiscard]] RobotModel robot(RobotModel base) const override;
  [[nodiscard]] WheelModel wheels(WheelModel base) const override;
  [[nodiscard]] const SkippedRecords& skipped() const override;
  [[nodiscard]] std::vector<std::string> choices() const override;
  /// Troubles that were told, each kind once with its count.
  [[nodiscard]] std::vector<std::string> warnings() const override;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace loopstone
