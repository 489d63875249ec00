#pragma once

#include <memory>

#include "devices/device_address.hpp"
#include "loopstone/devices/scanner.hpp"

namespace loopstone {

/// Throws DeviceError; StopAsked.
[[nodiscard]] std::unique_ptr<Scanner> open_scip_scanner(const DeviceAddress& address,
                                                         const ScannerOptions& options);

}  // namespace loopstone
