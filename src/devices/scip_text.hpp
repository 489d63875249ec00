#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace loopstone {

// SCIP as text: a command is a line; its reply is the same line, a status of two characters, lines
// of data, and an empty line. Each line but the first ends with a checksum of one character.
// Source: Hokuyo, "Communication Protocol Specification for SCIP2.2".

/// The checksum of a line: its sum's lower six bits + 0x30.
[[nodiscard]] char scip_checksum(std::string_view text);

/// The text of a line whose last character is its checksum; nothing when the two disagree.
[[nodiscard]] std::optional<std::string_view> checked_line(std::string_view line);

/// The number that characters of six bits each stand for, the highest first; nothing when one of
/// them is none.
[[nodiscard]] std::optional<std::uint32_t> scip_number(std::string_view characters);

/// A reply as it came, without its line ends.
struct ScipReply {
  std::string echo{};
  std::vector<std::string> lines{};  ///< the status' first

  /// Two characters; empty when its line is damaged.
  [[nodiscard]] std::string_view status() const;
};

/// Cuts what comes into replies, whatever is lost on the way: an empty line ends one, and so does
/// the first line of the next scan.
class ScipReplies {
 public:
  void add(std::string_view bytes);
  /// A line that begins a reply wherever it stands; empty: there is none.
  void expect_echo(std::string echo) { expected_ = std::move(echo); }
  /// The oldest reply that is whole. What was cut short comes as it is.
  [[nodiscard]] std::optional<ScipReply> next();

 private:
  void end_line();
  void end_reply();

  std::string expected_{};
  std::string line_{};
  ScipReply reply_{};
  std::size_t size_ = 0;  ///< of the reply so far
  std::vector<ScipReply> whole_{};
  std::size_t taken_ = 0;  ///< of whole_
};

/// The lines "KEY:value;" of a reply to VV, PP or II; nothing when one of them is damaged.
/// Such a checksum is that of what stands before the semicolon.
[[nodiscard]] std::optional<std::map<std::string, std::string>> scip_facts(const ScipReply& reply);

/// What a status means; "MD" and its like have meanings of their own.
[[nodiscard]] std::string words_of_status(std::string_view command, std::string_view status);

/// How scans are asked for.
struct ScipRequest {
  int first_step = 0;
  int last_step = 0;
  int characters = 3;  ///< of a number, 2 or 3
  bool intensities = false;
  int interval = 0;  ///< scans left out after each

  [[nodiscard]] int beams() const { return last_step - first_step + 1; }
  /// As "MD0000108001000".
  [[nodiscard]] std::string command() const;
  /// Bytes of a scan on the wire.
  [[nodiscard]] std::size_t scan_bytes() const;
};

/// A scan as the device sent it.
struct ScipScan {
  std::uint32_t stamp_ms = 0;  ///< of the device's clock, 24 bits
  std::vector<std::uint32_t> ranges{};
  std::vector<std::uint32_t> intensities{};
};

/// Nothing when the reply is no whole and sound scan of that request.
[[nodiscard]] std::optional<ScipScan> decode_scip_scan(const ScipReply& reply,
                                                       const ScipRequest& request);

/// Where a scanner's numbers end, and which of those below mean that nothing was in reach.
struct ScipRanges {
  int shortest_mm = 20;
  int longest_mm = 5600;

  /// [m], as LaserScan has it: numbers below the shortest are reasons why there is no range.
  [[nodiscard]] float range_m(std::uint32_t number) const;
};

}  // namespace loopstone
