#include "formats/camera_choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>
#include <tuple>

#include "formats/camera_lens.hpp"
#include "formats/picture_messages.hpp"
#include "loopstone/sensor/camera_geometry.hpp"

namespace loopstone {
namespace {

using std::string_view;

std::string lower(string_view text) {
  std::string result(text);
  for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

bool says(const std::string& name, string_view word) {
  return lower(name).find(word) != std::string::npos;
}

/// "/camera/depth/image_raw" of "/camera/depth/image_raw/compressedDepth".
string_view without_transport(string_view name) {
  constexpr std::array<string_view, 2> kTransports{"/compressedDepth", "/compressed"};
  for (const string_view transport : kTransports) {
    if (name.ends_with(transport)) return name.substr(0, name.size() - transport.size());
  }
  return name;
}

string_view namespace_of(string_view name) { return name.substr(0, name.rfind('/')); }

/// How many parts of their names two topics share, from the front.
int shared_parts(string_view a, string_view b) {
  int parts = 0;
  for (std::size_t i = 1; i < std::min(a.size(), b.size()) && a[i] == b[i]; ++i) {
    if (a[i] == '/') ++parts;
  }
  return parts;
}

/// Infrared is the last resort for colour.
bool is_infrared(const TopicFacts& topic) {
  return says(topic.name, "infra") || says(topic.name, "/ir/") || says(topic.name, "_ir/");
}

class CameraFinder {
 public:
  CameraFinder(const TopicSurvey& survey, const std::string& base_frame)
      : survey_(survey), base_frame_(base_frame) {}

  ChosenCamera find(const std::vector<std::size_t>& depths,
                    const std::vector<std::size_t>& colours) {
    std::tuple<std::size_t, std::size_t> best{depths.front(), colours.front()};
    for (const std::size_t depth : depths) {
      for (const std::size_t colour : colours) {
        if (rank(depth, colour) > rank(std::get<0>(best), std::get<1>(best))) {
          best = {depth, colour};
        }
      }
    }
    return described(std::get<0>(best), std::get<1>(best));
  }

 private:
  [[nodiscard]] const TopicFacts& topic(std::size_t i) const { return survey_.topics[i]; }

  [[nodiscard]] std::tuple<int, bool, bool, bool, bool, double> rank(std::size_t depth,
                                                                     std::size_t colour) const {
    const TopicFacts& d = topic(depth);
    const TopicFacts& c = topic(colour);
    const bool is_mounted = survey_.frames.find(base_frame_, d.frame).has_value();
    const bool is_raw = d.kind == TopicKind::kPicture;
    return {shared_parts(d.name, c.name),
            is_mounted,
            info_of(d) != nullptr,
            !is_infrared(c),
            is_raw,
            std::min(d.rate_hz(), c.rate_hz())};
  }

  /// What tells of a topic's lens: the CameraInfo beside it, else one of its frame.
  [[nodiscard]] const msg::CameraInfo* info_of(const TopicFacts& picture) const {
    const string_view place = namespace_of(without_transport(picture.name));
    const TopicFacts* of_frame = nullptr;
    for (const TopicFacts& facts : survey_.topics) {
      if (facts.kind != TopicKind::kCameraInfo || !facts.camera) continue;
      if (namespace_of(facts.name) == place) return &*facts.camera;
      if (!facts.frame.empty() && facts.frame == picture.frame) of_frame = &facts;
    }
    return of_frame == nullptr ? nullptr : &*of_frame->camera;
  }

  [[nodiscard]] ToldLens lens_of_topic(const TopicFacts& picture) const {
    const msg::CameraInfo* const info = info_of(picture);
    if (info == nullptr) return {.fault = "no CameraInfo tells its lens"};
    const string_view name = without_transport(picture.name);
    ToldLens told =
        lens_of(*info, name.substr(name.rfind('/') + 1).find("rect") != string_view::npos);
    const PictureFacts& size = picture.picture;
    const bool differs =
        told.lens.width_px != size.width_px || told.lens.height_px != size.height_px;
    if (told.fault.empty() && size.width_px > 0 && size.height_px > 0 && differs) {
      told.lens = scaled(told.lens, size.width_px, size.height_px);
    }
    return told;
  }

  [[nodiscard]] ChosenCamera described(std::size_t depth, std::size_t colour) {
    ChosenCamera camera{.depth = depth, .colour = colour, .frame = topic(depth).frame};
    camera.model.encoding = {.kind = DepthKind::kDepth, .metres_per_unit = 0.001};
    add_lenses(camera);
    if (camera.fault.empty()) add_mount(camera);
    if (camera.fault.empty()) add_colour_mount(camera);
    return camera;
  }

  void add_lenses(ChosenCamera& camera) const {
    const TopicFacts& depth = topic(camera.depth);
    const TopicFacts& colour = topic(camera.colour);
    const ToldLens depth_lens = lens_of_topic(depth);
    const ToldLens colour_lens = lens_of_topic(colour);
    const bool is_one_frame = !depth.frame.empty() && depth.frame == colour.frame;
    camera.model.depth = depth_lens.lens;
    camera.model.colour = colour_lens.lens;
    if (depth_lens.fault.empty() && colour_lens.fault.empty()) {
      add_note(depth, depth_lens, camera);
      add_note(colour, colour_lens, camera);
    } else if (is_one_frame && depth_lens.fault.empty() != colour_lens.fault.empty()) {
      // Registered pictures share a lens, and one of them tells it.
      camera.model.colour_is_registered = true;
      camera.model.depth = depth_lens.fault.empty() ? depth_lens.lens : colour_lens.lens;
      camera.model.colour = camera.model.depth;
    } else {
      const bool is_depth = !depth_lens.fault.empty();
      camera.fault = (is_depth ? depth.name : colour.name) + ": " +
                     (is_depth ? depth_lens.fault : colour_lens.fault);
    }
  }

  static void add_note(const TopicFacts& topic, const ToldLens& told, ChosenCamera& camera) {
    constexpr double kWorthAWordPx = 0.5;
    if (told.worst_px <= kWorthAWordPx) return;
    camera.notes.push_back(
        fmt::format("{}: its lens is of a kind that is followed to {:.1f} pixels only", topic.name,
                    told.worst_px));
  }

  void add_mount(ChosenCamera& camera) const {
    const auto base_T_frame = survey_.frames.find(base_frame_, camera.frame);
    if (base_frame_.empty() || camera.frame.empty() || !base_T_frame) {
      camera.fault = fmt::format("{}: no tf tells where its frame '{}' sits on the robot",
                                 topic(camera.depth).name, camera.frame);
      return;
    }
    // An optical frame looks along its z; one whose z points up is the body's.
    constexpr double kUp = 0.9;
    const double up = (base_T_frame->rotation * Eigen::Vector3d::UnitZ()).z();
    camera.frame_is_body = up > kUp && !says(camera.frame, "optical");
    if (camera.frame_is_body) {
      camera.notes.push_back("the frame " + camera.frame +
                             " has its z axis up: taken for one that looks along x");
    }
    camera.base_height_m = base_height_m();
    camera.model.robot_T_camera = robot_T_camera(camera, *base_T_frame);
    constexpr double kLeastHeightM = 0.02;
    if (camera.model.robot_T_camera.translation.z() < kLeastHeightM) {
      camera.fault = fmt::format("by tf its frame '{}' sits in the floor", camera.frame);
      return;
    }
    camera.mount_moves = survey_.frames.moves(base_frame_, camera.frame);
  }

  /// Some robots' frames sit between the wheels; base_footprint is on the floor (REP-120).
  [[nodiscard]] double base_height_m() const {
    for (const string_view footprint : {"base_footprint", "footprint"}) {
      const auto found = survey_.frames.find(footprint, base_frame_);
      if (found) return found->translation.z();
    }
    return 0.0;
  }

  void add_colour_mount(ChosenCamera& camera) const {
    const TopicFacts& depth = topic(camera.depth);
    const TopicFacts& colour = topic(camera.colour);
    camera.model.camera_T_colour = Pose3{};
    if (depth.frame == colour.frame || camera.model.colour_is_registered) return;
    const auto depth_T_colour = survey_.frames.find(depth.frame, colour.frame);
    if (!depth_T_colour) {
      camera.fault =
          fmt::format("no tf tells where {} looks from beside {}", colour.name, depth.name);
      return;
    }
    const Pose3 body_T_optical{Eigen::Vector3d::Zero(), Eigen::Quaterniond(body_R_optical())};
    camera.model.camera_T_colour =
        camera.frame_is_body ? *depth_T_colour
                             : body_T_optical * *depth_T_colour * body_T_optical.inverse();
  }

  const TopicSurvey& survey_;
  const std::string& base_frame_;
};

}  // namespace

bool shows_depth(const TopicFacts& topic) {
  if (!topic.is_picture()) return false;
  const PictureContent content = content_of(topic.picture.encoding);
  return content == PictureContent::kDepth ||
         (content == PictureContent::kGrey16 && says(topic.name, "depth"));
}

bool shows_colour(const TopicFacts& topic) {
  // Pictures of depth in false colours are no colours.
  return topic.is_picture() && !says(topic.name, "depth/") &&
         content_of(topic.picture.encoding) == PictureContent::kColour;
}

std::optional<ChosenCamera> choose_camera(const TopicSurvey& survey, const std::string& base_frame,
                                          const std::vector<std::size_t>& depths,
                                          const std::vector<std::size_t>& colours) {
  if (depths.empty() || colours.empty()) return std::nullopt;
  return CameraFinder(survey, base_frame).find(depths, colours);
}

Pose3 robot_T_camera(const ChosenCamera& camera, const Pose3& base_T_frame) {
  Pose3 pose = base_T_frame;
  pose.translation.z() += camera.base_height_m;
  if (camera.frame_is_body) return pose;
  const Pose3 body_T_optical{Eigen::Vector3d::Zero(), Eigen::Quaterniond(body_R_optical())};
  return pose * body_T_optical.inverse();
}

}  // namespace loopstone
