#pragma once

#include <string_view>

#include "formats/npy.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {

/// The dictionary inside the head of a .npy file. Throws DataError at `where`.
[[nodiscard]] NpyHeader parse_npy_dict(std::string_view text, const Location& where);

}  // namespace loopstone
