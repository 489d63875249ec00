#pragma once

#include <memory>
#include <optional>

#include "formats/byte_source.hpp"
#include "formats/recording.hpp"
#include "formats/streamed_recording.hpp"

namespace loopstone {

/// MCAP that comes as a stream: records are read as they come, chunks when they are whole. There is
/// no way past damage.
/// \param name    for messages
/// \param look_s  so long after the first message, once a laser's was among them, next() says that
///                there are no more, until the survey is over; nothing: the end alone is the end
/// Throws DataError when it does not begin as MCAP does.
[[nodiscard]] std::unique_ptr<StreamedRecording> stream_mcap(std::unique_ptr<ByteSource> bytes,
                                                             const std::string& name,
                                                             const RecordingOptions& options,
                                                             std::optional<double> look_s);

}  // namespace loopstone
