#include "devices/rplidar_nodes.hpp"

#include <cmath>

#include "loopstone/geometry/angle.hpp"

namespace loopstone {
namespace {

constexpr std::size_t kNodeBytes = 5;
constexpr std::size_t kCapsuleBytes = 84;
constexpr std::size_t kCapsuleHead = 4;
constexpr int kTurn_q6 = 360 * 64;
/// What the makers' driver gives to returns of capsules.
constexpr int kQualityOfReturn = 47;

unsigned byte_at(std::string_view bytes, std::size_t i) {
  return static_cast<unsigned char>(bytes[i]);
}

double radians_of_q6(double angle_q6) {
  const double turned = std::fmod(angle_q6, static_cast<double>(kTurn_q6));
  return (turned < 0.0 ? turned + kTurn_q6 : turned) * (2.0 * kPi / kTurn_q6);
}

/// Bit 0 begins a turn, near its zero, and bit 1 is its opposite; bit 0 of the second byte is 1.
bool looks_like_node(std::string_view bytes) {
  constexpr int kSlack_q6 = 64;  // angles are corrected a little beyond the turn
  constexpr int kNearZero_q6 = 20 * 64;
  const unsigned first = byte_at(bytes, 0);
  const auto angle_q6 = static_cast<int>(little_endian(bytes.substr(1, 2)) >> 1U);
  return ((first ^ first >> 1U) & 1U) == 1 && (byte_at(bytes, 1) & 1U) == 1 &&
         angle_q6 <= kTurn_q6 + kSlack_q6 &&
         ((first & 1U) == 0 || angle_q6 < kNearZero_q6 || angle_q6 > kTurn_q6 - kNearZero_q6);
}

/// Two nibbles of 0xA and 0x5 say that it is one, the other two are the checksum of the rest.
bool is_sound_capsule(std::string_view bytes) {
  unsigned checksum = 0;
  for (std::size_t i = 2; i < kCapsuleBytes; ++i) checksum ^= byte_at(bytes, i);
  const unsigned told = (byte_at(bytes, 0) & 0xFU) | (byte_at(bytes, 1) & 0xFU) << 4U;
  return byte_at(bytes, 0) >> 4U == 0xA && byte_at(bytes, 1) >> 4U == 0x5 && told == checksum;
}

}  // namespace

std::size_t RplidarNodes::packet_bytes() const {
  return type_ == RplidarAnswer::kNodes ? kNodeBytes : kCapsuleBytes;
}

int RplidarNodes::samples_of_capsule() const {
  return type_ == RplidarAnswer::kDenseCapsules ? 40 : 32;
}

std::vector<RplidarNode> RplidarNodes::add(std::string_view bytes) {
  pending_ += bytes;
  std::vector<RplidarNode> nodes;
  if (type_ == RplidarAnswer::kNodes) {
    take_nodes(nodes);
  } else {
    take_capsules(nodes);
  }
  return nodes;
}

void RplidarNodes::lose() {
  if (!is_lost_) ++gaps_;
  is_lost_ = true;
  after_gap_ = true;
  last_.reset();
}

void RplidarNodes::push(RplidarNode node, std::vector<RplidarNode>& nodes) {
  node.after_gap = after_gap_;
  after_gap_ = false;
  nodes.push_back(node);
}

// A node has three bits that tell it from noise, so it is believed when the next one looks like
// one, too; after a loss, when the next three do.
void RplidarNodes::take_nodes(std::vector<RplidarNode>& nodes) {
  constexpr std::size_t kLookAhead = 1;
  constexpr std::size_t kLookAheadWhenLost = 3;
  std::size_t at = 0;
  for (;;) {
    const std::size_t ahead = is_lost_ ? kLookAheadWhenLost : kLookAhead;
    if (pending_.size() - at < (ahead + 1) * kNodeBytes) break;
    const std::string_view here = std::string_view(pending_).substr(at);
    bool sound = true;
    for (std::size_t i = 0; i <= ahead; ++i)
      sound = sound && looks_like_node(here.substr(i * kNodeBytes));
    if (!sound) {
      lose();
      ++at;
      continue;
    }
    is_lost_ = false;
    RplidarNode node{
        .angle_rad = radians_of_q6(static_cast<double>(little_endian(here.substr(1, 2)) >> 1U)),
        .range_m = static_cast<double>(little_endian(here.substr(3, 2))) / 4000.0,
        .quality = static_cast<int>(byte_at(here, 0) >> 2U),
        .begins_turn = (byte_at(here, 0) & 1U) == 1,
        .sample = samples_++};
    if (node.quality == 0) node.range_m = 0.0;
    push(node, nodes);
    at += kNodeBytes;
  }
  pending_.erase(0, at);
}

void RplidarNodes::take_capsules(std::vector<RplidarNode>& nodes) {
  std::size_t at = 0;
  while (pending_.size() - at >= kCapsuleBytes) {
    const std::string_view here = std::string_view(pending_).substr(at, kCapsuleBytes);
    if (!is_sound_capsule(here)) {
      lose();
      ++at;
      continue;
    }
    is_lost_ = false;
    constexpr unsigned kAngleMask = 0x7FFF;
    const auto start = static_cast<unsigned>(little_endian(here.substr(2, 2)));
    take_capsule({static_cast<int>(start & kAngleMask), start > kAngleMask,
                  std::string(here.substr(kCapsuleHead))},
                 nodes);
    samples_ += samples_of_capsule();
    at += kCapsuleBytes;
  }
  pending_.erase(0, at);
}

void RplidarNodes::take_capsule(Capsule capsule, std::vector<RplidarNode>& nodes) {
  // The first after the motor was started has nothing to do with those before.
  if (capsule.is_first && last_) {
    last_.reset();
    after_gap_ = true;
  }
  if (last_) {
    const int step_q6 = ((capsule.start_q6 - last_->start_q6) % kTurn_q6 + kTurn_q6) % kTurn_q6;
    // Where the angle leaps, a whole capsule was lost.
    const bool leaps = usual_step_q6_ > 0 && 2 * step_q6 > 3 * usual_step_q6_;
    usual_step_q6_ = step_q6;
    if (leaps) {
      ++gaps_;
      after_gap_ = true;
    } else {
      unpack(*last_, step_q6, nodes);
    }
  }
  last_ = std::move(capsule);
}

// A cabin of an express capsule has two ranges of 14 bits [mm] and for each six bits [deg / 8], by
// which the angle is less than even steps would have it; one of a dense capsule a range of 16 bits.
void RplidarNodes::unpack(const Capsule& capsule, int step_q6, std::vector<RplidarNode>& nodes) {
  constexpr std::size_t kCabinBytes = 5;
  const int count = samples_of_capsule();
  for (int i = 0; i < count; ++i) {
    const auto n = static_cast<std::size_t>(i);
    const double raw_q6 = capsule.start_q6 + static_cast<double>(step_q6) * i / count;
    double less_q6 = 0.0;
    unsigned range_mm = 0;
    if (type_ == RplidarAnswer::kDenseCapsules) {
      range_mm =
          static_cast<unsigned>(little_endian(std::string_view(capsule.cabins).substr(2 * n, 2)));
    } else {
      const auto cabin = std::string_view(capsule.cabins).substr(n / 2 * kCabinBytes, kCabinBytes);
      const auto word = static_cast<unsigned>(little_endian(cabin.substr(n % 2 * 2, 2)));
      const unsigned low = byte_at(cabin, 4) >> (n % 2 * 4) & 0xFU;
      range_mm = word >> 2U;
      less_q6 = static_cast<double>(((word & 3U) << 4U | low) * 8U);
    }
    const double raw_rad = radians_of_q6(raw_q6);
    push({.angle_rad = radians_of_q6(raw_q6 - less_q6),
          .range_m = range_mm / 1000.0,
          .quality = range_mm > 0 ? kQualityOfReturn : 0,
          .begins_turn = !after_gap_ && raw_rad < last_raw_rad_,
          .sample = samples_ - count + i},
         nodes);
    last_raw_rad_ = raw_rad;
  }
}

}  // namespace loopstone
