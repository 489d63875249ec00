#include "formats/picture_topics.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "formats/atomic_file.hpp"
#include "formats/topic_names.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/sensor/camera_geometry.hpp"

namespace loopstone {
namespace {

constexpr const char* kDepthFrame = "camera_depth_optical_frame";
constexpr const char* kColourFrame = "camera_color_optical_frame";

msg::CameraInfo info_message(Stamp stamp, const char* frame, const LensModel& lens) {
  msg::CameraInfo info{.header = {stamp, frame},
                       .height = static_cast<std::uint32_t>(lens.height_px),
                       .width = static_cast<std::uint32_t>(lens.width_px),
                       .distortion_model = "plumb_bob",
                       .d = {lens.k1, lens.k2, lens.p1, lens.p2, lens.k3}};
  info.k = {lens.focal_x_px,
            0.0,
            lens.centre_x_px,
            0.0,
            lens.focal_y_px,
            lens.centre_y_px,
            0.0,
            0.0,
            1.0};
  info.r = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
  info.p = {lens.focal_x_px,
            0.0,
            lens.centre_x_px,
            0.0,
            0.0,
            lens.focal_y_px,
            lens.centre_y_px,
            0.0,
            0.0,
            0.0,
            1.0,
            0.0};
  return info;
}

msg::TransformStamped transform3(Stamp stamp, const char* parent, const char* child,
                                 const Pose3& pose) {
  msg::TransformStamped message{.header = {stamp, parent}, .child_frame_id = child};
  message.transform.translation = {
      .x = pose.translation.x(), .y = pose.translation.y(), .z = pose.translation.z()};
  const Eigen::Quaterniond& q = pose.rotation;
  message.transform.rotation = {.x = q.x(), .y = q.y(), .z = q.z(), .w = q.w()};
  return message;
}

msg::Image depth_message(Stamp stamp, const InverseDepthImage& depth) {
  constexpr double kMmPerM = 1000.0;
  constexpr double kMostMm = 65535.0;
  msg::Image message{.header = {stamp, kDepthFrame},
                     .height = static_cast<std::uint32_t>(depth.height),
                     .width = static_cast<std::uint32_t>(depth.width),
                     .encoding = "16UC1",
                     .step = static_cast<std::uint32_t>(2 * depth.width)};
  message.data.reserve(2 * depth.per_m.size());
  for (const float per_m : depth.per_m) {
    const double mm = per_m > 0.0F ? std::round(kMmPerM / static_cast<double>(per_m)) : 0.0;
    const auto number = static_cast<std::uint16_t>(mm > kMostMm ? 0.0 : mm);
    message.data.push_back(static_cast<std::uint8_t>(number & 0xFFU));
    message.data.push_back(static_cast<std::uint8_t>(number >> 8U));
  }
  return message;
}

}  // namespace

void PictureTopics::use_pictures(std::shared_ptr<const PictureStore> pictures) {
  pictures_ = std::move(pictures);
  loader_ = RgbdLoader(camera_, pictures_);
}

void PictureTopics::write(const RgbdFrame& frame, TopicWriter& writer) {
  if (!frame.depth_path.empty()) write_depth(frame, writer);
  if (!frame.colour_path.empty()) write_colour(frame, writer);
}

void PictureTopics::write_depth(const RgbdFrame& frame, TopicWriter& writer) {
  RgbdFrame alone = frame;
  alone.colour_path.clear();
  writer.send("/camera/depth/camera_info", frame.stamp,
              info_message(frame.stamp, kDepthFrame, camera_.depth));
  writer.send("/camera/depth/image_raw", frame.stamp,
              depth_message(frame.stamp, loader_.load(alone).depth));
}

void PictureTopics::write_colour(const RgbdFrame& frame, TopicWriter& writer) {
  const char* const optical = camera_.colour_is_registered ? kDepthFrame : kColourFrame;
  const Stamp stamp = frame.colour_stamp;
  writer.send("/camera/color/camera_info", stamp,
              info_message(stamp, optical, colour_lens(camera_)));
  const std::string png = colour_png(frame);
  msg::CompressedImage message{.header = {stamp, optical}, .format = "rgb8; png compressed"};
  message.data.assign(png.begin(), png.end());
  writer.send("/camera/color/image_raw/compressed", stamp, message);
}

std::string PictureTopics::colour_png(const RgbdFrame& frame) const {
  constexpr std::size_t kMostBytes = std::size_t{1} << 30;
  if (frame.colour_message < 0) {
    std::string bytes = read_whole_file(frame.colour_path, kMostBytes);
    if (bytes.starts_with("\x89PNG")) return bytes;
  }
  RgbdFrame alone = frame;
  alone.depth_path.clear();
  ColourImage colour = loader_.load(alone).colour;
  constexpr int kFast = 1;
  return encode_png(Image{.width = colour.width,
                          .height = colour.height,
                          .channels = 3,
                          .bytes = std::move(colour.rgb)},
                    kFast);
}

std::vector<msg::TransformStamped> PictureTopics::mounts(Stamp stamp,
                                                         const RgbdFrame& frame) const {
  CameraModel camera = camera_;
  if (frame.robot_T_camera) camera.robot_T_camera = *frame.robot_T_camera;
  const Pose3 base_T_depth = robot_T_depth_optical(camera);
  const Pose3 depth_T_colour = base_T_depth.inverse() * robot_T_colour_optical(camera);
  std::vector<msg::TransformStamped> mounts{
      transform3(stamp, kBaseFrame, kDepthFrame, base_T_depth)};
  if (!camera.colour_is_registered) {
    mounts.push_back(transform3(stamp, kDepthFrame, kColourFrame, depth_T_colour));
  }
  return mounts;
}

}  // namespace loopstone
