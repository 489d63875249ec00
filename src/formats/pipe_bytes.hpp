#pragma once

#include <functional>
#include <memory>
#include <string>

#include "formats/byte_source.hpp"

namespace loopstone {

/// The path that stands for the standard input.
inline constexpr const char* kStandardInput = "-";

/// What comes out of a pipe, which can't be read twice: while it is looked at, it is kept for the
/// next who begins at its beginning. Nothing here waits so long that `stop` is not heard.
class PipeBytes {
 public:
  /// Throws DataError when it can't be opened, or is a device: a terminal, /dev/zero.
  PipeBytes(const std::string& path, std::function<bool()> stop);

  /// For messages.
  [[nodiscard]] const std::string& name() const;
  /// From the beginning; what is read is kept.
  [[nodiscard]] std::unique_ptr<ByteSource> look() const;
  /// From the beginning to the end, in bounded memory; the last that may be asked for.
  [[nodiscard]] std::unique_ptr<ByteSource> read() const;

  class Stream;

 private:
  std::shared_ptr<Stream> stream_;
};

}  // namespace loopstone
