#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace loopstone {

/// Bytes of a file or of memory, from the beginning to the end, decompressed on the way.
class ByteSource {
 public:
  virtual ~ByteSource() = default;
  /// Fills the front of `buffer`; the number of bytes written, 0 only at the end.
  /// Throws DataError with the offset in the stored file when it can't be read or decompressed.
  [[nodiscard]] virtual std::size_t read(std::span<char> buffer) = 0;
  /// Position and size in bytes as stored, for progress.
  [[nodiscard]] virtual std::int64_t bytes_done() const = 0;
  [[nodiscard]] virtual std::int64_t bytes_total() const = 0;
};

/// Opens a plain, gzip or bzip2 file; which one it is, is told by its first bytes, not by its name.
/// \param offset  where to begin; only a plain file may begin elsewhere than at 0
/// Throws DataError when there is no such file, or it is a folder.
[[nodiscard]] std::unique_ptr<ByteSource> open_byte_source(const std::string& path,
                                                           std::int64_t offset = 0);

/// The same over bytes in memory, which must outlive the source.
[[nodiscard]] std::unique_ptr<ByteSource> memory_byte_source(std::string_view bytes,
                                                             const std::string& name = "memory");

enum class Compression { kNone, kGzip, kBzip2 };

/// By the magic number at the front of a file.
[[nodiscard]] Compression compression_of(std::string_view first_bytes);
[[nodiscard]] Compression compression_of_file(const std::string& path);

}  // namespace loopstone
