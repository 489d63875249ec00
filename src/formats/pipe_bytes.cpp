#include "formats/pipe_bytes.hpp"

#include <fcntl.h>
#include <sys/poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/log_reader.hpp"

namespace loopstone {

/// The open pipe, and what was looked at.
class PipeBytes::Stream {
 public:
  Stream(const std::string& path, std::function<bool()> stop)
      : name_(path == kStandardInput ? "standard input" : path), stop_(std::move(stop)) {
    // Without O_NONBLOCK, opening waits for somebody who writes.
    descriptor_ = path == kStandardInput ? ::fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 0)
                                         : ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    if (descriptor_ < 0) {
      throw DataError({name_}, std::string("can't be opened: ") + std::strerror(errno));
    }
    struct stat status {};
    if (::fstat(descriptor_, &status) == 0 &&
        (S_ISCHR(status.st_mode) || S_ISBLK(status.st_mode))) {
      const bool terminal = ::isatty(descriptor_) != 0;
      ::close(descriptor_);
      throw DataError({name_}, terminal ? "is a terminal, not a log; name a file or a pipe"
                                        : "is a device, not a log");
    }
  }
  ~Stream() { ::close(descriptor_); }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  [[nodiscard]] const std::string& name() const { return name_; }

  /// Copies from the kept bytes at a position, or else takes new ones from the pipe.
  std::size_t read(std::size_t position, std::span<char> buffer, bool keep) {
    if (position < kept_.size()) {
      const std::size_t count = std::min(buffer.size(), kept_.size() - position);
      std::memcpy(buffer.data(), kept_.data() + position, count);
      return count;
    }
    const std::size_t count = take(buffer);
    if (keep) {
      kept_.insert(kept_.end(), buffer.begin(), buffer.begin() + static_cast<long>(count));
    } else {
      std::vector<char>().swap(kept_);  // all of it was read, and nobody comes after
    }
    return count;
  }

 private:
  std::size_t take(std::span<char> buffer) {
    constexpr int kPatience_ms = 50;
    for (;;) {
      if (stop_ && stop_()) throw ReadingStopped();
      pollfd wanted{descriptor_, POLLIN, 0};
      const int ready = ::poll(&wanted, 1, kPatience_ms);
      if (ready == 0 || (ready < 0 && errno == EINTR)) continue;
      const ssize_t count = ::read(descriptor_, buffer.data(), buffer.size());
      if (count >= 0) {
        taken_ += count;
        return static_cast<std::size_t>(count);
      }
      if (errno != EINTR && errno != EAGAIN) {
        throw DataError({name_, {}, taken_}, std::string("can't be read: ") + std::strerror(errno));
      }
    }
  }

  std::string name_;
  std::function<bool()> stop_;
  int descriptor_ = -1;
  std::vector<char> kept_;
  std::int64_t taken_ = 0;
};

namespace {

class PipeSource final : public ByteSource {
 public:
  PipeSource(std::shared_ptr<PipeBytes::Stream> stream, bool keep)
      : stream_(std::move(stream)), keep_(keep) {}

  std::size_t read(std::span<char> buffer) override {
    const std::size_t count = stream_->read(done_, buffer, keep_);
    done_ += count;
    return count;
  }
  std::int64_t bytes_done() const override { return static_cast<std::int64_t>(done_); }
  std::int64_t bytes_total() const override { return 0; }  // not known

 private:
  std::shared_ptr<PipeBytes::Stream> stream_;
  bool keep_;
  std::size_t done_ = 0;
};

}  // namespace

PipeBytes::PipeBytes(const std::string& path, std::function<bool()> stop)
    : stream_(std::make_shared<Stream>(path, std::move(stop))) {}

const std::string& PipeBytes::name() const { return stream_->name(); }

std::unique_ptr<ByteSource> PipeBytes::look() const {
  return std::make_unique<PipeSource>(stream_, true);
}

std::unique_ptr<ByteSource> PipeBytes::read() const {
  return std::make_unique<PipeSource>(stream_, false);
}

}  // namespace loopstone
