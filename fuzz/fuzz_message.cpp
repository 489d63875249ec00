#include <string>

#include "loopstone/messages/message_codec.hpp"
#include "messages/all_messages.hpp"
#include "refusal.hpp"

// The first byte picks the message's type; the second its serialisation (lowest bit) and the
// language of its definition (the next two). A definition ends with a byte of 0; the message
// follows.
namespace {

using namespace loopstone;

struct Input {
  unsigned type = 0;
  WireFormat format = WireFormat::kCdr;
  MessageDefinition definition{};
  std::string_view bytes{};
};

Input input_of(std::string_view text) {
  Input input;
  if (text.size() < 2) return input;
  input.type = static_cast<unsigned char>(text[0]);
  const unsigned how = static_cast<unsigned char>(text[1]);
  input.format = (how & 1) == 0 ? WireFormat::kCdr : WireFormat::kRos1;
  input.definition.language = static_cast<DefinitionLanguage>(how >> 1 & 3);
  text.remove_prefix(2);
  if (input.definition.language != DefinitionLanguage::kNone) {
    input.definition.text = text.substr(0, text.find('\0'));
    text.remove_prefix(std::min(text.size(), input.definition.text.size() + 1));
  }
  input.bytes = text;
  return input;
}

/// What could be read can be written, and reads as it was.
template <typename M>
void read_and_write(const Input& input) {
  M message;
  MessageDecoder<M>(input.format, input.definition).decode(input.bytes, message);
  for (const WireFormat format : {WireFormat::kRos1, WireFormat::kCdr}) {
    std::string once;
    std::string again;
    encode_message(format, message, once);
    MessageDecoder<M>(format).decode(once, message);
    encode_message(format, message, again);
    if (once != again) __builtin_trap();
  }
}

void read_any(const Input& input) {
  unsigned type = 0;
#define LOOPSTONE_TRY(M) \
  if (type++ == input.type) read_and_write<msg::M>(input);
  LOOPSTONE_ALL_MESSAGES(LOOPSTONE_TRY)
#undef LOOPSTONE_TRY
  if (type <= input.type) {
    (void)AnyMessageDecoder(input.format, input.definition).decode(input.bytes);
    (void)decode_header(input.format, input.bytes);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text = fuzz::text_of(data, size);
  return fuzz::expect_work_or_refusal(text, [&] {
    try {
      read_any(input_of(text));
    } catch (const MessageError& error) {
      fuzz::expect_own_words(error, text);
    }
  });
}
