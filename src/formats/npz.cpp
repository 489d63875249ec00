#include "formats/npz.hpp"

#include <zip.h>

#include <filesystem>
#include <utility>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/log_reader.hpp"

namespace loopstone {

struct NpzFile::Archive {
  explicit Archive(zip_t* opened) : zip(opened) {}
  ~Archive() { zip_discard(zip); }
  Archive(const Archive&) = delete;
  Archive& operator=(const Archive&) = delete;

  zip_t* zip;
};

namespace {

/// One member of the archive, decompressed.
class MemberSource final : public ByteSource {
 public:
  MemberSource(std::shared_ptr<void> archive, zip_file_t* file, std::int64_t size, std::string name,
               std::function<bool()> stop)
      : archive_(std::move(archive)),
        file_(file),
        size_(size),
        name_(std::move(name)),
        stop_(std::move(stop)) {}
  ~MemberSource() override { zip_fclose(file_); }
  MemberSource(const MemberSource&) = delete;
  MemberSource& operator=(const MemberSource&) = delete;

  std::size_t read(std::span<char> buffer) override {
    if (stop_ && stop_()) throw ReadingStopped();
    const zip_int64_t count = zip_fread(file_, buffer.data(), buffer.size());
    if (count < 0) {
      throw DataError({name_, {}, done_},
                      "the archive is damaged: these bytes don't unpack, or a checksum is wrong");
    }
    done_ += count;
    return static_cast<std::size_t>(count);
  }
  std::int64_t bytes_done() const override { return done_; }
  std::int64_t bytes_total() const override { return size_; }

 private:
  std::shared_ptr<void> archive_;
  zip_file_t* file_;
  std::int64_t size_;
  std::string name_;
  std::function<bool()> stop_;
  std::int64_t done_ = 0;
};

constexpr const char* kNotAZip =
    "is no readable .npz file; was it cut off, or is it another format?";

}  // namespace

NpzFile::NpzFile(const std::string& path, const MemoryBudget& budget, std::function<bool()> stop)
    : path_(path), budget_(budget), stop_(std::move(stop)) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) throw DataError({path}, "there is no such file");
  if (std::filesystem::is_directory(path, ignored)) {
    throw DataError({path}, "is a folder; an .npz file was expected");
  }
  int code = 0;
  zip_t* const zip = zip_open(path.c_str(), ZIP_RDONLY, &code);
  if (zip == nullptr) throw DataError({path}, kNotAZip);
  archive_ = std::make_shared<Archive>(zip);
}

NpzFile::NpzFile(std::string_view bytes, const std::string& name, const MemoryBudget& budget)
    : path_(name), budget_(budget) {
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* const source = zip_source_buffer_create(bytes.data(), bytes.size(), 0, &error);
  zip_t* const zip = source == nullptr ? nullptr : zip_open_from_source(source, ZIP_RDONLY, &error);
  zip_error_fini(&error);
  if (zip == nullptr) {
    if (source != nullptr) zip_source_free(source);
    throw DataError({name}, kNotAZip);
  }
  archive_ = std::make_shared<Archive>(zip);
}

bool NpzFile::has(const std::string& key) const {
  return zip_name_locate(archive_->zip, (key + ".npy").c_str(), 0) >= 0;
}

std::vector<std::string> NpzFile::keys() const {
  std::vector<std::string> keys;
  const zip_int64_t count = zip_get_num_entries(archive_->zip, 0);
  for (zip_int64_t i = 0; i < count && i < 1000; ++i) {
    const char* const name = zip_get_name(archive_->zip, static_cast<zip_uint64_t>(i), 0);
    std::string key = name == nullptr ? "" : name;
    if (key.ends_with(".npy")) keys.push_back(key.substr(0, key.size() - 4));
  }
  return keys;
}

std::unique_ptr<ByteSource> NpzFile::open_bytes(const std::string& key) const {
  const std::string member = key + ".npy";
  const zip_int64_t index = zip_name_locate(archive_->zip, member.c_str(), 0);
  if (index < 0) {
    std::string there;
    for (const std::string& each : keys()) there += (there.empty() ? "" : ", ") + each;
    throw DataError({path_}, "has no array '" + key + "'; it holds " +
                                 (there.empty() ? std::string("no array at all") : there));
  }
  zip_stat_t stat{};
  zip_stat_init(&stat);
  zip_stat_index(archive_->zip, static_cast<zip_uint64_t>(index), 0, &stat);
  zip_file_t* const file = zip_fopen_index(archive_->zip, static_cast<zip_uint64_t>(index), 0);
  if (file == nullptr) {
    throw DataError({path_},
                    "the array '" + key +
                        "' can't be opened: it is packed in a way that is not read, or the "
                        "archive is damaged");
  }
  return std::make_unique<MemberSource>(archive_, file, static_cast<std::int64_t>(stat.size),
                                        name_of(key), stop_);
}

NpyReader NpzFile::open(const std::string& key) const {
  return NpyReader(open_bytes(key), name_of(key));
}

NpyArray NpzFile::read(const std::string& key) const {
  return read_npy(open_bytes(key), name_of(key), budget_, stored_bytes(key));
}

std::uint64_t NpzFile::stored_bytes(const std::string& key) const {
  zip_stat_t stat{};
  zip_stat_init(&stat);
  const bool is_known = zip_stat(archive_->zip, (key + ".npy").c_str(), 0, &stat) == 0 &&
                        (stat.valid & ZIP_STAT_COMP_SIZE) != 0;
  return is_known ? stat.comp_size : 0;
}

void NpzFile::require_memory(const std::string& key, std::uint64_t bytes) const {
  budget_.require(bytes, stored_bytes(key), Growth::kNumbers, {name_of(key)});
}

}  // namespace loopstone
