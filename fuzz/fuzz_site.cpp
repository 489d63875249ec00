#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "loopstone/base/byte_archive.hpp"
#include "loopstone/formats/site_file.hpp"
#include "loopstone/slam/joined_drives.hpp"
#include "loopstone/slam/mapper.hpp"
#include "refusal.hpp"
#include "support/passage_drive.hpp"
#include "support/temp_dir.hpp"

namespace {

using loopstone::ByteReader;
using loopstone::ByteWriter;
using loopstone::DriveRecord;
using loopstone::is_sound;
using loopstone::JoinedDrives;
using loopstone::Mapper;
using loopstone::record_of;
using loopstone::SessionStatus;
using loopstone::SiteAccess;
using loopstone::SiteFile;
using loopstone::SiteSession;
using loopstone::Threads;
namespace fuzz = loopstone::fuzz;
namespace test = loopstone::test;

std::string good_record() {
  Mapper mapper({}, test::short_submaps(), Threads{1});
  test::drive_through_a_passage(mapper, 0, 20);
  (void)mapper.judge_robot();
  ByteWriter writer;
  writer(record_of(mapper.save_state().get(), test::short_submaps()));
  return writer.take();
}

/// A file that says it is a database.
void read_site(std::string_view bytes) {
  static const test::TempDir folder;
  const std::string path = folder.write("a.site", bytes);
  const SiteFile file(path, SiteAccess::kRead);
  (void)file.check();
  for (const SiteSession& session : file.sessions())
    if (session.status != SessionStatus::kRefused && session.status != SessionStatus::kRetired)
      (void)file.record(session);
  (void)file.pairs();
  (void)file.placements();
  (void)file.events();
  (void)file.edits();
}

/// Behind the checksums: four bytes for each byte of a good record that changes (position, value).
void use_record(std::string_view edits) {
  static const std::string good = good_record();
  std::string bytes = good;
  for (std::size_t at = 0; at + 4 <= edits.size(); at += 4) {
    const auto number = [&](std::size_t i) { return static_cast<std::uint8_t>(edits[at + i]); };
    const std::size_t position =
        std::size_t{65536} * number(0) + std::size_t{256} * number(1) + number(2);
    bytes[position % bytes.size()] = edits[at + 3];
  }
  DriveRecord record;
  ByteReader reader(bytes, {});
  reader(record);
  reader.end();
  constexpr double kReachM = 1e4;
  if (!is_sound(record, kReachM)) return;
  // What is taken must be fit to be placed among others.
  JoinedDrives joined(test::short_submaps(), Threads{1});
  joined.add(std::make_shared<const DriveRecord>(std::move(record)));
  if (!joined.is_joined(0)) __builtin_trap();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes = fuzz::text_of(data, size);
  return fuzz::expect_work_or_refusal(bytes, [&] {
    if (bytes.starts_with("SQLite format 3")) {
      read_site(bytes);
    } else {
      use_record(bytes);
    }
  });
}
