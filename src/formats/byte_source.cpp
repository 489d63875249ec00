#include "formats/byte_source.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <utility>

#include "formats/decompress.hpp"
#include "formats/streamed_bytes.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/log_reader.hpp"

namespace loopstone {
namespace {

namespace fs = std::filesystem;

class FileSource final : public ByteSource {
 public:
  FileSource(std::string path, std::int64_t offset, std::function<bool()> stop)
      : path_(std::move(path)), stop_(std::move(stop)), done_(offset) {
    file_ = std::fopen(path_.c_str(), "rb");
    if (file_ == nullptr) {
      throw DataError({path_}, std::string("can't be opened: ") + std::strerror(errno));
    }
    std::setvbuf(file_, nullptr, _IONBF, 0);
    std::error_code error;
    const auto size = fs::file_size(path_, error);
    total_ = error ? 0 : static_cast<std::int64_t>(size);
    if (offset != 0) std::fseek(file_, static_cast<long>(offset), SEEK_SET);
  }
  ~FileSource() override {
    if (file_ != nullptr) std::fclose(file_);
  }
  FileSource(const FileSource&) = delete;
  FileSource& operator=(const FileSource&) = delete;

  std::size_t read(std::span<char> buffer) override {
    if (stop_ && stop_()) throw ReadingStopped();
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
  std::function<bool()> stop_;
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

class FirstBytes final : public ByteSource {
 public:
  FirstBytes(std::unique_ptr<ByteSource> source, std::int64_t bytes)
      : source_(std::move(source)), left_(static_cast<std::size_t>(bytes)) {}

  std::size_t read(std::span<char> buffer) override {
    if (left_ == 0) return 0;
    const std::size_t count = source_->read(buffer.first(std::min(buffer.size(), left_)));
    left_ -= count;
    return count;
  }
  std::int64_t bytes_done() const override { return source_->bytes_done(); }
  std::int64_t bytes_total() const override { return source_->bytes_total(); }

 private:
  std::unique_ptr<ByteSource> source_;
  std::size_t left_;
};

/// Completes what opens the stored bytes by their decompression.
ReadableBytes readable(std::string name,
                       std::function<std::unique_ptr<ByteSource>(std::int64_t)> look_stored,
                       std::function<std::unique_ptr<ByteSource>()> read_stored, bool can_seek) {
  char magic[4] = {};
  const std::size_t count = read_fully(*look_stored(0), magic);
  const Compression kind = compression_of({magic, count});
  ReadableBytes bytes;
  bytes.name = std::move(name);
  bytes.can_seek = can_seek && kind == Compression::kNone;
  bytes.look = [look = std::move(look_stored), kind, name = bytes.name](std::int64_t offset) {
    return decompressed(look(offset), kind, name);
  };
  bytes.read = [read = std::move(read_stored), kind, name = bytes.name] {
    return decompressed(read(), kind, name);
  };
  return bytes;
}

}  // namespace

ReadableBytes readable_stream(std::unique_ptr<ByteStream> stream, std::optional<double> look_s) {
  const auto bytes = std::make_shared<StreamedBytes>(std::move(stream), look_s);
  return readable(
      bytes->name(), [bytes](std::int64_t) { return bytes->look(); },
      [bytes] { return bytes->read(); }, false);
}

ReadableBytes open_file_or_pipe(const std::string& path, std::function<bool()> stop) {
  if (path == kStandardInput) return readable_stream(open_pipe(path, std::move(stop)));
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) throw DataError({path}, "there is no such file");
  if (fs::is_directory(status)) throw DataError({path}, "is a folder; a file was expected");
  if (!fs::is_regular_file(status)) return readable_stream(open_pipe(path, std::move(stop)));
  const auto look = [path, stop = std::move(stop)](std::int64_t offset) {
    return std::make_unique<FileSource>(path, offset, stop);
  };
  return readable(
      path, look, [look] { return look(0); }, true);
}

ReadableBytes readable_memory(std::string_view bytes, const std::string& name) {
  const auto look = [bytes](std::int64_t offset) {
    return std::make_unique<MemorySource>(bytes.substr(static_cast<std::size_t>(offset)));
  };
  return readable(
      name, look, [look] { return look(0); }, true);
}

std::unique_ptr<ByteSource> memory_byte_source(std::string_view bytes, const std::string& name) {
  return decompressed(std::make_unique<MemorySource>(bytes), compression_of(bytes.substr(0, 4)),
                      name);
}

std::size_t read_fully(ByteSource& source, std::span<char> buffer) {
  std::size_t done = 0;
  while (done < buffer.size()) {
    const std::size_t count = source.read(buffer.subspan(done));
    if (count == 0) break;
    done += count;
  }
  return done;
}

std::unique_ptr<ByteSource> first_bytes(std::unique_ptr<ByteSource> source, std::int64_t bytes) {
  return std::make_unique<FirstBytes>(std::move(source), bytes);
}

}  // namespace loopstone
