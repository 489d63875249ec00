#include "formats/range_file.hpp"

#include <cassert>
#include <cstdio>

#include "formats/npy.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

// Any head of two dimensions fits: numpy's padding makes it exactly this long.
constexpr std::size_t kHeadBytes = 128;

std::string head_of(std::int64_t beams, std::int64_t scans) {
  const std::int64_t shape[] = {beams, scans};
  std::string head = npy_head("<f4", true, shape);
  assert(head.size() == kHeadBytes);
  return head;
}

}  // namespace

RangeFile::RangeFile(const std::string& path, std::int64_t beams) : file_(path), beams_(beams) {
  file_.write(head_of(beams, 0));
}

void RangeFile::append(std::span<const float> ranges_m) {
  file_.write({reinterpret_cast<const char*>(ranges_m.data()), ranges_m.size_bytes()});
  ++scans_;
}

std::string RangeFile::finish() {
  file_.finish_writing();
  std::FILE* const file = std::fopen(file_.temporary_path().c_str(), "r+b");
  const std::string head = head_of(beams_, scans_);
  const bool written =
      file != nullptr && std::fwrite(head.data(), 1, head.size(), file) == head.size();
  if ((file != nullptr && std::fclose(file) != 0) || !written) {
    throw DataError({file_.path()}, "cannot write to this file");
  }
  return file_.temporary_path();
}

}  // namespace loopstone
