#pragma once

#include <cstdint>
#include <string>

#include "loopstone/sensor/messages.hpp"

namespace loopstone {

/// Tells whether two logs begin with the same messages without keeping them: how many, and a
/// checksum of them all. Where the files lie, how they are packed and what follows does not matter;
/// of pictures only the stamps count.
class LogDigest {
 public:
  void add(const SensorMessage& message);

  [[nodiscard]] std::int64_t messages() const { return messages_; }
  /// "37302 messages, checksum 5f0a2b1c".
  [[nodiscard]] std::string text() const;
  friend bool operator==(const LogDigest&, const LogDigest&) = default;

  template <typename Archive>
  void archive(Archive& a) {
    a(messages_, checksum_);
    a.check(messages_ >= 0, "a negative number of messages");
  }

 private:
  std::int64_t messages_ = 0;
  std::uint32_t checksum_ = 0;
};

}  // namespace loopstone
