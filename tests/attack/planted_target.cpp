// A target with every fault that an attack must find, each under its own word: what the attack's
// own test attacks.

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string_view>
#include <vector>

namespace {

/// Deeper than any stack.
int overflow(int depth) {
  volatile char room[4096] = {'x'};
  return depth == 0 ? 0 : overflow(depth - 1) + room[0];
}

void hang() {
  volatile bool forever = true;
  while (forever) {
  }
}

void bloat() {
  constexpr std::size_t kSteps = 8;
  std::vector<std::vector<char>> kept;
  for (std::size_t i = 0; i < kSteps; ++i) kept.emplace_back(std::size_t{64} << 20, 'x');
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view word(reinterpret_cast<const char*>(data), size);
  if (word == "crash") std::abort();
  if (word == "trap") __builtin_trap();
  if (word == "overflow") std::printf("%d\n", overflow(1'000'000));
  if (word == "hang") hang();
  if (word == "bloat") bloat();
  if (word == "throw") throw std::runtime_error("nobody catches this");
  if (word == "throw a number") throw 7;
  if (word == "exit") std::exit(5);
  return 0;
}
