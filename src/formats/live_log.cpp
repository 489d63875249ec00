#include "loopstone/formats/live_log.hpp"

#include <filesystem>
#include <optional>
#include <utility>

#include "formats/byte_source.hpp"
#include "formats/byte_stream.hpp"
#include "formats/log_head.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/log_format.hpp"

namespace loopstone {
namespace {

namespace fs = std::filesystem;

std::unique_ptr<ByteStream> connect(const std::string& source, std::function<bool()> stop) {
  const std::string place = source.substr(kTcpScheme.size());
  const std::size_t colon = place.rfind(':');
  std::string host = place.substr(0, colon);
  const std::string port = colon == std::string::npos ? "" : place.substr(colon + 1);
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  const bool is_number = !port.empty() && port.size() <= 5 &&
                         port.find_first_not_of("0123456789") == std::string::npos;
  if (host.empty() || !is_number || std::stoi(port) > 65535)
    throw UsageError(source + ": a connection is named tcp://HOST:PORT");
  return connect_tcp(host, port, std::move(stop));
}

std::unique_ptr<ByteStream> open_stream(const std::string& source, std::function<bool()> stop) {
  if (source.starts_with(kTcpScheme)) return connect(source, std::move(stop));
  if (source == kStandardInput) return open_pipe(source, std::move(stop));
  std::error_code error;
  const fs::file_status status = fs::status(source, error);
  if (!fs::exists(status)) throw DataError({source}, "there is no such file or pipe");
  if (fs::is_directory(status))
    throw DataError({source}, "is a folder; what is read live is a file, a pipe or a connection");
  return fs::is_regular_file(status) ? follow_file(source, std::move(stop))
                                     : open_pipe(source, std::move(stop), true);
}

}  // namespace

std::unique_ptr<LogReader> open_live_log(const std::string& source, const LogOptions& options) {
  LogOptions how = options;
  if (!how.live) how.live.emplace();
  auto content = std::make_shared<ReadableBytes>(
      readable_stream(open_stream(source, how.stop), how.live->look_s));
  LogInput log{.name = content->name, .path = source, .is_stream = true, .content = content};
  log.head = head_of(*content);
  if (log.head.empty()) throw DataError({log.name}, "ended before anything came");
  return open_log(log, recognise_log(log), how);
}

}  // namespace loopstone
