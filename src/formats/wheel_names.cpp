#include "formats/wheel_names.hpp"

#include <algorithm>
#include <array>
#include <cctype>

namespace loopstone {
namespace {

using std::string_view;

/// Words that stand for a spot by themselves.
struct SpotWord {
  string_view word;
  int side;  ///< 1 left, -1 right, 0 either
  WheelRow row;
};
constexpr std::array<SpotWord, 25> kSpotWords{{
    {"left", 1, WheelRow::kOnly},  {"l", 1, WheelRow::kOnly},
    {"lh", 1, WheelRow::kOnly},    {"right", -1, WheelRow::kOnly},
    {"r", -1, WheelRow::kOnly},    {"rh", -1, WheelRow::kOnly},
    {"fl", 1, WheelRow::kFront},   {"lf", 1, WheelRow::kFront},
    {"fr", -1, WheelRow::kFront},  {"rf", -1, WheelRow::kFront},
    {"rl", 1, WheelRow::kRear},    {"lr", 1, WheelRow::kRear},
    {"bl", 1, WheelRow::kRear},    {"lb", 1, WheelRow::kRear},
    {"rr", -1, WheelRow::kRear},   {"br", -1, WheelRow::kRear},
    {"rb", -1, WheelRow::kRear},   {"front", 0, WheelRow::kFront},
    {"fore", 0, WheelRow::kFront}, {"forward", 0, WheelRow::kFront},
    {"f", 0, WheelRow::kFront},    {"rear", 0, WheelRow::kRear},
    {"back", 0, WheelRow::kRear},  {"hind", 0, WheelRow::kRear},
    {"aft", 0, WheelRow::kRear},
}};

/// What other words are stuck to.
constexpr std::array<string_view, 7> kStuck{"wheel", "whl",  "left",   "right",
                                            "front", "rear", "encoder"};
constexpr std::array<string_view, 4> kWheel{"wheel", "whl", "tyre", "tire"};
constexpr std::array<string_view, 2> kMaybeWheel{"motor", "drive"};
/// Joints that are no wheels that drive, whatever else is in their names.
constexpr std::array<string_view, 42> kNoWheel{
    "caster",  "castor",   "steer", "steering", "swivel",  "drop",     "suspension",
    "passive", "shock",    "bogie", "rocker",   "arm",     "gripper",  "finger",
    "elbow",   "shoulder", "wrist", "hand",     "head",    "neck",     "pan",
    "tilt",    "lidar",    "laser", "scan",     "scanner", "fan",      "propeller",
    "brush",   "camera",   "hinge", "spring",   "knuckle", "bumper",   "sensor",
    "pivot",   "azimuth",  "roll",  "yaw",      "pitch",   "rotation", "flipper"};
constexpr std::array<string_view, 12> kCommand{"cmd",       "command", "commands",  "commanded",
                                               "desired",   "target",  "vtarget",   "goal",
                                               "reference", "request", "requested", "setpoint"};

template <std::size_t kCount>
bool is_one_of(string_view word, const std::array<string_view, kCount>& words) {
  return std::ranges::find(words, word) != words.end();
}

template <std::size_t kCount>
bool has_one_of(const std::vector<std::string>& words,
                const std::array<string_view, kCount>& wanted) {
  return std::ranges::any_of(words,
                             [&](const std::string& word) { return is_one_of(word, wanted); });
}

const SpotWord* find_spot_word(string_view word) {
  const auto* const found = std::ranges::find(kSpotWords, word, &SpotWord::word);
  return found == kSpotWords.end() ? nullptr : found;
}

/// "l", "wheel" of "lwheel"; the word itself when nothing sticks to it.
void add_unstuck(const std::string& word, std::vector<std::string>& words) {
  for (const string_view part : kStuck) {
    const auto at = word.find(part);
    if (at == std::string::npos || word.size() == part.size()) continue;
    const std::string before = word.substr(0, at);
    const std::string after = word.substr(at + part.size());
    if (!before.empty()) add_unstuck(before, words);
    words.emplace_back(part);
    if (!after.empty() && after != "s") add_unstuck(after, words);
    return;
  }
  words.push_back(word);
}

bool is_upper(char c) { return std::isupper(static_cast<unsigned char>(c)) != 0; }
bool is_lower(char c) { return std::islower(static_cast<unsigned char>(c)) != 0; }

}  // namespace

std::vector<std::string> words_of_name(string_view name) {
  std::vector<std::string> words;
  std::string word;
  const auto end_word = [&] {
    if (!word.empty()) add_unstuck(word, words);
    word.clear();
  };
  for (std::size_t i = 0; i < name.size(); ++i) {
    const char c = name[i];
    if (std::isalpha(static_cast<unsigned char>(c)) == 0) {
      end_word();
      continue;
    }
    const bool begins = i > 0 && is_upper(c) && is_lower(name[i - 1]);
    if (begins) end_word();
    word += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  end_word();
  return words;
}

std::optional<WheelSpot> spot_of(const std::vector<std::string>& words) {
  int side = 0;
  WheelRow row = WheelRow::kOnly;
  for (const std::string& word : words) {
    const SpotWord* const known = find_spot_word(word);
    if (known == nullptr) continue;
    if (known->side * side < 0) return std::nullopt;
    if (known->side != 0) side = known->side;
    if (known->row != WheelRow::kOnly) row = known->row;
  }
  if (side == 0) return std::nullopt;
  return WheelSpot{side > 0, row};
}

std::string without_spot(const std::vector<std::string>& words) {
  std::string rest;
  for (const std::string& word : words) {
    if (find_spot_word(word) == nullptr) rest += word + " ";
  }
  return rest;
}

std::optional<WheelSpot> wheel_spot(string_view name) {
  const std::vector<std::string> words = words_of_name(name.substr(name.rfind('/') + 1));
  if (has_one_of(words, kNoWheel)) return std::nullopt;
  if (!has_one_of(words, kWheel) && !has_one_of(words, kMaybeWheel)) return std::nullopt;
  return spot_of(words);
}

bool is_steering(string_view name) {
  const std::vector<std::string> words = words_of_name(name);
  return has_one_of(words, std::array<string_view, 3>{"steer", "steering", "knuckle"});
}

bool is_command(string_view name) { return has_one_of(words_of_name(name), kCommand); }

}  // namespace loopstone
