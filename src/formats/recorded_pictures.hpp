#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "formats/recording.hpp"
#include "formats/topic_log.hpp"
#include "loopstone/formats/picture_store.hpp"

namespace loopstone {

/// The pictures of a recording: where each is, and the recording opened once more to read them when
/// somebody asks. Memory: 64 bytes a picture.
class RecordedPictures final : public PictureStore {
 public:
  RecordedPictures(OpenRecording open, RecordingOptions options)
      : open_(std::move(open)), options_(std::move(options)) {}

  /// What the messages of a topic are.
  void add_topic(std::size_t topic, const RecordedTopic& told);
  /// The picture's number. Not beside colour() and depth().
  [[nodiscard]] std::int64_t add(std::size_t topic, const MessagePlace& place);

  [[nodiscard]] ColourImage colour(std::int64_t message) const override;
  [[nodiscard]] InverseDepthImage depth(std::int64_t message,
                                        const DepthEncoding& encoding) const override;

 private:
  struct Decoders;
  struct Picture {
    std::size_t topic = 0;
    MessagePlace place{};
  };
  /// The bytes of a picture, unpacked from the recording.
  [[nodiscard]] std::string bytes_of(const Picture& picture) const;
  template <typename Use>
  [[nodiscard]] auto decoded(std::int64_t message, const Use& use) const;

  OpenRecording open_;
  RecordingOptions options_;
  std::vector<Picture> pictures_{};
  std::map<std::size_t, std::shared_ptr<const Decoders>> topics_{};
  mutable std::mutex mutex_{};
  mutable std::unique_ptr<Recording> recording_{};  ///< once it is needed
};

}  // namespace loopstone
