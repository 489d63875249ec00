#include "dds_node.hpp"

#include <dds/dds.h>
#include <dds/ddsi/ddsi_sertype.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <utility>

#include "loopstone/base/error.hpp"
#include "raw_samples.hpp"

namespace loopstone::app {

namespace {

/// A writer waits no longer for a reader that is too slow.
constexpr dds_duration_t kMostBlocking = DDS_MSECS(20);

struct QosDeleter {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using Qos = std::unique_ptr<dds_qos_t, QosDeleter>;

bool is_word(std::string_view text, std::string_view more) {
  return !text.empty() && std::ranges::all_of(text, [&](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
           more.find(c) != std::string_view::npos;
  });
}

/// Cyclone's settings: those of the environment, as it would take them by itself, then ours.
std::string settings_of(const DdsOptions& options) {
  const char* const of_environment = std::getenv("CYCLONEDDS_URI");
  std::string settings = of_environment == nullptr ? "" : of_environment;
  if (options.interface.empty()) return settings;
  if (!is_word(options.interface, "_-.:"))
    throw UsageError("--interface " + options.interface + ": is no name of a network interface");
  if (!settings.empty()) settings += ',';
  return settings + "<General><Interfaces><NetworkInterface name=\"" + options.interface +
         "\"/></Interfaces></General>";
}

/// "sensor_msgs::msg::dds_::LaserScan_" of "sensor_msgs/LaserScan".
std::string dds_type(const std::string& type) {
  const std::size_t slash = type.find('/');
  return type.substr(0, slash) + "::msg::dds_::" + type.substr(slash + 1) + "_";
}

Qos qos_of(const RosTopic& topic) {
  Qos qos(dds_create_qos());
  const TopicQuality& quality = topic.quality;
  dds_qset_reliability(qos.get(),
                       quality.is_reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       kMostBlocking);
  dds_qset_durability(
      qos.get(), quality.is_latched ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, quality.depth);
  dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, quality.depth,
                              DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  const dds_data_representation_id_t representation = DDS_DATA_REPRESENTATION_XCDR1;
  dds_qset_data_representation(qos.get(), 1, &representation);
  const std::string hash = "typehash=" + topic.type_hash + ";";
  dds_qset_userdata(qos.get(), hash.data(), hash.size());
  // Other programs of this kind may tell the same topics; what this one tells is no news to it.
  dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PARTICIPANT);
  return qos;
}

std::int32_t checked(dds_return_t result, const std::string& what) {
  if (result < 0) throw DataError({what}, std::string("DDS: ") + dds_strretcode(result));
  return result;
}

void take_log(void* news, const dds_log_data_t* data) {
  static_cast<CycloneNews*>(news)->add({data->message, data->size});
}

}  // namespace

Stamp now() {
  return Stamp{std::chrono::duration_cast<std::chrono::nanoseconds>(
                   std::chrono::system_clock::now().time_since_epoch())
                   .count()};
}

void CycloneNews::add(std::string_view text) {
  constexpr std::size_t kMostKinds = 20;
  while (text.ends_with('\n')) text.remove_suffix(1);
  std::string kind(text);
  std::erase_if(kind, [](char c) { return (c >= '0' && c <= '9') || c == '.' || c == '-'; });
  const std::scoped_lock lock(mutex_);
  if (told_.size() < kMostKinds && told_.insert(kind).second)
    tell_("Cyclone DDS: " + std::string(text));
}

DdsNode::DdsNode(const DdsOptions& options, std::function<void(const std::string&)> tell)
    : news_(std::move(tell)) {
  const std::string settings = settings_of(options);
  dds_set_log_sink(take_log, &news_);
  const std::string name = "ROS 2, domain " + std::to_string(options.domain);
  const auto enter = [&](dds_return_t result) {
    if (result >= 0) return result;
    dds_set_log_sink(nullptr, nullptr);
    throw DataError({name}, std::string("can't be entered: ") + dds_strretcode(result) +
                                "; docs/ros2.md tells how to choose another network interface");
  };
  domain_ = enter(dds_create_domain(options.domain, settings.c_str()));
  Qos qos(dds_create_qos());
  const std::string about = "enclave=/;";
  dds_qset_userdata(qos.get(), about.data(), about.size());
  participant_ = dds_create_participant(options.domain, qos.get(), nullptr);
  if (participant_ < 0) dds_delete(domain_);
  enter(participant_);
}

DdsNode::~DdsNode() {
  dds_delete(participant_);
  dds_delete(domain_);
  dds_set_log_sink(nullptr, nullptr);
}

std::int32_t DdsNode::add_topic(const RosTopic& topic) const {
  if (!topic.name.starts_with('/') || !is_word(topic.name, "_/"))
    throw UsageError(topic.name + ": topics of ROS are named as in /scan or /robot1/scan");
  ddsi_sertype* type = make_raw_type(dds_type(topic.type).c_str());
  // Without a quality: that of a reader and a writer of one topic may differ.
  const dds_entity_t made = dds_create_topic_sertype(participant_, ("rt" + topic.name).c_str(),
                                                     &type, nullptr, nullptr, nullptr);
  if (made < 0) ddsi_sertype_unref(type);
  return checked(made, topic.name);
}

DdsInbox::DdsInbox(const DdsNode& node, std::vector<RosTopic> topics)
    : waitset_(checked(dds_create_waitset(node.participant_), "waiting")) {
  for (RosTopic& topic : topics) {
    const Qos qos = qos_of(topic);
    const std::int32_t reader =
        checked(dds_create_reader(node.participant_, node.add_topic(topic), qos.get(), nullptr),
                topic.name);
    checked(dds_set_status_mask(reader, DDS_DATA_AVAILABLE_STATUS), topic.name);
    const dds_entity_t unread =
        checked(dds_create_readcondition(reader, DDS_ANY_STATE), topic.name);
    checked(dds_waitset_attach(waitset_, unread, 0), topic.name);
    readers_.push_back({std::move(topic), reader});
  }
}

DdsInbox::~DdsInbox() {
  dds_delete(waitset_);
  for (const Reader& reader : readers_) dds_delete(reader.reader);
}

std::optional<CameMessage> DdsInbox::take(std::chrono::milliseconds patience) {
  if (auto message = take_now()) return message;
  (void)dds_waitset_wait(waitset_, nullptr, 0, DDS_MSECS(patience.count()));
  return take_now();
}

std::optional<CameMessage> DdsInbox::take_now() {
  for (const Reader& reader : readers_) {
    CameMessage message{.topic = reader.topic.name, .type = reader.topic.type};
    void* sample = &message.bytes;
    dds_sample_info_t info{};
    // Of a publisher that leaves there is a sample without a message.
    while (dds_take(reader.reader, &sample, &info, 1, 1) == 1) {
      if (!info.valid_data) continue;
      message.received = now();
      return message;
    }
  }
  return {};
}

DdsOutlet::DdsOutlet(const DdsNode& node, const RosTopic& topic)
    : writer_(checked(
          dds_create_writer(node.participant_, node.add_topic(topic), qos_of(topic).get(), nullptr),
          topic.name)) {}

DdsOutlet::~DdsOutlet() { dds_delete(writer_); }

void DdsOutlet::write(const std::string& bytes) const { (void)dds_write(writer_, &bytes); }

void DdsOutlet::wait_for_readers(std::chrono::milliseconds patience) const {
  (void)dds_wait_for_acks(writer_, DDS_MSECS(patience.count()));
}

}  // namespace loopstone::app
