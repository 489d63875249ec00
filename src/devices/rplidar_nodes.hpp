#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "devices/rplidar_bytes.hpp"

namespace loopstone {

/// A measurement of an RPLIDAR.
struct RplidarNode {
  double angle_rad = 0.0;  ///< clockwise from the device's own zero, in [0, 2 pi)
  double range_m = 0.0;    ///< 0: no return
  int quality = 0;         ///< of the echo, up to 63; capsules have none, and give 47 with a return
  bool begins_turn = false;
  bool after_gap = false;   ///< something was lost before it
  std::int64_t sample = 0;  ///< the how manieth that was received; by a clock of the device's
};

/// Takes measurements out of the stream that follows the descriptor of a scan, and finds its feet
/// again whatever is lost or wrong in it.
class RplidarNodes {
 public:
  /// \param type  kNodes, kCapsules or kDenseCapsules
  explicit RplidarNodes(RplidarAnswer type) : type_(type) {}

  /// The measurements that were finished by these bytes. Those of a capsule come with the next one,
  /// which tells where it ends.
  [[nodiscard]] std::vector<RplidarNode> add(std::string_view bytes);

  /// Measurements up to the end of the last whole packet.
  [[nodiscard]] std::int64_t samples() const { return samples_; }
  /// Bytes from the beginning of that packet to the last byte that was added.
  [[nodiscard]] std::size_t bytes_since() const { return packet_bytes() + pending_.size(); }
  /// Times that something was lost.
  [[nodiscard]] std::int64_t gaps() const { return gaps_; }

 private:
  struct Capsule {
    int start_q6 = 0;  ///< angle [deg / 64]
    bool is_first = false;
    std::string cabins{};
  };

  [[nodiscard]] std::size_t packet_bytes() const;
  [[nodiscard]] int samples_of_capsule() const;
  void take_nodes(std::vector<RplidarNode>& nodes);
  void take_capsules(std::vector<RplidarNode>& nodes);
  void take_capsule(Capsule capsule, std::vector<RplidarNode>& nodes);
  void unpack(const Capsule& capsule, int step_q6, std::vector<RplidarNode>& nodes);
  void push(RplidarNode node, std::vector<RplidarNode>& nodes);
  void lose();

  RplidarAnswer type_;
  std::string pending_{};
  std::optional<Capsule> last_{};
  int usual_step_q6_ = 0;  ///< between the capsules; 0: none was seen yet
  double last_raw_rad_ = 0.0;
  std::int64_t samples_ = 0;
  std::int64_t gaps_ = 0;
  bool is_lost_ = false;    ///< looks for a packet
  bool after_gap_ = false;  ///< the next measurement is
};

}  // namespace loopstone
