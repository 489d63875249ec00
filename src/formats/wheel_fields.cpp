#include "formats/wheel_fields.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "messages/layout.hpp"

namespace loopstone {
namespace {

using std::string_view;

/// Types that are told without a definition: their fields behind those of a header, if they have
/// one.
struct KnownType {
  string_view type;
  bool has_header;
  string_view fields;
};
constexpr std::array<KnownType, 9> kKnownTypes{{
    {"std_msgs/Int16", false, "int16 data\n"},
    {"std_msgs/Int32", false, "int32 data\n"},
    {"std_msgs/Int64", false, "int64 data\n"},
    {"std_msgs/UInt16", false, "uint16 data\n"},
    {"std_msgs/UInt32", false, "uint32 data\n"},
    {"std_msgs/UInt64", false, "uint64 data\n"},
    {"irobot_create_msgs/WheelTicks", true, "int32 ticks_left\nint32 ticks_right\n"},
    {"irobot_create_msgs/WheelVels", true, "float32 velocity_left\nfloat32 velocity_right\n"},
    {"duckietown_msgs/WheelEncoderStamped", true, "uint32 data\nuint16 resolution\nuint8 type\n"},
}};

/// Words by one of which a whole number beside a side is a count of an encoder.
constexpr std::array<string_view, 7> kCountWords{"encoder", "enc",    "tick", "ticks",
                                                 "count",   "counts", "wheel"};
/// Words by which it is something else.
constexpr std::array<string_view, 26> kOtherWords{
    "pwm",    "current", "velocity", "vel",    "speed", "rpm",    "power", "torque", "temp",
    "drop",   "cliff",   "bumper",   "bump",   "error", "fault",  "slip",  "status", "rate",
    "effort", "duty",    "voltage",  "signal", "brake", "button", "light", "caster"};

bool has(const std::vector<std::string>& words, string_view word) {
  return std::ranges::find(words, word) != words.end();
}
template <std::size_t kCount>
bool has_one_of(const std::vector<std::string>& words,
                const std::array<string_view, kCount>& wanted) {
  return std::ranges::any_of(wanted, [&](string_view word) { return has(words, word); });
}

/// Of whole numbers that can count far enough, where they wrap; 0 for anything else.
int counter_bits(Kind kind) {
  switch (kind) {
    case Kind::kInt16:
    case Kind::kUint16:
      return 16;
    case Kind::kInt32:
    case Kind::kUint32:
      return 32;
    case Kind::kInt64:
    case Kind::kUint64:
      return 62;
    default:
      return 0;
  }
}

bool is_real(Kind kind) { return kind == Kind::kFloat32 || kind == Kind::kFloat64; }

class FieldFinder {
 public:
  FieldFinder(const RecordedTopic& topic, const Layout& layout)
      : topic_(topic),
        layout_(layout),
        type_words_(words_of_name(topic.type.substr(topic.type.rfind('/') + 1))) {}

  std::vector<WheelField> find() {
    find_count_of_the_topic();
    if (found_.empty()) find_in(layout_.root, "", 0);
    return std::move(found_);
  }

 private:
  static constexpr std::size_t kMostFields = 16;
  /// Types within types within types can have more fields than anyone wants to look at.
  static constexpr int kMostLooked = 10'000;

  /// One number called data, of a topic that is named for a wheel.
  void find_count_of_the_topic() {
    const std::vector<std::string> words = words_of_name(topic_.name);
    if (!spot_of(words) || !has_one_of(words, kCountWords) || has_one_of(words, kOtherWords)) {
      return;
    }
    WheelField field{.path = "data", .bits = 0};
    for (const FieldLayout& told : layout_.message().fields) {
      if (told.shape != Shape::kOne) continue;
      if (told.name == "data") field.bits = counter_bits(told.kind);
      if (told.name == "resolution" && is_number(told.kind)) field.resolution = told.name;
    }
    const bool is_plain = topic_.type.starts_with("std_msgs/");
    if (field.bits == 0 || (!is_plain && !has_one_of(type_words_, kCountWords))) return;
    found_.push_back(std::move(field));
  }

