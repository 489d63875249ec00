#include "loopstone/formats/session_file.hpp"

#include <algorithm>
#include <cstdint>
#include <set>

#include "formats/atomic_file.hpp"
#include "formats/crc32.hpp"
#include "loopstone/base/byte_archive.hpp"

namespace loopstone {

namespace {

constexpr std::string_view kMagic = "LOOPSESS";
constexpr std::uint32_t kFormatVersion = 1;
constexpr std::string_view kEnd = "END ";
constexpr std::size_t kTagBytes = 4;
constexpr std::uint16_t kOptional = 1;  // of the flags

using Sink = std::function<void(std::string_view)>;

template <typename... Values>
std::string bytes_of(const Values&... values) {
  ByteWriter writer;
  writer(values...);
  return writer.take();
}

void put_chunk(std::string_view tag, std::uint16_t version, std::uint16_t flags,
               std::string_view payload, const Sink& sink) {
  const std::string head =
      std::string(tag) + bytes_of(version, flags, static_cast<std::uint64_t>(payload.size()));
  sink(head);
  sink(payload);
  sink(bytes_of(crc32_of(payload, crc32_of(head))));
}

void put_session(std::span<const StateChunk> chunks, const Sink& sink) {
  const std::string head = std::string(kMagic) + bytes_of(kFormatVersion);
  sink(head);
  sink(bytes_of(crc32_of(head)));
  for (const StateChunk& chunk : chunks) {
    put_chunk(chunk.tag, chunk.version, chunk.optional ? kOptional : 0, chunk.bytes, sink);
  }
  put_chunk(kEnd, 1, 0, bytes_of(static_cast<std::uint32_t>(chunks.size())), sink);
}

/// Walks through the bytes; whatever it hands out lies within them.
class Walk {
 public:
  Walk(std::string_view bytes, const std::string& path) : bytes_(bytes), path_(path) {}

  [[nodiscard]] Location here() const { return {path_, {}, static_cast<std::int64_t>(at_)}; }
  [[noreturn]] void fail(const std::string& reason) const { throw DataError(here(), reason); }
  std::string_view take(std::uint64_t count) {
    if (count > bytes_.size() - at_) fail("this session is cut off");
    const std::string_view taken = bytes_.substr(at_, static_cast<std::size_t>(count));
    at_ += taken.size();
    return taken;
  }
  template <typename Value>
  Value number() {
    const Location where = here();
    Value value{};
    ByteReader reader(take(sizeof(Value)), where);
    reader(value);
    return value;
  }
  /// The checksum that follows must be that of everything since `begin`.
  void expect_checksum(std::size_t begin) {
    const std::uint32_t computed = crc32_of(bytes_.substr(begin, at_ - begin));
    if (number<std::uint32_t>() == computed) return;
    at_ = begin;
    fail("this session is damaged: a checksum is wrong");
  }
  [[nodiscard]] std::size_t at() const { return at_; }
  [[nodiscard]] bool over() const { return at_ == bytes_.size(); }

 private:
  std::string_view bytes_;
  const std::string& path_;
  std::size_t at_ = 0;
};

void read_head(Walk& walk) {
  if (walk.take(kMagic.size()) != kMagic) walk.fail("this is no session of loopstone");
  const auto version = walk.number<std::uint32_t>();
  walk.expect_checksum(0);
  if (version != kFormatVersion) {
    walk.fail("this session has version " + std::to_string(version) +
              " of the format, and this program reads version " + std::to_string(kFormatVersion));
  }
}

StateChunk read_chunk(Walk& walk) {
  const std::size_t begin = walk.at();
  StateChunk chunk;
  chunk.tag = walk.take(kTagBytes);
  chunk.version = walk.number<std::uint16_t>();
  const auto flags = walk.number<std::uint16_t>();
  const auto length = walk.number<std::uint64_t>();
  chunk.origin = walk.here();
  const std::string_view payload = walk.take(length);
  walk.expect_checksum(begin);
  if ((flags & ~kOptional) != 0) walk.fail("this session has flags that are not known");
  chunk.optional = flags == kOptional;
  chunk.bytes = payload;
  return chunk;
}

}  // namespace

std::string format_session(std::span<const StateChunk> chunks) {
  std::string bytes;
  put_session(chunks, [&](std::string_view piece) { bytes += piece; });
  return bytes;
}

void write_session(const std::string& path, std::span<const StateChunk> chunks) {
  constexpr std::size_t kPiece = std::size_t{1} << 17;
  AtomicFile file(path);
  put_session(chunks, [&](std::string_view bytes) {
    for (std::size_t at = 0; at < bytes.size(); at += kPiece) file.write(bytes.substr(at, kPiece));
  });
  file.commit();
}

std::vector<StateChunk> parse_session(std::string_view bytes, const std::string& path) {
  Walk walk(bytes, path);
  read_head(walk);
  std::vector<StateChunk> chunks;
  std::set<std::string> tags;
  while (true) {
    StateChunk chunk = read_chunk(walk);
    if (chunk.tag == kEnd) {
      if (chunk.version != 1 || chunk.optional) walk.fail("the end of this session is not known");
      ByteReader reader(chunk.bytes, chunk.origin);
      std::uint32_t count = 0;
      reader(count);
      reader.end();
      if (count != chunks.size()) walk.fail("this session lacks parts, or has too many");
      break;
    }
    if (!tags.insert(chunk.tag).second) walk.fail("part " + chunk.tag + " is there twice");
    chunks.push_back(std::move(chunk));
  }
  if (!walk.over()) walk.fail("bytes follow the end of this session");
  return chunks;
}

std::vector<StateChunk> read_session(const std::string& path, const MemoryBudget& budget) {
  std::vector<StateChunk> chunks =
      parse_session(read_whole_file(path, budget.most_text_bytes()), path);
  if (chunks.empty()) throw DataError({path}, "this session holds no parts");
  return chunks;
}

}  // namespace loopstone
