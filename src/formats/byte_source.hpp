#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "formats/byte_stream.hpp"

namespace loopstone {

/// Bytes of a file or of memory, from the beginning to the end, decompressed on the way.
class ByteSource {
 public:
  virtual ~ByteSource() = default;
  /// Fills the front of `buffer`; the number of bytes written, 0 only at the end. Throws DataError
  /// with the offset in the stored file when it can't be read or decompressed; ReadingStopped.
  [[nodiscard]] virtual std::size_t read(std::span<char> buffer) = 0;
  /// The same, but does not wait long: nothing when there is nothing yet.
  [[nodiscard]] virtual std::optional<std::size_t> read_now(std::span<char> buffer) {
    return read(buffer);
  }
  /// Position and size in bytes as stored, for progress.
  [[nodiscard]] virtual std::int64_t bytes_done() const = 0;
  [[nodiscard]] virtual std::int64_t bytes_total() const = 0;
};

/// Bytes that are looked at before they are read, decompressed on the way: a file, a pipe, or
/// memory. Plain, gzip or bzip2 is told by the first bytes, not by the name.
struct ReadableBytes {
  std::string name;  ///< for messages
  /// From an offset on, as often as wanted; offsets other than 0 only when `can_seek`. Of a pipe
  /// what was looked at is kept until it is read.
  std::function<std::unique_ptr<ByteSource>(std::int64_t offset)> look;
  /// From the beginning to the end, once, after the last look.
  std::function<std::unique_ptr<ByteSource>()> read;
  bool can_seek = false;
};

/// \param path  of a file or a pipe; "-" is the standard input
/// \param stop  asked before every block and while a pipe is silent; on true reading throws
///              ReadingStopped. May be empty.
/// Throws DataError when there is no such file, or it is a folder or a device.
[[nodiscard]] ReadableBytes open_file_or_pipe(const std::string& path,
                                              std::function<bool()> stop = {});

/// \param look_s  as StreamedBytes takes it
[[nodiscard]] ReadableBytes readable_stream(std::unique_ptr<ByteStream> stream,
                                            std::optional<double> look_s = {});

/// The same over bytes in memory, which must outlive all that is made of it.
[[nodiscard]] ReadableBytes readable_memory(std::string_view bytes, const std::string& name);

/// Bytes in memory, which must outlive the source, decompressed.
[[nodiscard]] std::unique_ptr<ByteSource> memory_byte_source(std::string_view bytes,
                                                             const std::string& name = "memory");

/// Fills the buffer unless the source ends before; the number of bytes.
[[nodiscard]] std::size_t read_fully(ByteSource& source, std::span<char> buffer);

/// Ends after so many bytes.
[[nodiscard]] std::unique_ptr<ByteSource> first_bytes(std::unique_ptr<ByteSource> source,
                                                      std::int64_t bytes);

}  // namespace loopstone
