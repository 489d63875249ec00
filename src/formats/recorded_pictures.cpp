#include "formats/recorded_pictures.hpp"

#include <fmt/format.h>

#include <optional>
#include <utility>

#include "formats/picture_messages.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {

/// Of one topic: the one that its type asks for.
struct RecordedPictures::Decoders {
  std::string name{};
  std::optional<MessageDecoder<msg::Image>> plain{};
  std::optional<MessageDecoder<msg::CompressedImage>> packed{};
};

void RecordedPictures::add_topic(std::size_t topic, const RecordedTopic& told) {
  auto decoders = std::make_shared<Decoders>();
  decoders->name = told.name;
  if (told.type == "sensor_msgs/CompressedImage") {
    decoders->packed.emplace(told.format, told.definition);
  } else {
    decoders->plain.emplace(told.format, told.definition);
  }
  topics_[topic] = std::move(decoders);
}

std::int64_t RecordedPictures::add(std::size_t topic, const MessagePlace& place) {
  pictures_.push_back({topic, place});
  return static_cast<std::int64_t>(pictures_.size()) - 1;
}

std::string RecordedPictures::bytes_of(const Picture& picture) const {
  const std::lock_guard lock(mutex_);
  if (!recording_) recording_ = open_(options_);
  const auto bytes = recording_->bytes_at(picture.place);
  return {bytes.data(), bytes.size()};
}

template <typename Use>
auto RecordedPictures::decoded(std::int64_t message, const Use& use) const {
  const Picture& picture = pictures_.at(static_cast<std::size_t>(message));
  const Decoders& decoders = *topics_.at(picture.topic);
  const std::string bytes = bytes_of(picture);
  const std::string where = fmt::format("{}, picture {}", decoders.name, message);
  try {
    if (decoders.packed) {
      msg::CompressedImage value;
      decoders.packed->decode(bytes, value);
      return use(value, where);
    }
    msg::Image value;
    decoders.plain->decode(bytes, value);
    return use(value, where);
  } catch (const MessageError& error) {
    throw DataError({where}, error.what());
  }
}

ColourImage RecordedPictures::colour(std::int64_t message) const {
  return decoded(
      message, [](const auto& value, const std::string& where) { return to_colour(value, where); });
}

InverseDepthImage RecordedPictures::depth(std::int64_t message,
                                          const DepthEncoding& encoding) const {
  return decoded(message, [&](const auto& value, const std::string& where) {
    return to_depth(value, encoding, where);
  });
}

}  // namespace loopstone
