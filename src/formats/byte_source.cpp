#include "formats/byte_source.hpp"

#include <bzlib.h>
#include <zlib.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <utility>
#include <vector>

#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

constexpr std::size_t kBlockBytes = std::size_t{1} << 16;

class FileSource final : public ByteSource {
 public:
  FileSource(std::string path, std::int64_t offset) : path_(std::move(path)), done_(offset) {
    std::error_code error;
    const auto status = std::filesystem::status(path_, error);
    if (!std::filesystem::exists(status)) throw DataError({path_}, "there is no such file");
    if (std::filesystem::is_directory(status)) {
      throw DataError({path_}, "is a folder; a file was expected");
    }
    file_ = std::fopen(path_.c_str(), "rb");
    if (file_ == nullptr) {
      throw DataError({path_}, std::string("can't be opened: ") + std::strerror(errno));
    }
    std::setvbuf(file_, nullptr, _IONBF, 0);
    const auto size = std::filesystem::file_size(path_, error);
    total_ = error ? 0 : static_cast<std::int64_t>(size);
    if (offset != 0) std::fseek(file_, static_cast<long>(offset), SEEK_SET);
  }
  ~FileSource() override {
    if (file_ != nullptr) std::fclose(file_);
  }
  FileSource(const FileSource&) = delete;
  FileSource& operator=(const FileSource&) = delete;

  std::size_t read(std::span<char> buffer) override {
    const std::size_t count = std::fread(buffer.data(), 1, buffer.size(), file_);
    if (count == 0 && std::ferror(file_) != 0) {
      throw DataError({path_, {}, done_}, std::string("can't be read: ") + std::strerror(errno));
    }
    done_ += static_cast<std::int64_t>(count);
    return count;
  }
  std::int64_t bytes_done() const override { return done_; }
  std::int64_t bytes_total() const override { return total_; }

 private:
  std::string path_;
  std::FILE* file_ = nullptr;
  std::int64_t done_ = 0;
  std::int64_t total_ = 0;
};

class MemorySource final : public ByteSource {
 public:
  explicit MemorySource(std::string_view bytes) : bytes_(bytes) {}

  std::size_t read(std::span<char> buffer) override {
    const std::size_t count = std::min(buffer.size(), bytes_.size() - done_);
    if (count > 0) std::memcpy(buffer.data(), bytes_.data() + done_, count);
    done_ += count;
    return count;
  }
  std::int64_t bytes_done() const override { return static_cast<std::int64_t>(done_); }
  std::int64_t bytes_total() const override { return static_cast<std::int64_t>(bytes_.size()); }

 private:
  std::string_view bytes_;
  std::size_t done_ = 0;
};

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
    return buffer.size() - stream_.avail_out;
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
    return buffer.size() - stream_.avail_out;
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
  bz_stream stream_{};
  bool member_open_ = false;
  bool finished_ = false;
};

std::unique_ptr<ByteSource> decompressed(std::unique_ptr<ByteSource> stored, Compression kind,
                                         const std::string& path) {
  if (kind == Compression::kGzip) return std::make_unique<GzipSource>(std::move(stored), path);
  if (kind == Compression::kBzip2) return std::make_unique<Bzip2Source>(std::move(stored), path);
  return stored;
}

}  // namespace

Compression compression_of(std::string_view first_bytes) {
  if (first_bytes.starts_with("\x1f\x8b")) return Compression::kGzip;
  if (first_bytes.starts_with("BZh")) return Compression::kBzip2;
  return Compression::kNone;
}

Compression compression_of_file(const std::string& path) {
  char magic[4] = {};
  const std::size_t count = FileSource(path, 0).read(magic);
  return compression_of({magic, count});
}

std::unique_ptr<ByteSource> open_byte_source(const std::string& path, std::int64_t offset) {
  if (offset != 0) return std::make_unique<FileSource>(path, offset);
  return decompressed(std::make_unique<FileSource>(path, 0), compression_of_file(path), path);
}

std::unique_ptr<ByteSource> memory_byte_source(std::string_view bytes, const std::string& name) {
  return decompressed(std::make_unique<MemorySource>(bytes), compression_of(bytes.substr(0, 4)),
                      name);
}

}  // namespace loopstone
