#include "formats/mcap_stream.hpp"

#include <libdeflate.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <utility>
#include <vector>

#include "formats/chunk_unpack.hpp"
#include "formats/mcap_record.hpp"
#include "formats/mcap_topics.hpp"
#include "formats/recorded_topics.hpp"
#include "formats/stream_look.hpp"

namespace loopstone {
namespace {

using Clock = std::chrono::steady_clock;

/// A stream's bytes, of which as many stand in memory as the record at hand has.
class StreamWindow {
 public:
  explicit StreamWindow(std::unique_ptr<ByteSource> bytes) : bytes_(std::move(bytes)) {}

  /// Fewer than `count` only at the end. Until the next call. Nothing: they are not there, and it
  /// is later than `until`, if there is one.
  [[nodiscard]] std::optional<std::string_view> front(std::size_t count,
                                                      std::optional<Clock::time_point> until = {}) {
    while (held_ - begin_ < count) {
      if (begin_ > 0) {
        std::memmove(buffer_.data(), buffer_.data() + begin_, held_ - begin_);
        held_ -= std::exchange(begin_, 0);
      }
      // Only for what comes, not for what a damaged head says of its length.
      if (held_ == buffer_.size()) buffer_.resize(std::max(kBlock, 2 * buffer_.size()));
      const auto came = bytes_->read_now(std::span(buffer_).subspan(held_));
      if (!came && until && Clock::now() > *until) return {};
      if (came == 0) break;
      held_ += came.value_or(0);
    }
    return std::string_view{buffer_.data() + begin_, std::min(count, held_ - begin_)};
  }
  void pass(std::size_t count) {
    begin_ += count;
    passed_ += static_cast<std::int64_t>(count);
  }
  /// Bytes of the stream before the front.
  [[nodiscard]] std::int64_t passed() const { return passed_; }

 private:
  static constexpr std::size_t kBlock = std::size_t{1} << 16;

  std::unique_ptr<ByteSource> bytes_;
  std::vector<char> buffer_{};
  std::size_t begin_ = 0;
  std::size_t held_ = 0;
  std::int64_t passed_ = 0;
};

class McapStream final : public StreamedRecording {
 public:
  McapStream(std::unique_ptr<ByteSource> bytes, std::string name, const RecordingOptions& options,
             std::optional<double> look_s)
      : StreamedRecording(std::move(name), options, look_s), window_(std::move(bytes)) {
    if (window_.front(kMcapMagic.size()) != kMcapMagic)
      throw DataError({name_}, "is no stream of MCAP");
    window_.pass(kMcapMagic.size());
  }

  [[nodiscard]] std::optional<RecordedMessage> next() override;
  [[nodiscard]] ReadProgress progress() const override { return {window_.passed(), 0}; }

 private:
  [[nodiscard]] std::optional<RecordedMessage> next_of_stream();
  [[nodiscard]] std::optional<RecordedMessage> next_in_chunk();
  [[nodiscard]] std::optional<RecordedMessage> use(McapOp op, std::string_view fields);
  void open_chunk(std::string_view fields);
  [[noreturn]] void fail(const std::string& what) const {
    throw DataError({name_, {}, window_.passed()}, what);
  }

