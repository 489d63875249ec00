#include "formats/recording_bytes.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/log_reader.hpp"

namespace loopstone {
namespace {

/// Read at least: heads of records and small records come many at a time.
constexpr std::size_t kLeastRead = std::size_t{1} << 15;
/// Between two questions whether to stop.
constexpr std::size_t kBlock = std::size_t{1} << 21;

}  // namespace

char* RawBuffer::at_least(std::size_t bytes) { return grown(bytes, 0); }

char* RawBuffer::grown(std::size_t bytes, std::size_t kept) {
  if (bytes > size_) {
    const std::size_t fresh_size = std::max(bytes, kept > 0 ? 2 * size_ : bytes + bytes / 8);
    if (kept == 0) bytes_.reset();
    std::unique_ptr<char[]> fresh(new char[fresh_size]);
    if (kept > 0) std::memcpy(fresh.get(), bytes_.get(), kept);
    bytes_ = std::move(fresh);
    size_ = fresh_size;
  }
  return bytes_.get();
}

RecordingBytes::RecordingBytes(const std::string& path, std::function<bool()> stop)
    : name_(path), stop_(std::move(stop)) {
  descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor_ < 0) {
    throw DataError({path}, errno == ENOENT
                                ? std::string("there is no such file")
                                : std::string("can't be opened: ") + std::strerror(errno));
  }
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0 || !S_ISREG(status.st_mode)) {
    ::close(descriptor_);
    throw DataError({path}, "is no file on a disk, which a recording must be");
  }
  size_ = static_cast<std::uint64_t>(status.st_size);
}

RecordingBytes::RecordingBytes(std::string_view bytes, const std::string& name,
                               std::function<bool()> stop)
    : name_(name), stop_(std::move(stop)), memory_(bytes), size_(bytes.size()) {}

RecordingBytes::~RecordingBytes() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void RecordingBytes::ask_stop() const {
  if (stop_ && stop_()) throw ReadingStopped();
}

std::string_view RecordingBytes::view(std::uint64_t offset, std::uint64_t count) {
  if (offset >= size_) return {};
  const auto wanted = static_cast<std::size_t>(std::min(count, size_ - offset));
  const bool held = offset >= begin_ && offset - begin_ <= held_ &&
                    wanted <= held_ - static_cast<std::size_t>(offset - begin_);
  if (!held) {
    const auto most = static_cast<std::size_t>(size_ - offset);
    fill(offset, std::min(most, std::max(wanted, kLeastRead)));
  }
  if (descriptor_ < 0) return memory_.substr(static_cast<std::size_t>(offset), wanted);
  const auto at = static_cast<std::size_t>(offset - begin_);
  return {buffer_.data() + at, std::min(wanted, held_ - at)};
}

void RecordingBytes::fill(std::uint64_t offset, std::size_t count) {
  begin_ = offset;
  held_ = 0;
  ask_stop();
  if (descriptor_ < 0) {
    held_ = count;
    return;
  }
  char* const buffer = buffer_.at_least(count);
  while (held_ < count) {
    const ssize_t got = ::pread(descriptor_, buffer + held_, std::min(count - held_, kBlock),
                                static_cast<off_t>(offset + held_));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) {
      throw DataError({name_, {}, static_cast<std::int64_t>(offset + held_)},
                      std::string("can't be read: ") + std::strerror(errno));
    }
    if (got == 0) break;  // somebody cut it meanwhile
    held_ += static_cast<std::size_t>(got);
    if (held_ < count) ask_stop();
  }
}

}  // namespace loopstone
