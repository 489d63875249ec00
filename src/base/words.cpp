#include "loopstone/base/words.hpp"

namespace loopstone {

bool WordField::set(std::string_view word) const {
  const auto found = std::ranges::find(words_, word);
  if (found == words_.end()) return false;
  set_(field_, static_cast<std::size_t>(found - words_.begin()));
  return true;
}

}  // namespace loopstone
