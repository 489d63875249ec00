#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace loopstone {

/// By the first bytes.
[[nodiscard]] bool is_zstd(std::string_view head);

/// Unpacks frames of zstd, one message after another.
class ZstdUnpacker {
 public:
  ZstdUnpacker();
  ZstdUnpacker(const ZstdUnpacker&) = delete;
  ZstdUnpacker& operator=(const ZstdUnpacker&) = delete;
  ~ZstdUnpacker();

  /// All frames of `packed`, one behind the other. Memory is taken for what really comes out.
  /// \param unpacked  replaced
  /// Throws std::runtime_error with the reason when the bytes are damaged, or become more than
  /// `most_bytes`.
  void unpack(std::span<const char> packed, std::uint64_t most_bytes, std::string& unpacked);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// What came of a file that was unpacked.
struct UnpackedFile {
  std::uint64_t bytes = 0;
  std::string damage{};  ///< why there is not more; empty when it is whole
};

/// Unpacks a file into another. Damage ends it: what was unpacked before stays.
/// \param stop  as RecordingOptions::stop
/// Throws DataError when a file can't be read or written, or more than `most_bytes` come out;
/// ReadingStopped.
[[nodiscard]] UnpackedFile unpack_zstd_file(const std::string& packed, const std::string& unpacked,
                                            std::uint64_t most_bytes,
                                            const std::function<bool()>& stop);

}  // namespace loopstone
