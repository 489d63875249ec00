#pragma once

#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "loopstone/base/byte_archive.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone::test {

/// What gives its state out as data; anything else is data.
template <typename Object>
concept HasState = requires(Object& object) {
  object.restore(object.state());
};

/// An object's state, or data, as bytes: two objects with the same bytes can't be told apart by
/// what they do next.
template <typename... Objects>
[[nodiscard]] std::string state_of(const Objects&... objects) {
  ByteWriter writer;
  const auto write = [&](const auto& object) {
    if constexpr (HasState<std::remove_cvref_t<decltype(object)>>) {
      writer(object.state());
    } else {
      writer(object);
    }
  };
  (write(objects), ...);
  return writer.take();
}

/// Puts a state back and holds that all of it was read.
template <typename Object>
void restore(Object& object, std::string_view bytes) {
  ByteReader reader(bytes);
  if constexpr (HasState<Object>) {
    typename Object::State state;
    reader(state);
    reader.end();
    object.restore(std::move(state));
  } else {
    reader(object);
    reader.end();
  }
}

/// The state of `object` in `fresh`, which was made the same way.
template <typename Object>
[[nodiscard]] Object restored(const Object& object, Object fresh) {
  restore(fresh, state_of(object));
  return fresh;
}

/// Whether an object takes its own state, and refuses it once that was spoilt.
template <typename Object, typename Spoil>
[[nodiscard]] bool refuses(const Object& object, Spoil&& spoil) {
  Object other = object;
  other.restore(object.state());
  typename Object::State state = object.state();
  spoil(state);
  try {
    other.restore(std::move(state));
  } catch (const UsageError&) {
    return true;
  }
  return false;
}

}  // namespace loopstone::test
