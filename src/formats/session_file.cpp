#include "loopstone/formats/session_file.hpp"

#include <filesystem>
#include <string>
#include <system_error>

#include "base/crc32.hpp"
#include "formats/atomic_file.hpp"
#include "loopstone/base/byte_archive.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/version.hpp"

namespace loopstone {

namespace {

constexpr std::string_view kMagic = "LOOPSESS";

template <typename... Values>
std::string bytes_of(const Values&... values) {
  ByteWriter writer;
  writer(values...);
  return writer.take();
}

/// Head, content and end of a file.
struct Pieces {
  std::string head{};
  std::string content{};
  std::string end{};
};

Pieces pieces_of(const Session& session) {
  Pieces pieces;
  pieces.head = std::string(kMagic) + bytes_of(Session::kVersion);
  pieces.head += bytes_of(crc32_of(pieces.head));
  pieces.content = bytes_of(session);
  const std::string length = bytes_of(static_cast<std::uint64_t>(pieces.content.size()));
  pieces.head += length;
  pieces.end = bytes_of(crc32_of(pieces.content, crc32_of(length)));
  return pieces;
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
  if (version != Session::kVersion) {
    walk.fail("this session is of version " + std::to_string(version) +
              " of the format, and this program goes on from version " +
              std::to_string(Session::kVersion) + " only");
  }
}

}  // namespace

std::string format_session(const Session& session) {
  const Pieces pieces = pieces_of(session);
  return pieces.head + pieces.content + pieces.end;
}

std::int64_t write_session(const std::string& path, const Session& session) {
  constexpr std::size_t kPiece = std::size_t{1} << 17;
  const Pieces pieces = pieces_of(session);
  const std::string_view content = pieces.content;
  AtomicFile file(path);
  file.write(pieces.head);
  for (std::size_t at = 0; at < content.size(); at += kPiece)
    file.write(content.substr(at, kPiece));
  file.write(pieces.end);
  file.commit();
  return static_cast<std::int64_t>(pieces.head.size() + content.size() + pieces.end.size());
}

Session parse_session(std::string_view bytes, const std::string& path) {
  Walk walk(bytes, path);
  read_head(walk);
  const std::size_t begin = walk.at();
  const auto length = walk.number<std::uint64_t>();
  const Location origin = walk.here();
  const std::string_view content = walk.take(length);
  walk.expect_checksum(begin);
  if (!walk.over()) walk.fail("bytes follow the end of this session");
  Session session;
  ByteReader reader(content, origin);
  reader(session);
  reader.end();
  return session;
}

Session read_session(const std::string& path, const MemoryBudget& budget) {
  return parse_session(read_whole_file(path, budget.most_text_bytes()), path);
}

std::string kept_state_path(const std::string& folder) {
  return (std::filesystem::path(folder) / "state.loopstone").string();
}

Session read_kept_state(const std::string& folder, const std::string& to_do,
                        const MemoryBudget& budget) {
  const std::string path = kept_state_path(folder);
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) {
    throw DataError({folder}, "holds no state.loopstone to " + to_do +
                                  "; `loopstone map LOG -o FOLDER --keep-state` leaves one "
                                  "(keep_state=True in Python)");
  }
  Session session = read_session(path, budget);
  SessionTerms now = session.terms;
  now.version = kVersion;
  const std::string differs = difference(session.terms, now);
  if (!differs.empty()) throw DataError({path}, "is of another kind of run: " + differs);
  return session;
}

bool is_edited_map(const std::string& folder) {
  std::error_code ignored;
  return std::filesystem::exists(std::filesystem::path(folder) / "edits.toml", ignored);
}

void remove_kept_state(const std::string& folder) {
  const std::string path = kept_state_path(folder);
  std::error_code error;
  std::filesystem::remove(path, error);
  if (error) throw DataError({path}, "cannot remove the old state: " + error.message());
}

}  // namespace loopstone
