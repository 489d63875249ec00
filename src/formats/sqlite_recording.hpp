#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "formats/recording.hpp"

namespace loopstone {

/// What is known of a database before it is opened.
struct SqliteLog {
  std::string path{};
  std::string name{};  ///< for messages; of a packed file its own, not that of what was unpacked
  std::int64_t stored_bytes = 0;
  /// Every message is packed by this, as metadata.yaml says ("zstd"); empty: by nothing.
  std::string packing{};
};

/// One database of rosbag2. It is never changed, and nothing is made beside it: with a log of
/// writes or a journal that its recorder left (-wal, -journal) both are copied first. Messages come
/// by their times when the database has an index of these, otherwise as they were recorded. Of a
/// damaged database everything is given that can be reached.
/// Throws DataError when nothing in it can be read, ReadingStopped.
[[nodiscard]] std::unique_ptr<Recording> open_sqlite_log(const SqliteLog& log,
                                                         const RecordingOptions& options);

}  // namespace loopstone
