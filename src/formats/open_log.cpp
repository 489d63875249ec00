#include "loopstone/formats/log_format.hpp"
#include "loopstone/formats/log_format_words.hpp"
#include "loopstone/formats/log_reader.hpp"

namespace loopstone {
namespace {

[[noreturn]] void refuse_stream(const LogInput& log, const LogFormat& format) {
  std::vector<std::string> nouns;
  for (const LogFormat& other : log_formats()) {
    if (other.reads_streams) nouns.emplace_back(other.noun);
  }
  throw DataError({log.name}, "is " + std::string(format.file_is) + "; a pipe can only hold " +
                                  listed(nouns, "or"));
}

}  // namespace

std::unique_ptr<LogReader> open_log(const LogInput& log, const LogFormat& format,
                                    const LogOptions& options) {
  if (format.recognise(log) == Recognition::kNo) {
    throw DataError({log.name}, "is not " + std::string(format.noun));
  }
  if (log.set && !format.has_sets) {
    throw UsageError(log.name + "#" + std::to_string(*log.set) + ": is " +
                     std::string(format.noun) + ", which has no sets");
  }
  if (log.is_stream && !format.reads_streams) refuse_stream(log, format);
  return format.open(log, options);
}

std::unique_ptr<LogReader> open_log(const std::string& path, const LogOptions& options) {
  const LogInput log = look_at_log(path, options.stop);
  return open_log(log, recognise_log(log), options);
}

}  // namespace loopstone
