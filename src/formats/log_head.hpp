#pragma once

#include <cstddef>
#include <string>

#include "formats/byte_source.hpp"

namespace loopstone {

/// The first bytes of a log, by which its format is told: as many as any format's mark has, or any
/// foreign file's that is known.
[[nodiscard]] inline std::string head_of(const ReadableBytes& content) {
  constexpr std::size_t kHeadBytes = 16;
  std::string head(kHeadBytes, '\0');
  head.resize(read_fully(*content.look(0), head));
  return head;
}

}  // namespace loopstone
