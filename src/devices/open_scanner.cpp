#include "devices/device_address.hpp"
#include "devices/rplidar_scanner.hpp"
#include "devices/scip_scanner.hpp"
#include "devices/wire.hpp"
#include "loopstone/devices/scanner.hpp"

namespace loopstone {

std::unique_ptr<Scanner> open_scanner(const std::string& address, const ScannerOptions& options) {
  const DeviceAddress place = parse_device_address(address);
  try {
    return place.protocol == DeviceProtocol::kScip ? open_scip_scanner(place, options)
                                                   : open_rplidar_scanner(place, options);
  } catch (const StopAsked&) {
    return {};
  }
}

}  // namespace loopstone
