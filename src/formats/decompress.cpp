#include "formats/decompress.hpp"

#include <bzlib.h>
#include <zlib.h>

#include <string>
#include <utility>
#include <vector>

#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

constexpr std::size_t kBlockBytes = std::size_t{1} << 16;

/// What both decompressors share: a block of stored bytes, and the position for error messages.
class StoredBlock {
 public:
  StoredBlock(std::unique_ptr<ByteSource> stored, std::string path)
      : stored_(std::move(stored)), path_(std::move(path)), block_(kBlockBytes) {}

  /// The next block, empty at the end of the stored file.
  std::span<char> next() { return {block_.data(), stored_->read(block_)}; }
  std::int64_t bytes_done() const { return stored_->bytes_done(); }
  std::int64_t bytes_total() const { return stored_->bytes_total(); }
  [[noreturn]] void fail(std::size_t unread, const std::string& reason) const {
    throw DataError({path_, {}, stored_->bytes_done() - static_cast<std::int64_t>(unread)}, reason);
  }

 private:
  std::unique_ptr<ByteSource> stored_;
  std::string path_;
  std::vector<char> block_;
};

/// A log of text becomes a tenth of its size, a robot that stood for hours a hundredth. What
/// unpacks to far more is there to fill somebody's disk and time.
constexpr std::int64_t kAlwaysBytes = std::int64_t{1} << 26;
constexpr std::int64_t kMostGrowth = 500;

class Unpacked {
 public:
  void add(std::size_t bytes, const StoredBlock& block) {
    bytes_ += static_cast<std::int64_t>(bytes);
    if (bytes_ <= kAlwaysBytes || bytes_ / kMostGrowth <= block.bytes_done()) return;
    block.fail(0, "unpacks to more than " + std::to_string(kMostGrowth) +
                      " times its size, which no recording does; unpack it by hand if it is one");
  }

 private:
  std::int64_t bytes_ = 0;
};

class GzipSource final : public ByteSource {
 public:
  GzipSource(std::unique_ptr<ByteSource> stored, std::string path)
      : block_(std::move(stored), std::move(path)) {
    inflateInit2(&stream_, 15 + 16);  // 15 bits of window, + 16: a gzip header
  }
  ~GzipSource() override { inflateEnd(&stream_); }
  GzipSource(const GzipSource&) = delete;
  GzipSource& operator=(const GzipSource&) = delete;

  std::size_t read(std::span<char> buffer) override {
    if (buffer.empty()) return 0;
    stream_.next_out = reinterpret_cast<Bytef*>(buffer.data());
    stream_.avail_out = static_cast<uInt>(buffer.size());
    while (stream_.avail_out == buffer.size() && !finished_) {
      if (stream_.avail_in == 0) refill();
      if (finished_) break;
      const int status = inflate(&stream_, Z_NO_FLUSH);
      if (status == Z_STREAM_END) {
        member_open_ = false;  // another member may follow
        inflateReset(&stream_);
      } else if (status != Z_OK && status != Z_BUF_ERROR) {
        // Padding after the last member is common (tapes, block devices) and harmless.
        if (!member_open_ && members_ > 1) {
          finished_ = true;
          break;
        }
        block_.fail(stream_.avail_in, "the gzip data is damaged");
      }
      if (!member_open_ && stream_.avail_in > 0) start_member();
    }
    const std::size_t count = buffer.size() - stream_.avail_out;
    unpacked_.add(count, block_);
    return count;
  }
  std::int64_t bytes_done() const override { return block_.bytes_done(); }
  std::int64_t bytes_total() const override { return block_.bytes_total(); }

 private:
  void start_member() {
    member_open_ = stream_.next_in[0] == 0x1f;
    if (member_open_) ++members_;
    if (!member_open_) finished_ = true;
  }
  void refill() {
    const auto block = block_.next();
    stream_.next_in = reinterpret_cast<Bytef*>(block.data());
    stream_.avail_in = static_cast<uInt>(block.size());
    if (block.empty()) {
      if (member_open_) block_.fail(0, "the gzip file ends too early: it was cut off");
      finished_ = true;
    } else if (!member_open_) {
      start_member();
    }
  }

  StoredBlock block_;
  Unpacked unpacked_{};
  z_stream stream_{};
  bool member_open_ = false;
  bool finished_ = false;
  int members_ = 0;
};

class Bzip2Source final : public ByteSource {
 public:
  Bzip2Source(std::unique_ptr<ByteSource> stored, std::string path)
      : block_(std::move(stored), std::move(path)) {
    BZ2_bzDecompressInit(&stream_, 0, 0);
  }
  ~Bzip2Source() override { BZ2_bzDecompressEnd(&stream_); }
  Bzip2Source(const Bzip2Source&) = delete;
  Bzip2Source& operator=(const Bzip2Source&) = delete;

  std::size_t read(std::span<char> buffer) override {
    if (buffer.empty()) return 0;
    stream_.next_out = buffer.data();
    stream_.avail_out = static_cast<unsigned>(buffer.size());
    while (stream_.avail_out == buffer.size() && !finished_) {
      if (stream_.avail_in == 0 && !refill()) break;
      if (!member_open_) {
        if (stream_.next_in[0] != 'B') {  // padding after the last stream
          finished_ = true;
          break;
        }
        member_open_ = true;
      }
      const int status = BZ2_bzDecompress(&stream_);
      if (status == BZ_STREAM_END) {
        restart();
      } else if (status != BZ_OK) {
        block_.fail(stream_.avail_in, "the bzip2 data is damaged");
      }
    }
    const std::size_t count = buffer.size() - stream_.avail_out;
    unpacked_.add(count, block_);
    return count;
  }
  std::int64_t bytes_done() const override { return block_.bytes_done(); }
  std::int64_t bytes_total() const override { return block_.bytes_total(); }

 private:
  bool refill() {
    const auto block = block_.next();
    stream_.next_in = block.data();
    stream_.avail_in = static_cast<unsigned>(block.size());
    if (!block.empty()) return true;
    if (member_open_) block_.fail(0, "the bzip2 file ends too early: it was cut off");
    finished_ = true;
    return false;
  }
  /// bzip2 has no reset; parallel compressors write many streams one after another.
  void restart() {
    bz_stream fresh{};
    fresh.next_in = stream_.next_in;
    fresh.avail_in = stream_.avail_in;
    fresh.next_out = stream_.next_out;
    fresh.avail_out = stream_.avail_out;
    BZ2_bzDecompressEnd(&stream_);
    stream_ = fresh;
    BZ2_bzDecompressInit(&stream_, 0, 0);
    member_open_ = false;
  }

  StoredBlock block_;
  Unpacked unpacked_{};
  bz_stream stream_{};
  bool member_open_ = false;
  bool finished_ = false;
};

}  // namespace

Compression compression_of(std::string_view first_bytes) {
  if (first_bytes.starts_with("\x1f\x8b")) return Compression::kGzip;
  if (first_bytes.starts_with("BZh")) return Compression::kBzip2;
  return Compression::kNone;
}

std::unique_ptr<ByteSource> decompressed(std::unique_ptr<ByteSource> stored, Compression kind,
                                         const std::string& name) {
  if (kind == Compression::kGzip) return std::make_unique<GzipSource>(std::move(stored), name);
  if (kind == Compression::kBzip2) return std::make_unique<Bzip2Source>(std::move(stored), name);
  return stored;
}

}  // namespace loopstone
