#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/formats/picture_store.hpp"
#include "loopstone/sensor/camera_model.hpp"
#include "loopstone/sensor/messages.hpp"
#include "loopstone/sensor/rgbd_images.hpp"

namespace loopstone {

/// Loads the pictures of RGB-D frames, from files or from the recording that they are messages of.
///
/// Colour is PNG, JPEG or PNM: grey is expanded, 16 bits are reduced to 8, alpha is dropped. Depth
/// is a picture of 16-bit numbers (PNG, PNM, TIFF), which the camera's DepthEncoding explains, or
/// of metres as 32-bit numbers (PFM, TIFF). Every function is const and may be called from several
/// threads at once. Memory for unpacking is kept from call to call, as much as one frame needs for
/// every thread that was loading at the same time.
class RgbdLoader {
 public:
  /// \param pictures  of the recording that the frames come from (LogReader::pictures()); none for
  ///                  frames whose pictures are files
  explicit RgbdLoader(const CameraModel& camera, std::shared_ptr<const PictureStore> pictures = {});

  /// The pixels of both pictures; one without a name stays empty. Throws DataError that names the
  /// file: when it can't be read, is damaged, or is not of the size that the camera's lens has.
  [[nodiscard]] RgbdImages load(const RgbdFrame& frame) const;

  [[nodiscard]] ColourImage load_colour(const std::string& path) const;
  [[nodiscard]] InverseDepthImage load_depth(const std::string& path) const;

 private:
  struct Workplaces;

  CameraModel camera_;
  std::shared_ptr<const PictureStore> pictures_;
  std::vector<float> per_m_of_number_;
  std::shared_ptr<Workplaces> workplaces_;
};

/// A colour picture from the bytes of a PNG, JPEG or PNM file. Throws DataError.
[[nodiscard]] ColourImage decode_colour(std::string_view bytes,
                                        const std::string& path_for_errors = "colour");

/// A depth picture from the bytes of a PNG, PNM, TIFF or PFM file. Metres outside of the encoding's
/// range, and those that are not finite, are no measurement. Throws DataError.
/// \param per_m_of_number  inverse_depth_table(encoding)
[[nodiscard]] InverseDepthImage decode_depth(std::string_view bytes, const DepthEncoding& encoding,
                                             std::span<const float> per_m_of_number,
                                             const std::string& path_for_errors = "depth");

}  // namespace loopstone
