#include "loopstone/formats/text_file.hpp"

#include "formats/atomic_file.hpp"

namespace loopstone {

void write_text_file(const std::string& path, std::string_view text) {
  write_file_atomically(path, text);
}

}  // namespace loopstone
