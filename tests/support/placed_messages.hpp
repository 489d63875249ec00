#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/recording.hpp"

namespace loopstone::test {

struct PlacedMessage {
  MessagePlace place{};
  std::string bytes{};
};

/// All messages that a recording gives from where it stands, with their places.
[[nodiscard]] inline std::vector<PlacedMessage> placed_messages_of(Recording& recording) {
  std::vector<PlacedMessage> messages;
  while (const auto message = recording.next()) {
    messages.push_back({message->place, {message->bytes.begin(), message->bytes.end()}});
  }
  return messages;
}

/// That each of them is found by its place, in any order.
/// \return how many there are
inline std::size_t expect_by_place(std::vector<PlacedMessage> messages, Recording& recording,
                                   const std::string& what) {
  std::vector<MessagePlace> places;
  for (const PlacedMessage& message : messages) places.push_back(message.place);
  std::sort(places.begin(), places.end());
  EXPECT_EQ(std::adjacent_find(places.begin(), places.end()), places.end()) << what;
  std::shuffle(messages.begin(), messages.end(), std::mt19937_64(messages.size()));
  for (const PlacedMessage& message : messages) {
    try {
      const auto bytes = recording.bytes_at(message.place);
      EXPECT_EQ(std::string_view(bytes.data(), bytes.size()), message.bytes) << what;
    } catch (const DataError& error) {
      ADD_FAILURE() << error.what() << ", " << what;
    }
  }
  return messages.size();
}

}  // namespace loopstone::test
