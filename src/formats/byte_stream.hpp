#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

namespace loopstone {

/// The path that stands for the standard input.
inline constexpr const char* kStandardInput = "-";

/// Bytes that come one after the other, once: out of a pipe, over a network, out of a file that
/// somebody writes. When `stop` says so, ReadingStopped is thrown.
class ByteStream {
 public:
  virtual ~ByteStream() = default;
  /// For messages.
  [[nodiscard]] virtual const std::string& name() const = 0;
  /// Waits for bytes and puts them at the front of `buffer`; their number, 0 only at the end.
  /// Nothing: none came in kPatience. Throws DataError when they can't be read.
  [[nodiscard]] virtual std::optional<std::size_t> take(std::span<char> buffer) = 0;

  static constexpr std::chrono::milliseconds kPatience{50};
};

/// \param waits_for_writer  a pipe that nobody has written into is not at its end
/// Throws DataError when it can't be opened, or is a device: a terminal, /dev/zero.
[[nodiscard]] std::unique_ptr<ByteStream> open_pipe(const std::string& path,
                                                    std::function<bool()> stop,
                                                    bool waits_for_writer = false);

/// \param host  a name or an address; of IPv6 without brackets
/// Throws DataError when there is no such host or nobody listens there.
[[nodiscard]] std::unique_ptr<ByteStream> connect_tcp(const std::string& host,
                                                      const std::string& port,
                                                      std::function<bool()> stop);

/// A file from its beginning on, and whatever is written behind it; it ends when another file, or
/// none, is there under its name. Throws DataError when it can't be opened, and while it is read
/// when it is cut.
[[nodiscard]] std::unique_ptr<ByteStream> follow_file(const std::string& path,
                                                      std::function<bool()> stop);

}  // namespace loopstone
