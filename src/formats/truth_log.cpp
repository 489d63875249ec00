#include "loopstone/formats/truth_log.hpp"

#include <vector>

#include "loopstone/formats/log_format.hpp"
#include "loopstone/formats/log_format_words.hpp"

namespace loopstone {
namespace {

[[noreturn]] void refuse_format(const LogInput& log, const LogFormat& format) {
  std::vector<std::string> nouns;
  for (const LogFormat& other : log_formats()) {
    if (other.truth != nullptr) nouns.emplace_back(other.noun);
  }
  throw DataError({log.name}, "is " + std::string(format.noun) +
                                  ", which holds no true poses; they can be in " +
                                  listed(nouns, "or"));
}

}  // namespace

Trajectory read_truth(const std::string& log_path, const std::string& topic,
                      const LogOptions& options) {
  const LogInput log = look_at_log(log_path, options.stop);
  const LogFormat& format = recognise_log(log);
  if (format.truth == nullptr) refuse_format(log, format);
  return format.truth(log, topic, options);
}

}  // namespace loopstone
