#include <algorithm>
#include <string>
#include <string_view>

#include "loopstone/base/byte_archive.hpp"
#include "loopstone/formats/session_file.hpp"
#include "loopstone/slam/mapper.hpp"
#include "loopstone/slam/mapper_state.hpp"
#include "refusal.hpp"
#include "support/passage_drive.hpp"

namespace {

using loopstone::ByteReader;
using loopstone::ByteWriter;
using loopstone::DataError;
using loopstone::Mapper;
using loopstone::MapperState;
using loopstone::Session;
using loopstone::Threads;
using loopstone::test::drive_through_a_passage;
using loopstone::test::short_submaps;

/// Of a mapper that saw half of the drive.
std::string saved_run() {
  Mapper mapper({}, short_submaps(), Threads{1});
  drive_through_a_passage(mapper, 0, 12);
  ByteWriter writer;
  writer(mapper.save_state().get());
  return writer.take();
}

/// What a mapper takes in it must be able to give back, and to go on from to a map.
void restore(const MapperState& state, std::string_view bytes) {
  loopstone::fuzz::expect_work_or_refusal(bytes, [&] {
    Mapper mapper({}, short_submaps(), Threads{1});
    mapper.restore_state(state);
    (void)mapper.save_state().get();
    if (!loopstone::fuzz::goes_on()) return;
    drive_through_a_passage(mapper, 12, 16);
    (void)mapper.finish();
  });
}

/// Behind the checksums: four bytes for each byte of a good state that changes (position, value),
/// and what is left over tells by how much it is shorter.
void restore_edited(std::string_view edits) {
  static const std::string good = saved_run();
  const auto number = [&](std::size_t i) { return static_cast<std::uint8_t>(edits[i]); };
  std::string bytes = good;
  std::size_t at = 0;
  for (; at + 4 <= edits.size(); at += 4) {
    const std::size_t position =
        std::size_t{65536} * number(at) + std::size_t{256} * number(at + 1) + number(at + 2);
    bytes[position % bytes.size()] = edits[at + 3];
  }
  if (at < edits.size())
    bytes.resize(bytes.size() - std::min<std::size_t>(bytes.size(), number(at)));
  MapperState state;
  try {
    ByteReader reader(bytes);
    reader(state);
    reader.end();
  } catch (const DataError&) {
    return;
  }
  restore(state, edits);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes = loopstone::fuzz::text_of(data, size);
  loopstone::fuzz::expect_work_or_refusal(bytes, [&] {
    const Session session = loopstone::parse_session(bytes, "fuzz");
    if (loopstone::format_session(session) != bytes)
      __builtin_trap();  // there is one way only to write it
    restore(session.mapper, bytes);
  });
  restore_edited(bytes);
  return 0;
}
