#include "formats/atomic_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>

#include "formats/text_numbers.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/base/memory_budget.hpp"

namespace loopstone {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 18;

[[noreturn]] void fail(const std::string& path, const std::string& what, int error_number) {
  throw DataError({path}, what + ": " + std::generic_category().message(error_number));
}

/// A name in the same folder, so that rename() stays within one file system. Hidden, and unlike any
/// other process's.
std::string temporary_name_beside(const std::string& target) {
  static std::atomic<unsigned> counter{0};
  const std::filesystem::path path(target);
  const std::string name = "." + path.filename().string() + "." + std::to_string(::getpid()) + "-" +
                           std::to_string(counter.fetch_add(1)) + ".partial";
  return (path.parent_path() / name).string();
}

}  // namespace

std::optional<PartialName> parse_partial_name(const std::string& file_name) {
  constexpr std::string_view kEnd = ".partial";
  if (!file_name.starts_with('.') || !file_name.ends_with(kEnd)) return std::nullopt;
  const std::string stem = file_name.substr(1, file_name.size() - 1 - kEnd.size());
  const std::size_t dot = stem.rfind('.');
  if (dot == stem.npos || dot == 0) return std::nullopt;
  const std::string_view numbers = std::string_view(stem).substr(dot + 1);
  const std::size_t dash = std::min(numbers.find('-'), numbers.size());
  const auto process = parse_integer(numbers.substr(0, dash));
  if (!process || *process <= 0) return std::nullopt;
  if (dash < numbers.size() && !parse_integer(numbers.substr(dash + 1))) return std::nullopt;
  return PartialName{stem.substr(0, dot), *process};
}

AtomicFile::AtomicFile(std::string path) : path_(std::move(path)), final_path_(path_) {
  if (path_.empty()) throw UsageError("the name of an output file is empty");
  std::error_code ignored;
  const auto canonical =
      std::filesystem::canonical(path_, ignored);  // replace a link's target, not the link
  if (!ignored) final_path_ = canonical.string();
  const auto status = std::filesystem::status(final_path_, ignored);
  if (std::filesystem::is_directory(status)) {
    throw DataError({path_}, "cannot write here: it is a folder; give a file name");
  }
  straight_through_ = std::filesystem::exists(status) && !std::filesystem::is_regular_file(status);
  const int creation = straight_through_ ? 0 : (O_CREAT | O_EXCL);
  // In a container every run may have the same process id: the name may be taken by one that was
  // killed.
  do {
    temporary_path_ = straight_through_ ? final_path_ : temporary_name_beside(final_path_);
    descriptor_ = ::open(temporary_path_.c_str(), O_WRONLY | O_CLOEXEC | creation, 0666);
  } while (descriptor_ < 0 && errno == EEXIST);
  if (descriptor_ < 0) fail(path_, "cannot create this file", errno);
  buffer_.reserve(kBufferBytes);
}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : path_(std::move(other.path_)),
      final_path_(std::move(other.final_path_)),
      temporary_path_(std::exchange(other.temporary_path_, {})),
      buffer_(std::move(other.buffer_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      straight_through_(other.straight_through_),
      finished_(other.finished_) {}

AtomicFile::~AtomicFile() { discard(); }

void AtomicFile::write(std::string_view bytes) {
  assert(descriptor_ >= 0 && "written after finish_writing()");
  if (buffer_.size() + bytes.size() > kBufferBytes) flush_buffer();
  buffer_.append(bytes);
  if (buffer_.size() > kBufferBytes) flush_buffer();
}

void AtomicFile::overwrite(std::int64_t offset, std::string_view bytes) {
  assert(descriptor_ >= 0 && "written after finish_writing()");
  flush_buffer();
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(descriptor_, bytes.data(), bytes.size(), offset);
    if (written < 0) {
      if (errno == EINTR) continue;
      const int error_number = errno;
      discard();
      fail(path_, "cannot write to this file", error_number);
    }
    bytes.remove_prefix(static_cast<std::size_t>(written));
    offset += written;
  }
}

void AtomicFile::flush_buffer() {
  std::string_view rest = buffer_;
  while (!rest.empty()) {
    const ssize_t written = ::write(descriptor_, rest.data(), rest.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      const int error_number = errno;
      discard();
      fail(path_, "cannot write to this file", error_number);
    }
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
  buffer_.clear();
}

void AtomicFile::finish_writing() {
  if (finished_) return;
  flush_buffer();
  // Quotas and network file systems report a full disk only here. A pipe cannot be synchronised,
  // and need not be.
  const bool synced = straight_through_ || ::fsync(descriptor_) == 0 || errno == EINVAL;
  int error_number = synced ? 0 : errno;
  if (::close(std::exchange(descriptor_, -1)) != 0 && error_number == 0) error_number = errno;
  if (error_number != 0) {
    discard();
    fail(path_, "cannot write to this file", error_number);
  }
  finished_ = true;
}

void AtomicFile::commit() {
  finish_writing();
  if (!straight_through_ && std::rename(temporary_path_.c_str(), final_path_.c_str()) != 0) {
    const int error_number = errno;
    discard();
    fail(path_, "cannot put this file in place", error_number);
  }
  temporary_path_.clear();
}

void AtomicFile::discard() noexcept {
  if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
  if (!straight_through_ && !temporary_path_.empty()) ::unlink(temporary_path_.c_str());
  temporary_path_.clear();
}

void write_file_atomically(const std::string& path, std::string_view bytes) {
  AtomicFile file(path);
  file.write(bytes);
  file.commit();
}

std::string read_whole_file(const std::string& path, std::size_t most_bytes, std::string buffer) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) fail(path, "cannot open this file", errno);
  std::string content = std::move(buffer);
  content.clear();
  struct stat status {};
  const bool is_regular = ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
  std::uint64_t most = most_bytes;
  if (!is_regular) most = std::min(most, MemoryBudget::kSmall);
  const bool is_too_large = is_regular && static_cast<std::uint64_t>(status.st_size) > most;
  if (is_regular && !is_too_large) content.reserve(static_cast<std::size_t>(status.st_size));
  std::array<char, 1 << 16> chunk;
  while (true) {
    const ssize_t count = is_too_large ? 1 : ::read(descriptor, chunk.data(), chunk.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0 || is_too_large || content.size() + static_cast<std::size_t>(count) > most) {
      const int error_number = errno;
      ::close(descriptor);
      if (count < 0) fail(path, "cannot read this file", error_number);
      if (count > 0) {
        throw DataError({path}, "is larger than " + bytes_text(most) +
                                    (is_regular ? ", the most that is read of such a file"
                                                : ", the most that is read of a pipe or a device"));
      }
      return content;
    }
    content.append(chunk.data(), static_cast<std::size_t>(count));
  }
}

}  // namespace loopstone
