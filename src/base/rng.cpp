#include "loopstone/base/rng.hpp"

#include <bit>
#include <cmath>

namespace loopstone {

namespace {

std::uint64_t splitmix64(std::uint64_t& state) {
  std::uint64_t z = (state += 0x9e3779b97f4a7c15ULL);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

}  // namespace

Rng::Rng(std::uint64_t seed) : seed_(seed) {
  std::uint64_t mixer = seed;
  for (auto& word : state_) word = splitmix64(mixer);
}

Rng Rng::fork(std::uint64_t stream) const {
  std::uint64_t mixer = seed_ ^ (stream + 1) * 0xd1342543de82ef95ULL;
  return Rng(splitmix64(mixer));
}

Rng::result_type Rng::operator()() {
  const std::uint64_t result = std::rotl(state_[1] * 5, 7) * 9;
  const std::uint64_t t = state_[1] << 17;
  state_[2] ^= state_[0];
  state_[3] ^= state_[1];
  state_[1] ^= state_[2];
  state_[0] ^= state_[3];
  state_[2] ^= t;
  state_[3] = std::rotl(state_[3], 45);
  return result;
}

double Rng::uniform() { return static_cast<double>((*this)() >> 11) * 0x1.0p-53; }

double Rng::uniform(double low, double high) { return low + (high - low) * uniform(); }

std::uint64_t Rng::below(std::uint64_t count) {
  // Rejection keeps every value equally likely.
  const std::uint64_t limit = max() - max() % count;
  std::uint64_t value = (*this)();
  while (value >= limit) value = (*this)();
  return value % count;
}

double Rng::normal(double mean, double standard_deviation) {
  if (has_spare_normal_) {
    has_spare_normal_ = false;
    return mean + standard_deviation * spare_normal_;
  }
  double u = 0.0;
  double v = 0.0;
  double s = 0.0;
  do {
    u = uniform(-1.0, 1.0);
    v = uniform(-1.0, 1.0);
    s = u * u + v * v;
  } while (s >= 1.0 || s == 0.0);
  const double factor = std::sqrt(-2.0 * std::log(s) / s);
  spare_normal_ = v * factor;
  has_spare_normal_ = true;
  return mean + standard_deviation * u * factor;
}

}  // namespace loopstone
