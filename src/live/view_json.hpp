#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "loopstone/live/view_contents.hpp"

// The messages of our own that are JSON, and their schemas.

namespace loopstone {

[[nodiscard]] std::string status_json(const ViewStatus& status);
/// Those of the list that are to be told. \param places  theirs
[[nodiscard]] std::string closures_json(std::span<const ViewClosure> closures,
                                        std::span<const std::size_t> places);
[[nodiscard]] std::string submaps_json(std::span<const ViewSubmap> submaps,
                                       std::span<const std::size_t> places);
[[nodiscard]] std::string verdict_json(const ViewVerdict& verdict);
[[nodiscard]] std::string warnings_json(std::span<const ViewWarning> warnings);
[[nodiscard]] std::string layer_json(const ViewLayer& layer);
/// By what a closure was measured: both scans, and where it puts them.
/// \param id  of the closure
[[nodiscard]] std::string evidence_json(std::size_t id, const ViewClosure& closure);

/// JSON schemas of these messages.
[[nodiscard]] std::string status_schema();
[[nodiscard]] std::string closures_schema();
[[nodiscard]] std::string submaps_schema();
[[nodiscard]] std::string verdict_schema();
[[nodiscard]] std::string warnings_schema();
[[nodiscard]] std::string layer_schema();

}  // namespace loopstone
