// libnetpbm (https://netpbm.sourceforge.net) on grey and coloured pictures: all samples, as ours
// reads them, and what ../reader_trials.hpp tells.

extern "C" {
#include <netpbm/pam.h>
}

#include <csetjmp>

#include "../reader_trials.hpp"

namespace {

using namespace loopstone::bench;

void keep_quiet(const char*) {}

/// Everything that the library's jump out of an error must leave behind.
struct Reading {
  FILE* file = nullptr;
  std::jmp_buf on_error{};
  pam head{};
  tuple* row = nullptr;
  std::vector<std::uint16_t> samples{};

  explicit Reading(const std::string& path) : file(std::fopen(path.c_str(), "rb")) {}
  Reading(const Reading&) = delete;
  Reading& operator=(const Reading&) = delete;
  ~Reading() {
    pm_setjmpbuf(nullptr);
    if (row != nullptr) pm_freerow(row);
    if (file != nullptr) std::fclose(file);
  }
};

/// False after an error.
bool read_head(Reading& reading) {
  if (setjmp(reading.on_error) != 0) return false;
  pm_setjmpbuf(&reading.on_error);
  pnm_readpaminit(reading.file, &reading.head, PAM_STRUCT_SIZE(tuple_type));
  return true;
}

bool read_rows(Reading& reading) {
  if (setjmp(reading.on_error) != 0) return false;
  pm_setjmpbuf(&reading.on_error);
  const pam& head = reading.head;
  reading.row = pnm_allocpamrow(&head);
  std::uint16_t* to = reading.samples.data();
  for (int row = 0; row < head.height; ++row) {
    pnm_readpamrow(&head, reading.row);
    for (int column = 0; column < head.width; ++column) {
      for (unsigned plane = 0; plane < head.depth; ++plane) {
        *to++ = static_cast<std::uint16_t>(reading.row[column][plane]);
      }
    }
  }
  return true;
}

void read_pnm(const std::string& path, ValueDigest* digest) {
  Reading reading(path);
  if (reading.file == nullptr || !read_head(reading)) throw std::runtime_error("has no head");
  const pam& head = reading.head;
  const std::uint64_t row_samples = std::uint64_t{head.depth} * static_cast<unsigned>(head.width);
  require_value_bytes(row_samples, 2);
  require_value_bytes(row_samples * static_cast<unsigned>(head.height), 2);
  reading.samples.resize(row_samples * static_cast<unsigned>(head.height));
  if (!read_rows(reading)) throw std::runtime_error("has broken rows");
  if (digest == nullptr) return;
  digest->add_sizes("", static_cast<std::size_t>(head.height),
                    static_cast<std::size_t>(head.width));
  digest->add_all(reading.samples);
}

}  // namespace

int main(int argc, char** argv) {
  pm_init("netpbm_files", 0);
  pm_setusermessagefn(keep_quiet);
  pm_setusererrormsgfn(keep_quiet);
  return reader_main(argc, argv, {{".pnm", read_pnm}});
}
