#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "formats/recording.hpp"
#include "support/placed_messages.hpp"
#include "support/recording_builder.hpp"
#include "support/recording_damage.hpp"
#include "support/temp_dir.hpp"

// What holds of every container with chunks.

namespace loopstone::test {

using ReadBytes = std::unique_ptr<Recording> (*)(std::string_view, const RecordingOptions&);
using OpenFile = std::unique_ptr<Recording> (*)(const std::string&, const RecordingOptions&);

/// What a reading said of damage.
struct Damage {
  std::vector<std::string> reasons{};
  RecordingOptions options() {
    RecordingOptions options;
    options.on_damage = [this](const Problem& problem) {
      reasons.push_back(to_string(problem.location) + ": " + problem.reason);
    };
    return options;
  }
};

/// Of a recording that is cut at every `step`-th byte from `first` on, that all is there which
/// stands before.
inline void expect_what_is_before_cuts(const BuiltRecording& recording,
                                       const std::vector<BuiltMessage>& messages, std::size_t first,
                                       std::size_t step, ReadBytes read, const std::string& what) {
  std::size_t most = 0;
  for (std::size_t size = first; size < recording.bytes.size(); size += step) {
    const auto cut = read(std::string_view(recording.bytes).substr(0, size), {});
    const auto got = messages_of(*cut);
    ASSERT_LE(got.size(), messages.size());
    ASSERT_TRUE(std::equal(got.begin(), got.end(), messages.begin())) << size << what;
    ASSERT_GE(got.size(), most) << size << what;
    for (const auto& part : recording.parts) {
      if (part.end <= size) {
        ASSERT_GE(got.size(), part.first + part.messages) << size << what;
      }
    }
    most = got.size();
    ASSERT_FALSE(cut->is_indexed()) << size << what;
  }
  EXPECT_GE(most + 1, messages.size()) << what;  // the last may be cut at its end alone
}

inline void expect_what_is_undamaged(const DamagedRecording& spoiled,
                                     const std::vector<BuiltMessage>& messages, ReadBytes read,
                                     const std::string& what) {
  const auto found = found_in(*read(spoiled.bytes, {}), messages);
  for (std::size_t i = 0; i < messages.size(); ++i) {
    EXPECT_TRUE(found[i] || !spoiled.is_whole[i])
        << "message " << i << ", " << spoiled.what << ", " << what;
  }
}

inline void expect_stops_when_asked(std::string_view bytes, ReadBytes read) {
  bool stop = false;
  RecordingOptions options;
  options.stop = [&] { return stop; };
  const auto recording = read(bytes, options);
  ASSERT_TRUE(recording->next());
  stop = true;
  EXPECT_THROW(
      {
        while (recording->next()) {
        }
      },
      ReadingStopped);
}

/// That another recording of the same finds each message by its place.
/// \return how many there are
inline std::size_t expect_by_place(std::string_view bytes, ReadBytes read,
                                   const std::string& what) {
  return expect_by_place(placed_messages_of(*read(bytes, {})), *read(bytes, {}), what);
}

/// That next() goes on where it was after other messages were asked for by their places.
inline void expect_undisturbed_by_places(const std::string& bytes, OpenFile open,
                                         const std::string& what) {
  const TempDir dir;
  const std::string path = dir.write("recording", bytes);
  const auto placed = placed_messages_of(*open(path, {}));
  const auto recording = open(path, {});
  for (std::size_t i = 0; i < placed.size(); ++i) {
    const auto message = recording->next();
    ASSERT_TRUE(message) << what;
    EXPECT_EQ(message->place, placed[i].place) << what;
    EXPECT_TRUE(std::ranges::equal(message->bytes, placed[i].bytes)) << what;
    const auto& other = placed[(7 * i + 3) % placed.size()];
    EXPECT_TRUE(std::ranges::equal(recording->bytes_at(other.place), other.bytes)) << what;
  }
  EXPECT_FALSE(recording->next()) << what;
}

/// That places of a recording which hold no message or another one are told from right ones.
/// \param others  what the file holds later
inline void expect_other_places_refused(const std::string& bytes,
                                        const std::vector<std::string>& others, OpenFile open) {
  const TempDir dir;
  const std::string path = dir.write("recording", bytes);
  const auto placed = placed_messages_of(*open(path, {}));
  const auto refusal = [&](const MessagePlace& place) -> std::string {
    try {
      (void)open(path, {})->bytes_at(place);
    } catch (const DataError& error) {
      return error.what();
    }
    return "none";
  };
  const MessagePlace place = placed[placed.size() / 2].place;
  EXPECT_EQ(refusal(place), "none");
  const std::string expected =
      path + " (byte " + std::to_string(place.at) +
      "): the message that was here is gone: the file was changed meanwhile";
  const auto refusal_of_changed = [&](const auto& change) {
    MessagePlace changed = place;
    change(changed);
    return refusal(changed);
  };
  EXPECT_EQ(refusal_of_changed([](MessagePlace& at) { ++at.recorded.nanoseconds; }), expected);
  EXPECT_EQ(refusal_of_changed([](MessagePlace& at) { ++at.size; }), expected);
  EXPECT_EQ(refusal_of_changed([](MessagePlace& at) {
              at.in_chunk = at.in_chunk == MessagePlace::kNoChunk ? 5 : MessagePlace::kNoChunk;
            }),
            expected);
  for (const std::int64_t far : {std::int64_t{5}, std::int64_t{1} << 40}) {
    EXPECT_EQ(refusal_of_changed([&](MessagePlace& at) { at.in_chunk = far; }), expected);
  }
  for (const std::int64_t at : {std::int64_t{-1}, std::int64_t{0}, std::int64_t{1} << 40}) {
    EXPECT_NE(refusal_of_changed([&](MessagePlace& changed) { changed.at = at; }), "none") << at;
  }
  for (const std::string& other : others) {
    dir.write("recording", other);
    EXPECT_EQ(refusal(place), expected);
  }
}

}  // namespace loopstone::test
