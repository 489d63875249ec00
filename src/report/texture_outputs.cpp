#include "loopstone/report/texture_outputs.hpp"

#include <nlohmann/json.hpp>

#include "loopstone/formats/image.hpp"
#include "loopstone/report/texture_picture.hpp"
#include "report/output_files.hpp"
#include "report/texture_files.hpp"
#include "report/texture_summary.hpp"
#include "report/with_peak_memory.hpp"

namespace loopstone {

std::string format_texture_summary(const FloorTexture& texture, const RunInfo& info) {
  nlohmann::ordered_json summary = {
      {"version", info.version},       {"log", info.log_path},
      {"command", info.command_line},  {"wall_time_s", info.wall_time_s},
      {"cpu_time_s", info.cpu_time_s}, {"peak_memory_bytes", info.peak_memory_bytes},
      {"threads", info.threads},
  };
  summary.update(texture_json(texture));
  summary["warnings"] = texture.warnings;
  return summary.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

void write_texture_outputs(const FloorTexture& texture, const OccupancyMap& map,
                           const Trajectory& trajectory, const RunInfo& info,
                           const std::string& out_dir) {
  OutputFolder folder(out_dir, info.force);
  FileSet files(folder);
  add_texture_files(texture, files);
  if (texture.frame.cell_count() > 0) {
    files.add("texture_map.png", "the floor under walls and path, to look at",
              encode_png(draw_texture_picture(texture, map, trajectory), kPngCompression));
  }
  files.add("options.toml", "the effective options", info.options_toml);
  files.add("summary.json", "every figure of the run, for programs",
            format_texture_summary(texture, with_peak_memory(info)));
  files.commit();
  folder.keep();
}

}  // namespace loopstone
