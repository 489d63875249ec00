#include "devices/device_address.hpp"

#include <charconv>
#include <optional>
#include <string_view>

#include "loopstone/base/error.hpp"
#include "loopstone/devices/scanner.hpp"

namespace loopstone {
namespace {

constexpr std::string_view kScip = "scip:";
constexpr std::string_view kRplidar = "rplidar:";
constexpr std::uint16_t kScipPort = 10940;

[[noreturn]] void refuse(const std::string& text, const std::string& reason) {
  throw UsageError(text + ": " + reason +
                   "; an address reads scip://192.168.0.10:10940, scip:///dev/ttyACM0?baud=115200 "
                   "or rplidar:///dev/ttyUSB0?baud=115200");
}

std::optional<int> whole_number(std::string_view digits) {
  int number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error != std::errc{} || end != digits.data() + digits.size()) return {};
  return number;
}

/// "host", "host:port", "[v6]", "[v6]:port".
void read_host(std::string_view place, DeviceAddress& address) {
  const bool bracketed = place.starts_with('[');
  const auto end = bracketed ? place.find(']') : place.rfind(':');
  if (bracketed && end == std::string_view::npos) refuse(address.text, "the bracket stays open");
  address.host = bracketed ? place.substr(1, end - 1) : place.substr(0, end);
  const std::string_view rest =
      end == std::string_view::npos ? "" : place.substr(end + (bracketed ? 1 : 0));
  if (address.host.empty()) refuse(address.text, "names neither a host nor a serial port");
  if (rest.empty()) {
    if (address.protocol == DeviceProtocol::kRplidar)
      refuse(address.text, "has no port, and RPLIDARs have no usual one");
    address.port = kScipPort;
    return;
  }
  const auto port = rest.starts_with(':') ? whole_number(rest.substr(1)) : std::nullopt;
  if (!port || *port < 1 || *port > 65535) refuse(address.text, "the port is no number to 65535");
  address.port = static_cast<std::uint16_t>(*port);
}

void read_parameter(std::string_view parameter, DeviceAddress& address) {
  const auto equals = parameter.find('=');
  const std::string_view key = parameter.substr(0, equals);
  const std::string_view value =
      equals == std::string_view::npos ? "" : parameter.substr(equals + 1);
  if (key == "baud" && address.is_serial()) {
    constexpr int kSlowest = 300;
    constexpr int kFastest = 12'000'000;
    const auto baud = whole_number(value);
    if (!baud || *baud < kSlowest || *baud > kFastest) refuse(address.text, "baud is no rate");
    address.baud = *baud;
  } else if (key == "mode" && address.protocol == DeviceProtocol::kRplidar && !value.empty()) {
    address.mode = value;
  } else {
    refuse(address.text, "'" + std::string(parameter) + "' means nothing here");
  }
}

}  // namespace

bool is_scanner_address(std::string_view text) {
  return text.starts_with(kScip) || text.starts_with(kRplidar);
}

DeviceAddress parse_device_address(const std::string& text) {
  DeviceAddress address{.text = text};
  if (!is_scanner_address(text)) refuse(text, "is no scanner's address");
  const bool scip = text.starts_with(kScip);
  address.protocol = scip ? DeviceProtocol::kScip : DeviceProtocol::kRplidar;
  std::string_view rest = std::string_view(text).substr(scip ? kScip.size() : kRplidar.size());
  if (!rest.starts_with("//")) refuse(text, "lacks // before the place");
  rest.remove_prefix(2);
  const auto question = rest.find('?');
  const std::string_view place = rest.substr(0, question);
  if (place.starts_with('/')) {
    address.path = place;
  } else {
    read_host(place, address);
  }
  if (question == std::string_view::npos) return address;
  rest.remove_prefix(question + 1);
  while (!rest.empty()) {
    const auto end = rest.find('&');
    read_parameter(rest.substr(0, end), address);
    rest = end == std::string_view::npos ? "" : rest.substr(end + 1);
  }
  return address;
}

}  // namespace loopstone
