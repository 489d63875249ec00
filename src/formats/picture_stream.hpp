#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/sensor/messages.hpp"

namespace loopstone {

/// Makes frames of two streams of pictures, as they come: a frame is given once no picture that is
/// yet to come could change it. Bounded memory: pictures of a few seconds.
class PictureStream {
 public:
  /// \param source   how the two streams are called in errors
  PictureStream(std::string depth_source, std::string colour_source)
      : depth_source_(std::move(depth_source)), colour_source_(std::move(colour_source)) {}

  /// \param message  where the picture is found again: RgbdFrame::depth_message. Of two pictures
  ///                 with one stamp the first counts.
  void add_depth(Stamp stamp, std::int64_t message) { add({stamp, message}, depth_); }
  void add_colour(Stamp stamp, std::int64_t message) { add({stamp, message}, colour_); }

  /// Frames that are settled, by stamp; all when no more pictures come.
  [[nodiscard]] std::vector<RgbdFrame> take(bool at_end);

 private:
  struct Picture {
    Stamp stamp{};
    std::int64_t message = -1;
  };
  void add(Picture picture, std::vector<Picture>& stream);

  std::string depth_source_;
  std::string colour_source_;
  std::vector<Picture> depth_{};  ///< by stamp
  std::vector<Picture> colour_{};
  Stamp newest_{};
};

}  // namespace loopstone
