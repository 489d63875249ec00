#include "support/recording_damage.hpp"

#include <algorithm>
#include <map>
#include <random>

namespace loopstone::test {

DamagedRecording damaged(const BuiltRecording& recording, std::size_t messages,
                         std::uint64_t seed) {
  std::mt19937_64 random(seed);
  DamagedRecording result{recording.bytes, std::vector<bool>(messages, true), {}};
  std::string& bytes = result.bytes;
  constexpr std::size_t kMagic = 13;  // which both need at the front
  const std::size_t at = kMagic + random() % (bytes.size() - kMagic);
  std::size_t end = at;  // of what is spoiled, in the sound recording
  switch (random() % 5) {
    case 0:
      result.what = "a bit";
      bytes[at] = static_cast<char>(bytes[at] ^ (1 << random() % 8));
      end = at + 1;
      break;
    case 1:
      result.what = "cut";
      bytes.resize(at);
      end = recording.bytes.size();
      break;
    case 2: {
      result.what = "junk inserted";
      std::string junk(1 + random() % 200, '\0');
      for (char& c : junk) c = static_cast<char>(random() & 0xffU);
      bytes.insert(at, junk);
      break;
    }
    case 3:
      result.what = "zeroes";
      end = std::min(bytes.size(), at + 1 + random() % 400);
      std::fill(bytes.begin() + static_cast<long>(at), bytes.begin() + static_cast<long>(end), 0);
      break;
    default:
      result.what = "a piece is missing";
      end = std::min(bytes.size(), at + 1 + random() % 400);
      bytes.erase(at, end - at);
      break;
  }
  result.what += " at " + std::to_string(at) + " to " + std::to_string(end);
  for (const auto& part : recording.parts) {
    const bool is_hit =
        end > at ? part.begin < end && at < part.end : part.begin < at && at < part.end;
    for (std::size_t i = 0; is_hit && i < part.messages; ++i) {
      result.is_whole[part.first + i] = false;
    }
  }
  return result;
}

std::vector<bool> found_in(Recording& recording, const std::vector<BuiltMessage>& messages) {
  std::map<std::pair<Stamp, std::string>, std::size_t> wanted;
  for (std::size_t i = 0; i < messages.size(); ++i) {
    wanted.emplace(std::pair{messages[i].recorded, messages[i].bytes}, i);
  }
  std::vector<bool> found(messages.size(), false);
  for (const BuiltMessage& message : messages_of(recording)) {
    const auto one = wanted.find({message.recorded, message.bytes});
    if (one != wanted.end()) found[one->second] = true;
  }
  return found;
}

}  // namespace loopstone::test
