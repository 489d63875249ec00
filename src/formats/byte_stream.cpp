#include "formats/byte_stream.hpp"

#include <fcntl.h>
#include <sys/poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "devices/tcp_connection.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/log_reader.hpp"

namespace loopstone {
namespace {

constexpr int kPatience_ms = static_cast<int>(ByteStream::kPatience.count());

/// What pipes and connections share.
class DescriptorStream final : public ByteStream {
 public:
  /// \param is_begun  false: until something has come, nothing is not the end
  DescriptorStream(std::string name, Descriptor descriptor, std::function<bool()> stop,
                   bool is_begun = true)
      : name_(std::move(name)),
        descriptor_(std::move(descriptor)),
        stop_(std::move(stop)),
        is_begun_(is_begun) {}

  [[nodiscard]] const std::string& name() const override { return name_; }
  std::optional<std::size_t> take(std::span<char> buffer) override {
    if (stop_ && stop_()) throw ReadingStopped();
    pollfd wanted{descriptor_.number(), POLLIN, 0};
    const int ready = ::poll(&wanted, 1, kPatience_ms);
    if (ready == 0 || (ready < 0 && errno == EINTR)) return {};
    const ssize_t count = ::read(descriptor_.number(), buffer.data(), buffer.size());
    is_begun_ = is_begun_ || count > 0;
    if (count == 0 && !is_begun_) {
      // Of a pipe without a writer poll() says at once that it is ready.
      ::poll(nullptr, 0, kPatience_ms);
      return {};
    }
    if (count >= 0) {
      taken_ += count;
      return static_cast<std::size_t>(count);
    }
    if (errno == EINTR || errno == EAGAIN) return {};
    throw DataError({name_, {}, taken_}, std::string("can't be read: ") + std::strerror(errno));
  }

 private:
  std::string name_;
  Descriptor descriptor_;
  std::function<bool()> stop_;
  bool is_begun_;
  std::int64_t taken_ = 0;
};

class FollowedFile final : public ByteStream {
 public:
  FollowedFile(std::string path, Descriptor descriptor, std::function<bool()> stop)
      : path_(std::move(path)), descriptor_(std::move(descriptor)), stop_(std::move(stop)) {}

  [[nodiscard]] const std::string& name() const override { return path_; }
  std::optional<std::size_t> take(std::span<char> buffer) override {
    if (stop_ && stop_()) throw ReadingStopped();
    // Before it is read: what was written until then is read, too.
    const bool is_last = is_replaced();
    const ssize_t count = ::read(descriptor_.number(), buffer.data(), buffer.size());
    if (count < 0 && errno != EINTR) {
      throw DataError({path_, {}, taken_}, std::string("can't be read: ") + std::strerror(errno));
    }
    if (count > 0) {
      taken_ += count;
      return static_cast<std::size_t>(count);
    }
    require_whole();
    if (is_last && count == 0) return 0;
    ::poll(nullptr, 0, kPause_ms);
    return {};
  }

 private:
  /// How often the end of the file is looked at.
  static constexpr int kPause_ms = 10;

  void require_whole() const {
    struct stat status {};
    if (::fstat(descriptor_.number(), &status) == 0 && status.st_size < taken_)
      throw DataError({path_, {}, taken_}, "was cut while it was read");
  }
  /// Whether its name is that of another file now, or of none.
  [[nodiscard]] bool is_replaced() const {
    struct stat mine {};
    struct stat named {};
    if (::fstat(descriptor_.number(), &mine) != 0) return true;
    if (::stat(path_.c_str(), &named) != 0) return true;
    return mine.st_ino != named.st_ino || mine.st_dev != named.st_dev;
  }

  std::string path_;
  Descriptor descriptor_;
  std::function<bool()> stop_;
  std::int64_t taken_ = 0;
};

void refuse_device(const Descriptor& descriptor, const std::string& name) {
  struct stat status {};
  if (::fstat(descriptor.number(), &status) != 0) return;
  if (!S_ISCHR(status.st_mode) && !S_ISBLK(status.st_mode)) return;
  const bool is_terminal = ::isatty(descriptor.number()) != 0;
  throw DataError({name}, is_terminal ? "is a terminal, not a log; name a file or a pipe"
                                      : "is a device, not a log");
}

/// Until a connection stands, or does not.
bool wait_for_connection(int socket, const std::function<bool()>& stop) {
  constexpr int kMostWaits = 10'000 / kPatience_ms;
  for (int waits = 0; waits < kMostWaits; ++waits) {
    if (stop && stop()) throw ReadingStopped();
    pollfd wanted{socket, POLLOUT, 0};
    const int ready = ::poll(&wanted, 1, kPatience_ms);
    if (ready != 0 && (ready > 0 || errno != EINTR)) return true;
  }
  return false;
}

}  // namespace

std::unique_ptr<ByteStream> open_pipe(const std::string& path, std::function<bool()> stop,
                                      bool waits_for_writer) {
  std::string name = path == kStandardInput ? "standard input" : path;
  // Without O_NONBLOCK, opening waits for somebody who writes.
  Descriptor descriptor(path == kStandardInput
                            ? ::fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 0)
                            : ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  if (!descriptor.is_open())
    throw DataError({name}, std::string("can't be opened: ") + std::strerror(errno));
  refuse_device(descriptor, name);
  return std::make_unique<DescriptorStream>(std::move(name), std::move(descriptor), std::move(stop),
                                            !waits_for_writer);
}

std::unique_ptr<ByteStream> connect_tcp(const std::string& host, const std::string& port,
                                        std::function<bool()> stop) {
  const std::string name =
      "tcp://" + (host.find(':') == std::string::npos ? host : "[" + host + "]") + ":" + port;
  TcpConnection made =
      try_tcp(host, port, [&](int socket) { return wait_for_connection(socket, stop); });
  if (!made.unknown_host.empty())
    throw DataError({name}, "there is no such place: " + made.unknown_host);
  if (made.error != 0)
    throw DataError({name}, std::string("no connection: ") + std::strerror(made.error));
  return std::make_unique<DescriptorStream>(name, std::move(made.socket), std::move(stop));
}

std::unique_ptr<ByteStream> follow_file(const std::string& path, std::function<bool()> stop) {
  Descriptor descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!descriptor.is_open())
    throw DataError({path}, std::string("can't be opened: ") + std::strerror(errno));
  refuse_device(descriptor, path);
  return std::make_unique<FollowedFile>(path, std::move(descriptor), std::move(stop));
}

}  // namespace loopstone
