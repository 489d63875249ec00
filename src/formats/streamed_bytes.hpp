#pragma once

#include <memory>
#include <optional>
#include <string>

#include "formats/byte_source.hpp"
#include "formats/byte_stream.hpp"

namespace loopstone {

/// What comes out of a stream, which can't be read twice: while it is looked at, it is kept for the
/// next who begins at its beginning.
class StreamedBytes {
 public:
  /// \param look_s  so long after the first byte whoever looks is told that there are no more, for
  ///                the stream may never end; nothing: the end alone is the end
  explicit StreamedBytes(std::unique_ptr<ByteStream> stream, std::optional<double> look_s = {});

  /// For messages.
  [[nodiscard]] const std::string& name() const;
  /// From the beginning; what is read is kept.
  [[nodiscard]] std::unique_ptr<ByteSource> look() const;
  /// From the beginning to the end, in bounded memory; the last that may be asked for.
  [[nodiscard]] std::unique_ptr<ByteSource> read() const;

  class Kept;

 private:
  std::shared_ptr<Kept> kept_;
};

}  // namespace loopstone
