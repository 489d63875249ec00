#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/formats/edits_file.hpp"
#include "loopstone/slam/map_editor.hpp"
#include "loopstone/slam/mapper.hpp"
#include "loopstone/slam/settled_map.hpp"
#include "refusal.hpp"
#include "support/passage_drive.hpp"

namespace {

using loopstone::MapEdit;
using loopstone::MapEditor;

/// Of a short drive; edits are taken back after each input.
MapEditor& editor() {
  static MapEditor made = [] {
    loopstone::Mapper mapper({}, loopstone::test::short_submaps(), loopstone::Threads{1});
    loopstone::test::drive_through_a_passage(mapper, 0, 24);
    return MapEditor(mapper.settle(), loopstone::Threads{1});
  }();
  return made;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text = loopstone::fuzz::text_of(data, size);
  return loopstone::fuzz::expect_work_or_refusal(text, [&] {
    const std::vector<MapEdit> edits = loopstone::parse_edits(text, "edits.toml");
    // There is one way to write what was read, and it reads the same.
    const std::string written = loopstone::edits_to_toml(edits);
    if (loopstone::parse_edits(written, "again.toml") != edits) __builtin_trap();
    if (!loopstone::fuzz::goes_on()) return;
    constexpr std::size_t kMost = 20;
    const std::size_t count = edits.size() < kMost ? edits.size() : kMost;
    editor().set_edits(std::span(edits).first(count));
    for (std::size_t i = 0; i < editor().size(); ++i)
      if (editor().report(i).told.empty()) __builtin_trap();
    (void)editor().preview();
    (void)editor().draw();
    editor().set_edits({});
  });
}
