#pragma once

#include <nlohmann/json.hpp>

#include "loopstone/formats/left_out.hpp"

namespace loopstone {

/// Counts, shares, reasons: a part of every command's JSON.
[[nodiscard]] nlohmann::ordered_json to_json(const LeftOut& left_out);

}  // namespace loopstone
