#pragma once

#include <string>
#include <string_view>

#include "loopstone/base/byte_archive.hpp"

namespace loopstone::test {

/// An object's state as bytes: two objects with the same bytes can't be told apart by what they do
/// next.
template <typename... Objects>
[[nodiscard]] std::string state_of(const Objects&... objects) {
  ByteWriter writer;
  writer(objects...);
  return writer.take();
}

/// Puts a state back and holds that all of it was read.
template <typename Object>
void restore(Object& object, std::string_view state) {
  ByteReader reader(state);
  reader(object);
  reader.end();
}

/// The state of `object` in `fresh`, which was made the same way.
template <typename Object>
[[nodiscard]] Object restored(const Object& object, Object fresh) {
  restore(fresh, state_of(object));
  return fresh;
}

}  // namespace loopstone::test
