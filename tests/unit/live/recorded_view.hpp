#pragma once

#include <gtest/gtest.h>

#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "loopstone/live/view_board.hpp"
#include "loopstone/messages/message_codec.hpp"
#include "support/seen_list.hpp"

namespace loopstone::test {

/// A sink that keeps all that was published, and reads it with our own codec.
class RecordedView {
 public:
  struct Message {
    std::string topic;
    Stamp stamp;
    std::string bytes;
  };

  [[nodiscard]] ViewSink sink() {
    return {.add_channel =
                [this](ViewChannel channel) {
                  const std::scoped_lock lock(mutex_);
                  channels_.push_back(std::move(channel));
                  return ChannelId{static_cast<std::uint32_t>(channels_.size() - 1)};
                },
            .publish =
                [this](ChannelId channel, Stamp stamp, std::string bytes) {
                  const std::scoped_lock lock(mutex_);
                  messages_.push_back({channels_.at(channel.index).topic, stamp, std::move(bytes)});
                },
            .set_time =
                [this](Stamp now) {
                  const std::scoped_lock lock(mutex_);
                  now_ = now;
                },
            .is_wanted =
                [this](ChannelId channel) {
                  const std::scoped_lock lock(mutex_);
                  return !unwanted_.contains(channels_.at(channel.index).topic);
                }};
  }
  /// Nobody takes these from now on.
  void set_unwanted(std::set<std::string> topics) {
    const std::scoped_lock lock(mutex_);
    unwanted_ = std::move(topics);
  }

  [[nodiscard]] std::vector<ViewChannel> channels() const {
    const std::scoped_lock lock(mutex_);
    return channels_;
  }
  [[nodiscard]] const ViewChannel& channel(const std::string& topic) const {
    const std::scoped_lock lock(mutex_);
    for (const ViewChannel& channel : channels_) {
      if (channel.topic == topic) return channel;
    }
    throw std::runtime_error("no channel " + topic);
  }
  [[nodiscard]] std::vector<Message> all(const std::string& topic) const {
    const std::scoped_lock lock(mutex_);
    std::vector<Message> found;
    for (const Message& message : messages_) {
      if (message.topic == topic) found.push_back(message);
    }
    return found;
  }
  [[nodiscard]] std::optional<Stamp> now() const {
    const std::scoped_lock lock(mutex_);
    return now_;
  }

  /// The last one; of a type of ROS.
  template <typename M>
  [[nodiscard]] M last(const std::string& topic) const {
    return decoded<M>(topic, all(topic).at(all(topic).size() - 1).bytes);
  }
  template <typename M>
  [[nodiscard]] M decoded(const std::string& topic, const std::string& bytes) const {
    const ViewChannel& about = channel(topic);
    EXPECT_EQ(about.schema_name, ros2_type(MessageType<M>::name()));
    M message;
    // By the definition that was told, as a stranger would.
    MessageDecoder<M>(WireFormat::kCdr, {DefinitionLanguage::kRos2Msg, about.schema})
        .decode(bytes, message);
    return message;
  }
  [[nodiscard]] nlohmann::json last_json(const std::string& topic) const {
    return nlohmann::json::parse(all(topic).at(all(topic).size() - 1).bytes);
  }
  /// "closures" or "submaps", as its messages have left it.
  [[nodiscard]] nlohmann::json list(const std::string& name) const {
    SeenList seen;
    for (const Message& message : all("/loopstone/" + name))
      seen.take(nlohmann::json::parse(message.bytes), name);
    return seen.entries();
  }

 private:
  mutable std::mutex mutex_{};
  std::set<std::string> unwanted_{};
  std::vector<ViewChannel> channels_{};
  std::vector<Message> messages_{};
  std::optional<Stamp> now_{};
};

/// Tiles as whoever gets the messages has them.
class SeenTiles {
 public:
  void take(const msg::MapTiles& message) {
    if (message.whole) tiles_.clear();
    const std::size_t cells = std::size_t{message.size} * message.size;
    ASSERT_EQ(message.cells.size(), message.ids.size() / 2 * cells);
    for (std::size_t i = 0; i < message.ids.size() / 2; ++i) {
      const auto begin = message.cells.begin() + static_cast<std::ptrdiff_t>(i * cells);
      tiles_[{message.ids[2 * i], message.ids[2 * i + 1]}] = {
          begin, begin + static_cast<std::ptrdiff_t>(cells)};
    }
  }
  [[nodiscard]] const std::map<std::pair<int, int>, std::vector<std::uint8_t>>& tiles() const {
    return tiles_;
  }
  /// Of a point in metres.
  [[nodiscard]] int at(double x, double y, double resolution) const {
    const int column = static_cast<int>(std::floor(x / resolution));
    const int row = static_cast<int>(std::floor(y / resolution));
    const auto tile_of = [](int cell) { return cell >= 0 ? cell / 64 : -((63 - cell) / 64); };
    const auto found = tiles_.find({tile_of(column), tile_of(row)});
    if (found == tiles_.end()) return msg::MapTiles::kUnknown;
    return found->second[static_cast<std::size_t>((row - 64 * tile_of(row)) * 64 + column -
                                                  64 * tile_of(column))];
  }

 private:
  std::map<std::pair<int, int>, std::vector<std::uint8_t>> tiles_{};
};

/// Nodes as whoever gets the messages has them.
struct SeenNodes {
  std::vector<double> t{};
  std::vector<float> poses{};
  std::vector<float> sigma{};

  void take(const msg::Trajectory& message) {
    ASSERT_LE(message.first, t.size());
    ASSERT_EQ(message.first + message.t.size(), message.count);
    for (const std::size_t size : {message.sigma.size(), message.submaps.size(),
                                   message.drives.size(), message.poses.size() / 3})
      ASSERT_EQ(size, message.t.size());
    t.resize(message.first);
    poses.resize(std::size_t{3} * message.first);
    sigma.resize(message.first);
    t.insert(t.end(), message.t.begin(), message.t.end());
    poses.insert(poses.end(), message.poses.begin(), message.poses.end());
    sigma.insert(sigma.end(), message.sigma.begin(), message.sigma.end());
  }
};

}  // namespace loopstone::test