  StreamWindow window_;
  McapTopics channels_{};
  ChunkUnpacker unpacker_{};
  std::string_view chunk_{};  ///< what is left of the one that was unpacked
  std::size_t to_pass_ = 0;   ///< of the window: the record in use, or the chunk's
  bool is_over_ = false;
};

std::optional<RecordedMessage> McapStream::next() {
  while (true) {
    if (auto kept = look_.next_kept(topics_)) return kept;
    if (look_.is_enough()) return {};
    auto message = next_of_stream();
    if (!message) return {};
    look_.take(*message, topics_);
    if (!look_.is_on()) return message;
  }
}

std::optional<RecordedMessage> McapStream::next_of_stream() {
  while (!is_over_) {
    if (auto message = next_in_chunk()) return message;
    window_.pass(std::exchange(to_pass_, 0));
    const auto until = look_.until();
    const auto bytes = window_.front(kMcapHead, until);
    if (!bytes || bytes->empty()) break;
    const auto head = read_mcap_head(*bytes);
    if (!head)
      fail(bytes->size() < kMcapHead ? "the stream ends within a record"
                                     : "there should be a record here, and is none");
    options_.memory.require(head->length, 0, Growth::kNumbers, {name_, {}, window_.passed()});
    const auto length = static_cast<std::size_t>(head->end());
    const auto whole = window_.front(length, until);
    if (!whole) break;
    if (whole->size() < length) fail("the stream ends within a record");
    const std::string_view record = *whole;
    to_pass_ = length;
    if (head->op == McapOp::kDataEnd || head->op == McapOp::kFooter) {
      is_over_ = true;
    } else if (head->op == McapOp::kChunk) {
      open_chunk(record.substr(kMcapHead));
    } else if (auto message = use(head->op, record.substr(kMcapHead))) {
      return message;
    }
  }
  return {};
}

void McapStream::open_chunk(std::string_view fields) {
  const auto head = read_mcap_chunk(fields);
  if (!head || head->data + head->data_size > fields.size())
    fail("this chunk does not have the length that it states");
  const auto packing = packing_of(head->compression);
  if (!packing) fail("this chunk is packed in a way that is not known");
  const auto unpacked =
      unpacker_.unpack(*packing, fields.substr(head->data, head->data_size), head->unpacked_size,
                       options_.memory.allowed_bytes(fields.size(), Growth::kNumbers), [this] {
                         if (options_.stop && options_.stop()) throw ReadingStopped();
                       });
  if (!unpacked.damage.empty()) fail("this chunk: " + unpacked.damage);
  const bool is_wrong =
      head->checksum != 0 &&
      libdeflate_crc32(0, unpacked.bytes.data(), unpacked.bytes.size()) != head->checksum;
  if (is_wrong) fail("the checksum of this chunk is wrong");
  chunk_ = unpacked.bytes;
}

std::optional<RecordedMessage> McapStream::next_in_chunk() {
  while (!chunk_.empty()) {
    const auto head = read_mcap_head(chunk_);
    if (!head || head->end() > chunk_.size()) fail("a record in this chunk is damaged");
    const std::string_view fields =
        chunk_.substr(kMcapHead, static_cast<std::size_t>(head->length));
    chunk_.remove_prefix(static_cast<std::size_t>(head->end()));
    if (auto message = use(head->op, fields)) return message;
  }
  return {};
}

/// Messages of channels that nothing told of are left out.
std::optional<RecordedMessage> McapStream::use(McapOp op, std::string_view fields) {
  bool is_good = true;
  if (op == McapOp::kSchema) is_good = channels_.add_schema(fields, false, topics_);
  if (op == McapOp::kChannel) is_good = channels_.add_channel(fields, false, topics_);
  if (!is_good) fail("a record that describes a topic is damaged");
  if (op != McapOp::kMessage) return {};
  const auto message = read_mcap_message(fields);
  if (!message) fail("a message is damaged");
  const auto topic = channels_.topic_of(message->channel);
  if (!topic || (!look_.is_on() && !topics_.is_wanted(*topic))) return {};
  return RecordedMessage{.topic = *topic,
                         .recorded = message->recorded,
                         .bytes = {message->bytes.data(), message->bytes.size()},
                         .file = &name_,
                         .offset = window_.passed()};
}

}  // namespace

std::unique_ptr<StreamedRecording> stream_mcap(std::unique_ptr<ByteSource> bytes,
                                               const std::string& name,
                                               const RecordingOptions& options,
                                               std::optional<double> look_s) {
  return std::make_unique<McapStream>(std::move(bytes), name, options, look_s);
}

}  // namespace loopstone
