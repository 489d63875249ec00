#include <algorithm>
#include <cmath>

#include "devices/rplidar_bytes.hpp"
#include "devices/rplidar_nodes.hpp"
#include "devices/rplidar_turns.hpp"
#include "refusal.hpp"

namespace loopstone {
namespace {

constexpr double kTurn = 6.2831853071795865;

void expect(bool law) {
  if (!law) __builtin_trap();
}

std::vector<RplidarNode> nodes_of(std::string_view bytes, std::size_t piece, RplidarAnswer type) {
  RplidarNodes nodes(type);
  std::vector<RplidarNode> all;
  while (!bytes.empty()) {
    const auto more = nodes.add(bytes.substr(0, piece));
    all.insert(all.end(), more.begin(), more.end());
    bytes.remove_prefix(std::min(piece, bytes.size()));
  }
  return all;
}

void make_scans(const std::vector<RplidarNode>& nodes) {
  const RplidarGrid grid{90, 0.15, 12.0};
  RplidarTurns turns;
  for (const RplidarNode& node : nodes) {
    expect(node.angle_rad >= 0.0 && node.angle_rad <= kTurn && node.range_m >= 0.0);
    const auto turn = turns.add(node);
    if (!turn) continue;
    expect(turn->samples() >= static_cast<std::int64_t>(turn->nodes.size()));
    for (const float range_m : grid.scan_of(*turn, true).ranges_m)
      expect(!(range_m < 0.15F) && (std::isinf(range_m) || !(range_m > 12.0F)));
  }
}

void try_nodes(std::string_view bytes) {
  for (const RplidarAnswer type :
       {RplidarAnswer::kNodes, RplidarAnswer::kCapsules, RplidarAnswer::kDenseCapsules}) {
    const auto whole = nodes_of(bytes, std::max<std::size_t>(1, bytes.size()), type);
    const auto pieces = nodes_of(bytes, 7, type);
    expect(whole.size() == pieces.size());
    for (std::size_t i = 0; i < whole.size(); ++i)
      expect(whole[i].sample == pieces[i].sample && whole[i].range_m == pieces[i].range_m);
    make_scans(whole);
    const auto answer = find_answer(bytes, RplidarAnswer::kInfo, 20);
    if (answer) (void)rplidar_info(*answer).name();
  }
}

}  // namespace
}  // namespace loopstone

// What follows the descriptor of a scan, in pieces of any size, taken for each kind of it.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes = loopstone::fuzz::text_of(data, size);
  return loopstone::fuzz::expect_work_or_refusal(bytes, [&] { loopstone::try_nodes(bytes); });
}
