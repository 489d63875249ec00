#include "messages/all_messages.hpp"
#include "messages/wire_values.hpp"

namespace loopstone {

template <typename M>
void encode_message(WireFormat format, const M& message, std::string& bytes) {
  WireWriter out(format, bytes);
  const FieldWriter writer{out};
  writer.write(message);
}

#define LOOPSTONE_INSTANTIATE(M) \
  template void encode_message(WireFormat, const msg::M&, std::string&);
LOOPSTONE_ALL_MESSAGES(LOOPSTONE_INSTANTIATE)
#undef LOOPSTONE_INSTANTIATE

}  // namespace loopstone
