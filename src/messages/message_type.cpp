#include "messages/all_messages.hpp"
#include "messages/compiled_layout.hpp"
#include "messages/definition_text.hpp"

namespace loopstone {

template <typename M>
std::string MessageType<M>::name() {
  return std::string(Fields<M>::kName);
}

template <typename M>
std::string MessageType<M>::ros1_definition() {
  return definition_text(compiled_layout<M>(WireFormat::kRos1), WireFormat::kRos1);
}

template <typename M>
std::string MessageType<M>::ros2_definition() {
  return definition_text(compiled_layout<M>(WireFormat::kCdr), WireFormat::kCdr);
}

template <typename M>
std::string MessageType<M>::md5() {
  return md5_of(compiled_layout<M>(WireFormat::kRos1));
}

template <typename M>
std::string MessageType<M>::rihs01() {
  return rihs01_of(compiled_layout<M>(WireFormat::kCdr));
}

#define LOOPSTONE_INSTANTIATE(M) template struct MessageType<msg::M>;
LOOPSTONE_ALL_MESSAGES(LOOPSTONE_INSTANTIATE)
#undef LOOPSTONE_INSTANTIATE

}  // namespace loopstone
