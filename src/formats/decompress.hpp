#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "formats/byte_source.hpp"

namespace loopstone {

enum class Compression { kNone, kGzip, kBzip2 };

/// By the magic number at the front of a file.
[[nodiscard]] Compression compression_of(std::string_view first_bytes);

/// What `stored` holds; itself when it is not compressed. The name is for messages.
[[nodiscard]] std::unique_ptr<ByteSource> decompressed(std::unique_ptr<ByteSource> stored,
                                                       Compression kind, const std::string& name);

}  // namespace loopstone
