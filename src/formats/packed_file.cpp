#include "formats/packed_file.hpp"

#include <bzlib.h>
#include <zlib.h>

#include <array>

namespace loopstone {

struct PackedFile::Packer {
  virtual ~Packer() = default;
  virtual void pack(std::string_view text, bool last, AtomicFile& file) = 0;
};

struct PackedFile::Gzip final : Packer {
  Gzip() {
    deflateInit2(&stream, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY);  // + 16: gzip header
  }
  ~Gzip() override { deflateEnd(&stream); }
  Gzip(const Gzip&) = delete;
  Gzip& operator=(const Gzip&) = delete;

  void pack(std::string_view text, bool last, AtomicFile& file) override {
    std::array<char, 1 << 16> block;
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
    stream.avail_in = static_cast<uInt>(text.size());
    do {
      stream.next_out = reinterpret_cast<Bytef*>(block.data());
      stream.avail_out = static_cast<uInt>(block.size());
      deflate(&stream, last ? Z_FINISH : Z_NO_FLUSH);
      file.write({block.data(), block.size() - stream.avail_out});
    } while (stream.avail_out == 0);
  }

  z_stream stream{};
};

struct PackedFile::Bzip2 final : Packer {
  Bzip2() { BZ2_bzCompressInit(&stream, 9, 0, 0); }
  ~Bzip2() override { BZ2_bzCompressEnd(&stream); }
  Bzip2(const Bzip2&) = delete;
  Bzip2& operator=(const Bzip2&) = delete;

  void pack(std::string_view text, bool last, AtomicFile& file) override {
    std::array<char, 1 << 16> block;
    stream.next_in = const_cast<char*>(text.data());
    stream.avail_in = static_cast<unsigned>(text.size());
    int status = BZ_OK;
    do {
      stream.next_out = block.data();
      stream.avail_out = static_cast<unsigned>(block.size());
      status = BZ2_bzCompress(&stream, last ? BZ_FINISH : BZ_RUN);
      file.write({block.data(), block.size() - stream.avail_out});
    } while (last ? status == BZ_FINISH_OK : stream.avail_in > 0);
  }

  bz_stream stream{};
};

PackedFile::PackedFile(const std::string& path) : file_(path) {
  if (path.ends_with(".gz")) packer_ = std::make_unique<Gzip>();
  if (path.ends_with(".bz2")) packer_ = std::make_unique<Bzip2>();
}

PackedFile::~PackedFile() = default;

void PackedFile::write(std::string_view text) {
  if (text.empty()) return;
  if (packer_) {
    packer_->pack(text, false, file_);
  } else {
    file_.write(text);
  }
}

void PackedFile::commit() {
  if (packer_) packer_->pack({}, true, file_);
  file_.commit();
}

}  // namespace loopstone
