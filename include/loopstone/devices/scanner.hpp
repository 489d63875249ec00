#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "loopstone/base/error.hpp"
#include "loopstone/sensor/laser_scan.hpp"

namespace loopstone {

/// A device is absent, lost, silent, refuses, or talks rubbish. what() reads "address: what is
/// wrong; what to do". Opening it again may help.
class DeviceError : public DataError {
 public:
  DeviceError(const std::string& address, const std::string& reason)
      : DataError({address}, reason) {}
};

/// What a scanner says about itself, and the scans that it will give.
struct ScannerFacts {
  std::string address{};
  std::string vendor{};
  std::string model{};
  std::string serial{};    ///< number
  std::string firmware{};  ///< version
  std::string mode{};      ///< how it measures and sends, in the words of its protocol
  int beams = 0;
  double angle_min_rad = 0.0;  ///< of the first beam; see LaserScan
  double angle_increment_rad = 0.0;
  double range_min_m = 0.0;
  double range_max_m = 0.0;
  double rate_hz = 0.0;  ///< scans a second
  bool intensities = false;
};

/// How a scanner is opened and read.
struct ScannerOptions {
  std::function<bool()> stop{};  ///< asked every 50 ms at most; true: whoever waits comes back
  double silence_s = 2.0;        ///< a device that sends nothing for so long is lost
  bool intensities = false;      ///< wanted, where the device has them
};

/// What did not become scans since the scanner was opened.
struct SkippedScans {
  std::int64_t broken = 0;  ///< came with a wrong checksum, cut short, or as rubbish
  std::int64_t lost = 0;    ///< never came, by the device's own clock
};

/// A laser scanner that measures. Not thread-safe. When it goes, the device is told to rest.
class Scanner {
 public:
  Scanner() = default;
  Scanner(const Scanner&) = delete;
  Scanner& operator=(const Scanner&) = delete;
  virtual ~Scanner() = default;

  [[nodiscard]] virtual const ScannerFacts& facts() const = 0;
  /// Waits for the next scan. Stamps are of this machine's clock at the first beam, and grow from
  /// scan to scan; angles, increments and the number of beams are those of the facts throughout.
  /// \return nothing when stop() said so
  /// Throws DeviceError; the scanner is of no use any more then.
  [[nodiscard]] virtual std::optional<LaserScan> next() = 0;
  [[nodiscard]] virtual SkippedScans skipped() const = 0;
};

/// Whether a text is meant as an address of a scanner: begins with "scip:" or "rplidar:".
[[nodiscard]] bool is_scanner_address(std::string_view text);

/// Opens a scanner, whatever state somebody left it in, and makes it measure.
///
///   scip://192.168.0.10:10940, scip:///dev/ttyACM0?baud=115200
///       Hokuyo, SCIP 2.0 to 2.2; the port is 10940 and the rate 115200 baud unless told
///   rplidar:///dev/ttyUSB0?baud=256000&mode=standard, rplidar://127.0.0.1:5000
///       Slamtec RPLIDAR; 115200 baud unless told. mode: standard, express, dense, or a name that
///       the device has for a mode; unless told, its fastest
///
/// \return nothing when options.stop() said so
/// Throws UsageError for what is no address; DeviceError for what does not work there.
/// Sources: Hokuyo, "Communication Protocol Specification for SCIP2.2"; Slamtec, "RPLIDAR
/// interface protocol and application notes". docs/devices.md tells more.
[[nodiscard]] std::unique_ptr<Scanner> open_scanner(const std::string& address,
                                                    const ScannerOptions& options = {});

}  // namespace loopstone
