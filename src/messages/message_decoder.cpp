#include <optional>

#include "messages/all_messages.hpp"
#include "messages/by_definition.hpp"

namespace loopstone {
namespace {

/// Nothing when the message is to be read as compiled.
template <typename M>
std::optional<Layout> other_layout(WireFormat format, const MessageDefinition& definition) {
  if (definition.language == DefinitionLanguage::kNone) return std::nullopt;
  Layout layout;
  try {
    layout = parse_definition(format, definition);
  } catch (const MessageError&) {
    if (definition.language != DefinitionLanguage::kRos2Idl) throw;
    return std::nullopt;
  }
  if (same_layout(layout, compiled_layout<M>(format))) return std::nullopt;
  if (count_known_fields<M>(layout, layout.root) == 0) {
    throw MessageError(0, "the definition has no field of " + std::string(Fields<M>::kName));
  }
  return layout;
}

}  // namespace

template <typename M>
struct MessageDecoder<M>::Impl {
  WireFormat format;
  std::optional<Layout> other;
};

template <typename M>
MessageDecoder<M>::MessageDecoder(WireFormat format, const MessageDefinition& definition)
    : impl_(new Impl{format, other_layout<M>(format, definition)}) {}

template <typename M>
MessageDecoder<M>::~MessageDecoder() = default;
template <typename M>
MessageDecoder<M>::MessageDecoder(MessageDecoder&&) noexcept = default;
template <typename M>
MessageDecoder<M>& MessageDecoder<M>::operator=(MessageDecoder&&) noexcept = default;

template <typename M>
void MessageDecoder<M>::decode(std::span<const char> bytes, M& message) const {
  WireReader in(impl_->format, bytes);
  if (impl_->other) {
    message = M{};
    DefinedReader(in, *impl_->other).read_struct(impl_->other->root, message);
  } else {
    const FieldReader reader{in};
    reader.read(message);
  }
  in.expect_end();
}

template <typename M>
bool MessageDecoder<M>::as_compiled() const {
  return !impl_->other;
}

std::optional<msg::Header> decode_header(WireFormat format, std::span<const char> bytes) {
  try {
    WireReader in(format, bytes);
    msg::Header header;
    const FieldReader reader{in};
    reader.read(header);
    return header;
  } catch (const MessageError&) {
    return std::nullopt;
  }
}

#define LOOPSTONE_INSTANTIATE(M) template class MessageDecoder<msg::M>;
LOOPSTONE_ALL_MESSAGES(LOOPSTONE_INSTANTIATE)
#undef LOOPSTONE_INSTANTIATE

}  // namespace loopstone
