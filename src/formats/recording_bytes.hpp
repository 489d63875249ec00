#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace loopstone {

/// Memory that is not set to zero and keeps no contents when it grows.
class RawBuffer {
 public:
  /// At least so many bytes; what was in it is lost when it has to grow.
  [[nodiscard]] char* at_least(std::size_t bytes);
  /// Grows and keeps the first `kept` bytes.
  [[nodiscard]] char* grown(std::size_t bytes, std::size_t kept);
  [[nodiscard]] char* data() const { return bytes_.get(); }
  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  std::unique_ptr<char[]> bytes_{};
  std::size_t size_ = 0;
};

/// The bytes of a recording, at any place: of a file, read into a buffer that is used again, or of
/// memory, in place. Never mapped, so that a file that somebody cuts meanwhile is only shorter.
class RecordingBytes {
 public:
  /// \param stop  asked before every block that is read; may be empty
  /// Throws DataError when there is no such file or it can't be opened.
  RecordingBytes(const std::string& path, std::function<bool()> stop);
  /// \param bytes  must outlive this
  RecordingBytes(std::string_view bytes, const std::string& name, std::function<bool()> stop);
  ~RecordingBytes();
  RecordingBytes(const RecordingBytes&) = delete;
  RecordingBytes& operator=(const RecordingBytes&) = delete;

  [[nodiscard]] const std::string& name() const { return name_; }
  /// When it was opened.
  [[nodiscard]] std::uint64_t size() const { return size_; }
  /// The bytes from an offset on, fewer than `count` only at the end. Until the next call. Throws
  /// DataError when the file can't be read, ReadingStopped.
  [[nodiscard]] std::string_view view(std::uint64_t offset, std::uint64_t count);
  /// Throws ReadingStopped when whoever reads wants no more.
  void ask_stop() const;

 private:
  void fill(std::uint64_t offset, std::size_t count);

  std::string name_;
  std::function<bool()> stop_;
  std::string_view memory_{};
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
  RawBuffer buffer_{};
  std::uint64_t begin_ = 0;  ///< of what the buffer holds
  std::size_t held_ = 0;
};

}  // namespace loopstone
