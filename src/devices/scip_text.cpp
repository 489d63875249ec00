#include "devices/scip_text.hpp"

#include <fmt/format.h>

#include <limits>
#include <numeric>

namespace loopstone {
namespace {

constexpr unsigned kSixBits = 0x3F;
constexpr char kZero = 0x30;
constexpr std::size_t kLineLength = 64;
/// A reply is never longer: 3000 beams with intensities.
constexpr std::size_t kLongestReply = 32768;

/// The text before a checksum and a semicolon.
std::optional<std::string_view> checked_fact(std::string_view line) {
  if (line.size() < 2 || line[line.size() - 2] != ';') return {};
  const std::string_view text = line.substr(0, line.size() - 2);
  if (scip_checksum(text) != line.back()) return {};
  return text;
}

std::string_view words_of_scan_status(std::string_view status) {
  if (status == "01") return "the first step is no number";
  if (status == "02") return "the last step is no number";
  if (status == "03") return "the cluster count is no number";
  if (status == "04") return "the last step is out of range";
  if (status == "05") return "the last step lies before the first";
  if (status == "06") return "the scan interval is no number";
  if (status == "07") return "the number of scans is no number";
  if (status == "10") return "the laser is off";
  if (status == "98") return "it measures again after a check of itself";
  if (status >= "21" && status <= "49") return "it has stopped measuring to check itself";
  if (status >= "50" && status <= "97")
    return "its laser, motor or another part has failed; switch it off and on";
  return "a status that SCIP does not explain";
}

bool is_scan_command(std::string_view command) {
  return command.size() > 2 &&
         (command.starts_with("MD") || command.starts_with("MS") || command.starts_with("ME"));
}

}  // namespace

char scip_checksum(std::string_view text) {
  unsigned sum = 0;
  for (const char c : text) sum += static_cast<unsigned char>(c);
  return static_cast<char>((sum & kSixBits) + static_cast<unsigned>(kZero));
}

std::optional<std::string_view> checked_line(std::string_view line) {
  if (line.size() < 2) return {};
  const std::string_view text = line.substr(0, line.size() - 1);
  if (scip_checksum(text) != line.back()) return {};
  return text;
}

std::optional<std::uint32_t> scip_number(std::string_view characters) {
  std::uint32_t number = 0;
  for (const char c : characters) {
    if (c < kZero || c > kZero + static_cast<char>(kSixBits)) return {};
    number = number << 6U | static_cast<std::uint32_t>(c - kZero);
  }
  return number;
}

std::string_view ScipReply::status() const {
  const auto text = lines.empty() ? std::nullopt : checked_line(lines.front());
  return text && text->size() == 2 ? *text : std::string_view{};
}

void ScipReplies::add(std::string_view bytes) {
  for (const char c : bytes) {
    if (c == '\n') {
      end_line();
    } else if (c != '\r') {
      line_ += c;
      ++size_;
    }
    // Noise without an end, from a line at another rate.
    if (size_ > kLongestReply) end_reply();
  }
}

void ScipReplies::end_line() {
  const bool begins = !expected_.empty() && line_ == expected_;
  if (line_.empty() || (begins && !reply_.echo.empty())) {
    std::string kept;
    kept.swap(line_);
    end_reply();
    line_.swap(kept);
  }
  if (line_.empty()) return;
  if (reply_.echo.empty()) {
    reply_.echo.swap(line_);
  } else {
    reply_.lines.push_back(line_);
  }
  line_.clear();
}

void ScipReplies::end_reply() {
  if (!reply_.echo.empty() || !line_.empty()) {
    if (reply_.echo.empty()) reply_.echo.swap(line_);
    whole_.push_back(std::move(reply_));
  }
  reply_ = {};
  line_.clear();
  size_ = 0;
}

std::optional<ScipReply> ScipReplies::next() {
  if (taken_ == whole_.size()) {
    whole_.clear();
    taken_ = 0;
    return {};
  }
  return std::move(whole_[taken_++]);
}

std::optional<std::map<std::string, std::string>> scip_facts(const ScipReply& reply) {
  std::map<std::string, std::string> facts;
  for (std::size_t i = 1; i < reply.lines.size(); ++i) {
    const auto text = checked_fact(reply.lines[i]);
    if (!text) return {};
    const auto colon = text->find(':');
    if (colon != std::string_view::npos)
      facts.emplace(text->substr(0, colon), text->substr(colon + 1));
  }
  return facts;
}

std::string words_of_status(std::string_view command, std::string_view status) {
  std::string_view words = "a status that SCIP does not explain";
  if (status == "0A") {
    words = "it can't make the reply";
  } else if (status == "0B") {
    words = "its buffer is full, or the command came twice";
  } else if (status == "0C" || status == "0D") {
    words = "the command lacks parameters";
  } else if (status == "0E") {
    words = "it does not know the command";
  } else if (status == "0F") {
    words = "the command is out of place";
  } else if (is_scan_command(command)) {
    words = words_of_scan_status(status);
  } else if (command == "BM" && status == "01") {
    words = "its laser has failed; switch it off and on";
  } else if (command == "BM" && status == "02") {
    words = "its laser is on already";
  } else if (command.starts_with("TM")) {
    words = "its clock can't be asked now";
  }
  return fmt::format("status {}: {}", status.empty() ? "damaged" : status, words);
}

std::string ScipRequest::command() const {
  const char* name = intensities ? "ME" : characters == 2 ? "MS" : "MD";
  return fmt::format("{}{:04}{:04}01{}00", name, first_step, last_step, interval);
}

std::size_t ScipRequest::scan_bytes() const {
  constexpr std::size_t kHead = 16 + 4 + 6 + 1;  // echo, status, stamp, the empty line
  const auto data = static_cast<std::size_t>(beams()) * static_cast<std::size_t>(characters) *
                    (intensities ? 2 : 1);
  return kHead + data + 2 * ((data + kLineLength - 1) / kLineLength);
}

std::optional<ScipScan> decode_scip_scan(const ScipReply& reply, const ScipRequest& request) {
  constexpr std::size_t kBeforeData = 2;
  if (reply.status() != "99" || reply.lines.size() <= kBeforeData) return {};
  const auto stamp = checked_line(reply.lines[1]);
  if (!stamp || stamp->size() != 4) return {};
  const auto stamp_ms = scip_number(*stamp);
  if (!stamp_ms) return {};
  std::string data;
  for (std::size_t i = kBeforeData; i < reply.lines.size(); ++i) {
    const auto text = checked_line(reply.lines[i]);
    const bool is_last = i + 1 == reply.lines.size();
    if (!text || (is_last ? text->size() > kLineLength : text->size() != kLineLength)) return {};
    data += *text;
  }
  const auto width = static_cast<std::size_t>(request.characters);
  const std::size_t values = request.intensities ? 2 : 1;
  const auto beams = static_cast<std::size_t>(request.beams());
  if (data.size() != beams * values * width) return {};
  ScipScan scan{.stamp_ms = *stamp_ms};
  for (std::size_t i = 0; i < beams * values; ++i) {
    const auto number = scip_number(std::string_view(data).substr(i * width, width));
    if (!number) return {};
    (i % values == 0 ? scan.ranges : scan.intensities).push_back(*number);
  }
  return scan;
}

// The numbers below DMIN, by the makers' tables: of the UTM and UST series 1 is nothing within
// range, 2 too near, 3 a failed measurement, 4 out of range at the near end, 5 another error
// (UTM-30LX, SCIP2.0, table 4); of the URG-04LX 0 is something at 22 m and 6 at 5.7 m, beyond its
// reach, 1 to 5 too little light, the rest errors.
float ScipRanges::range_m(std::uint32_t number) const {
  constexpr int kLongestOfUrg_mm = 6000;
  if (number > static_cast<std::uint32_t>(longest_mm))
    return std::numeric_limits<float>::infinity();
  if (number >= static_cast<std::uint32_t>(shortest_mm))
    return static_cast<float>(static_cast<double>(number) / 1000.0);
  const bool is_urg = longest_mm < kLongestOfUrg_mm;
  const bool is_nothing = is_urg ? number == 0 || number == 6 : number == 1;
  return is_nothing ? std::numeric_limits<float>::infinity()
                    : std::numeric_limits<float>::quiet_NaN();
}

}  // namespace loopstone
