#include "formats/zstd_unpack.hpp"

#include <zstd.h>

#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <system_error>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/base/memory_budget.hpp"
#include "loopstone/formats/log_reader.hpp"

namespace loopstone {
namespace {

constexpr std::string_view kMagic = "\x28\xB5\x2F\xFD";

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, FileCloser>;

File open_file(const std::string& path, const char* mode) {
  File file(std::fopen(path.c_str(), mode));
  if (file) return file;
  throw DataError({path}, "cannot open this file: " + std::generic_category().message(errno));
}

[[noreturn]] void fail_writing(const std::string& packed) {
  throw DataError({packed}, "cannot be unpacked into a temporary file: " +
                                std::generic_category().message(errno) +
                                " (TMPDIR names another place for it)");
}

}  // namespace

bool is_zstd(std::string_view head) { return head.starts_with(kMagic); }

struct ZstdUnpacker::State {
  ZSTD_DCtx* context = ZSTD_createDCtx();
  ~State() { ZSTD_freeDCtx(context); }
};

ZstdUnpacker::ZstdUnpacker() : state_(std::make_unique<State>()) {
  if (state_->context == nullptr) throw std::bad_alloc();
}
ZstdUnpacker::~ZstdUnpacker() = default;

void ZstdUnpacker::unpack(std::span<const char> packed, std::uint64_t most_bytes,
                          std::string& unpacked) {
  ZSTD_DCtx_reset(state_->context, ZSTD_reset_session_only);
  // A frame may claim any size: believed as far as its bytes make it likely.
  constexpr std::size_t kLikely = 16;
  constexpr std::size_t kLeast = std::size_t{1} << 16;
  unpacked.resize(std::min<std::uint64_t>(most_bytes, kLeast + kLikely * packed.size()));
  ZSTD_inBuffer input{packed.data(), packed.size(), 0};
  ZSTD_outBuffer output{unpacked.data(), unpacked.size(), 0};
  std::size_t left = 1;
  while (input.pos < input.size || left != 0) {
    const std::size_t read_before = input.pos;
    const std::size_t written_before = output.pos;
    left = ZSTD_decompressStream(state_->context, &output, &input);
    if (ZSTD_isError(left) != 0) throw std::runtime_error(ZSTD_getErrorName(left));
    if (left == 0 && input.pos == input.size) break;
    if (output.pos == output.size) {
      if (unpacked.size() >= most_bytes) {
        throw std::runtime_error("unpacked it is larger than " + bytes_text(most_bytes));
      }
      unpacked.resize(std::min<std::uint64_t>(most_bytes, 2 * unpacked.size()));
      output.dst = unpacked.data();
      output.size = unpacked.size();
    } else if (input.pos == read_before && output.pos == written_before) {
      throw std::runtime_error("it ends early");
    }
  }
  unpacked.resize(output.pos);
}

UnpackedFile unpack_zstd_file(const std::string& packed, const std::string& unpacked,
                              std::uint64_t most_bytes, const std::function<bool()>& stop) {
  const File source = open_file(packed, "rb");
  File target = open_file(unpacked, "wb");
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(),
                                                                     &ZSTD_freeDCtx);
  if (!context) throw std::bad_alloc();
  std::vector<char> in(ZSTD_DStreamInSize());
  std::vector<char> out(ZSTD_DStreamOutSize());
  UnpackedFile result;
  std::size_t left = 1;
  while (result.damage.empty()) {
    if (stop && stop()) throw ReadingStopped();
    const std::size_t count = std::fread(in.data(), 1, in.size(), source.get());
    if (count == 0) {
      if (std::ferror(source.get()) != 0) result.damage = "it can't be read any further";
      if (left != 0 && result.damage.empty()) result.damage = "it ends early";
      break;
    }
    ZSTD_inBuffer input{in.data(), count, 0};
    bool is_full = false;  // more may come out without more going in
    while ((input.pos < input.size || is_full) && result.damage.empty()) {
      ZSTD_outBuffer output{out.data(), out.size(), 0};
      left = ZSTD_decompressStream(context.get(), &output, &input);
      if (ZSTD_isError(left) != 0) {
        result.damage = "it is damaged (" + std::string(ZSTD_getErrorName(left)) + ")";
      }
      is_full = left != 0 && output.pos == output.size;
      result.bytes += output.pos;
      if (result.bytes > most_bytes) {
        throw DataError({packed}, "becomes more than " + bytes_text(most_bytes) +
                                      " when it is unpacked, which is more than there is room for");
      }
      if (std::fwrite(out.data(), 1, output.pos, target.get()) != output.pos) fail_writing(packed);
    }
  }
  if (std::fclose(target.release()) != 0) fail_writing(packed);
  return result;
}

}  // namespace loopstone