  void find_in(std::size_t type, const std::string& path, int depth) {
    constexpr int kDeepest = 3;
    for (const FieldLayout& field : layout_.structs[type].fields) {
      if (found_.size() >= kMostFields || ++looked_ > kMostLooked) return;
      const std::string own = path.empty() ? field.name : path + "." + field.name;
      if (field.kind == Kind::kStruct && field.shape == Shape::kOne && depth < kDeepest) {
        find_in(field.nested, own, depth + 1);
      } else if (field.kind == Kind::kStruct && field.shape == Shape::kArray && field.count == 2) {
        find_drivers(field, own);
      } else if (field.shape == Shape::kOne) {
        look_at(field, own);
      }
    }
  }

  /// Two drives, the left one first, whose travel is measured in radians.
  void find_drivers(const FieldLayout& drivers, const std::string& path) {
    for (const FieldLayout& field : layout_.structs[drivers.nested].fields) {
      if (field.name != "measured_travel" || !is_real(field.kind)) continue;
      for (const bool is_left : {true, false}) {
        found_.push_back({.path = path + (is_left ? "[0]." : "[1].") + field.name,
                          .spot = WheelSpot{is_left},
                          .unit = WheelUnit::kRadians});
      }
    }
  }

  void look_at(const FieldLayout& field, const std::string& path) {
    const auto spot = spot_of(words_of_name(field.name));
    if (!spot) return;
    const std::vector<std::string> words = words_of_name(path);
    const int bits = counter_bits(field.kind);
    const bool is_count = has_one_of(words, kCountWords) || has_one_of(type_words_, kCountWords);
    if (bits > 0 && is_count && !has_one_of(words, kOtherWords)) {
      found_.push_back({.path = path, .spot = spot, .bits = bits});
    }
    const bool is_speed = is_real(field.kind) && has(words_of_name(field.name), "velocity") &&
                          has(type_words_, "wheel");
    if (is_speed) {
      found_.push_back({.path = path, .spot = spot, .unit = WheelUnit::kRadiansPerSecond});
    }
  }

  const RecordedTopic& topic_;
  const Layout& layout_;
  std::vector<std::string> type_words_;
  std::vector<WheelField> found_{};
  int looked_ = 0;
};

/// As a recording of ROS 2 would have it.
MessageDefinition known_definition(string_view type) {
  constexpr string_view kHeader =
      "================================================================================\n"
      "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n";
  const auto* const known = std::ranges::find(kKnownTypes, type, &KnownType::type);
  if (known == kKnownTypes.end()) return {};
  std::string text(known->has_header ? "std_msgs/Header header\n" : "");
  text += known->fields;
  if (known->has_header) text += kHeader;
  return {DefinitionLanguage::kRos2Msg, text};
}

/// Whether a definition can be one of those that are looked for; most are not, and need not be
/// parsed.
bool is_worth_a_look(const RecordedTopic& topic) {
  const auto holds = [&](string_view word) {
    return topic.definition.text.find(word) != std::string::npos;
  };
  if (topic.type.starts_with("std_msgs/")) return topic.type.find("Int") != std::string::npos;
  return holds("eft") || holds("fl") || holds("measured_travel") || holds("resolution");
}

}  // namespace

WheelFields wheel_fields(const RecordedTopic& topic) {
  WheelFields result{.definition = topic.definition};
  if (!topic.unreadable.empty() || is_command(topic.name) || is_command(topic.type)) return result;
  if (topic.definition.language == DefinitionLanguage::kNone && topic.format == WireFormat::kCdr) {
    result.definition = known_definition(topic.type);
  }
  if (result.definition.language == DefinitionLanguage::kNone) return result;
  if (!topic.definition.text.empty() && !is_worth_a_look(topic)) return result;
  try {
    const Layout layout = parse_definition(topic.format, result.definition);
    result.fields = FieldFinder(topic, layout).find();
  } catch (const MessageError&) {
    result.fields.clear();  // what it is nobody can tell
  }
  return result;
}

}  // namespace loopstone
