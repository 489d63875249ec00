#include "loopstone/simulation/realism.hpp"

#include <algorithm>
#include <array>

#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

constexpr std::string_view kSwitch = ".on";

constexpr std::array<std::string_view, 15> kUsual{
    "range",  "mixed", "dropouts", "steps",  "sweep", "mount", "stamps", "loss",
    "wheels", "gyro",  "uneven",   "turned", "bent",  "moved", "walkers"};

/// Name and switch of every effect.
struct Switch {
  std::string name;
  bool* is_on;
};

std::vector<Switch> switches_of(Realism& realism) {
  std::vector<Switch> switches;
  for (const OptionEntry& entry : list_options(realism)) {
    if (!entry.key.ends_with(kSwitch)) continue;
    switches.push_back(
        {entry.key.substr(0, entry.key.size() - kSwitch.size()), std::get<bool*>(entry.value)});
  }
  return switches;
}

std::string listed_names() {
  std::string text;
  for (const std::string& name : realism_names()) text += name + ", ";
  return text + "usual, all or none";
}

void turn_on(const std::vector<Switch>& switches, std::string_view name) {
  const bool is_all = name == "all";
  const bool is_usual = name == "usual";
  bool is_known = is_all || is_usual || name == "none";
  for (const Switch& each : switches) {
    const bool is_one_of_them =
        is_all || (is_usual && std::ranges::find(kUsual, each.name) != kUsual.end());
    if (!is_one_of_them && each.name != name) continue;
    *each.is_on = true;
    is_known = true;
  }
  if (!is_known) {
    throw UsageError("there is no effect of realism '" + std::string(name) + "'; there are " +
                     listed_names());
  }
}

}  // namespace

std::vector<std::string> realism_names() {
  Realism realism;
  std::vector<std::string> names;
  for (const Switch& each : switches_of(realism)) names.push_back(each.name);
  return names;
}

std::vector<std::string> realism_names(const Realism& realism) {
  Realism copy = realism;
  std::vector<std::string> names;
  for (const Switch& each : switches_of(copy)) {
    if (*each.is_on) names.push_back(each.name);
  }
  return names;
}

std::vector<std::string> usual_realism() { return {kUsual.begin(), kUsual.end()}; }

void choose_realism(Realism& realism, std::string_view list) {
  const std::vector<Switch> switches = switches_of(realism);
  for (const Switch& each : switches) *each.is_on = false;
  while (!list.empty()) {
    const std::size_t comma = std::min(list.find(','), list.size());
    turn_on(switches, list.substr(0, comma));
    list.remove_prefix(std::min(comma + 1, list.size()));
  }
}

Rng realism_stream(std::uint64_t seed, std::string_view effect) {
  // By the name, so that an effect that is added leaves the others' numbers as they were (Fowler,
  // Noll, Vo: FNV-1a).
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (const char letter : effect) {
    hash ^= static_cast<unsigned char>(letter);
    hash *= 0x100000001b3ULL;
  }
  return Rng(seed).fork(hash);
}

}  // namespace loopstone
