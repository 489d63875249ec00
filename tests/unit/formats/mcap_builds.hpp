#pragma once

#include <string>
#include <vector>

#include "support/recording_builder.hpp"

namespace loopstone::test {

/// Everything of which a writer may leave out the one or the other.
[[nodiscard]] inline std::vector<McapBuild> mcap_builds() {
  std::vector<McapBuild> list;
  const std::vector<McapBuild> packings{{.packing = Packing::kNone},
                                        {.packing = Packing::kLz4},
                                        {.packing = Packing::kLz4, .is_bare_lz4 = true},
                                        {.packing = Packing::kZstd}};
  for (const McapBuild& packing : packings) {
    list.push_back(packing);
    const auto add = [&](auto change) {
      list.push_back(packing);
      change(list.back());
    };
    add([](McapBuild& build) { build.outside_of_chunks = true; });
    add([](McapBuild& build) { build.has_message_indexes = false; });
    add([](McapBuild& build) { build.has_chunk_indexes = false; });
    add([](McapBuild& build) { build.has_summary = false; });
    add([](McapBuild& build) { build.repeats_channels = false; });
    add([](McapBuild& build) { build.repeats_schemas = false; });
    add([](McapBuild& build) { build.has_statistics = false; });
    add([](McapBuild& build) { build.has_checksums = false; });
    add([](McapBuild& build) { build.is_closed = false; });
    add([](McapBuild& build) { build.has_empty_chunk = build.has_unknown_records = true; });
    add([](McapBuild& build) { build.has_trailing_bytes = build.has_unknown_records = true; });
  }
  list.push_back({.has_chunks = false});
  list.push_back({.has_chunks = false, .is_closed = false});
  return list;
}

[[nodiscard]] inline std::string words(const McapBuild& build) {
  return "packing " + std::to_string(static_cast<int>(build.packing)) +
         (build.is_bare_lz4 ? " bare" : "") + (build.has_chunks ? "" : " no chunks") +
         (build.outside_of_chunks ? " outside" : "") +
         (build.has_message_indexes ? "" : " no message indexes") +
         (build.has_chunk_indexes ? "" : " no chunk indexes") +
         (build.has_summary ? "" : " no summary") +
         (build.repeats_channels ? "" : " no channels in the summary") +
         (build.repeats_schemas ? "" : " no schemas in the summary") +
         (build.has_statistics ? "" : " no statistics") +
         (build.has_checksums ? "" : " no checksums") + (build.is_closed ? "" : " not closed") +
         (build.has_empty_chunk ? " empty chunk" : "") +
         (build.has_trailing_bytes ? " trailing bytes" : "");
}

}  // namespace loopstone::test
