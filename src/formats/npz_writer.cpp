#include "formats/npz_writer.hpp"

#include <zip.h>

#include "formats/npy.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

constexpr zip_uint16_t kDosDate_1980_01_01 = 0x0021;
constexpr zip_uint32_t kFastDeflate = 1;  // measured ranges hardly compress any better at 6 to 9

std::span<const char> bytes_of(std::span<const double> values) {
  return {reinterpret_cast<const char*>(values.data()), values.size_bytes()};
}

}  // namespace

void NpzWriter::add(const std::string& key, const std::string& descr, bool fortran_order,
                    std::span<const std::int64_t> shape, std::span<const char> data) {
  std::string bytes = npy_head(descr, fortran_order, shape);
  bytes.append(data.data(), data.size());
  members_.push_back({key, std::move(bytes)});
}

void NpzWriter::add_file(const std::string& key, const std::string& npy_path) {
  members_.push_back({key, {}, npy_path});
}

void NpzWriter::add_number(const std::string& key, double value) {
  add(key, "<f8", false, {}, bytes_of({&value, 1}));
}

void NpzWriter::add_row(const std::string& key, std::span<const double> values) {
  const std::int64_t shape[] = {static_cast<std::int64_t>(values.size())};
  add(key, "<f8", false, shape, bytes_of(values));
}

AtomicFile NpzWriter::write() const {
  AtomicFile file(path_);
  int code = 0;
  zip_t* const zip = zip_open(file.temporary_path().c_str(), ZIP_CREATE | ZIP_TRUNCATE, &code);
  if (zip == nullptr) throw DataError({path_}, "can't be written: no archive can be made there");
  const auto fail = [&](zip_source_t* source) {
    const std::string reason = zip_strerror(zip);
    if (source != nullptr) zip_source_free(source);
    zip_discard(zip);
    throw DataError({path_}, "can't be written: " + reason);
  };
  for (const Member& member : members_) {
    zip_source_t* const source =
        member.npy_path.empty()
            ? zip_source_buffer(zip, member.bytes.data(), member.bytes.size(), 0)
            : zip_source_file(zip, member.npy_path.c_str(), 0, -1);
    if (source == nullptr) fail(nullptr);
    const zip_int64_t index =
        zip_file_add(zip, (member.key + ".npy").c_str(), source, ZIP_FL_OVERWRITE);
    if (index < 0) fail(source);
    const auto entry = static_cast<zip_uint64_t>(index);
    zip_set_file_compression(zip, entry, ZIP_CM_DEFLATE, kFastDeflate);
    zip_file_set_dostime(zip, entry, 0, kDosDate_1980_01_01, 0);
  }
  if (zip_close(zip) != 0) fail(nullptr);
  return file;
}

}  // namespace loopstone
