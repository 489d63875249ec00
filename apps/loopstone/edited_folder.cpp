#include "edited_folder.hpp"

#include <utility>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/options_file.hpp"
#include "loopstone/formats/robot_file.hpp"
#include "loopstone/formats/session_file.hpp"
#include "loopstone/slam/mapper.hpp"
#include "loopstone/slam/mapper_state.hpp"
#include "map_pipeline.hpp"

namespace loopstone::app {

SettledMap settle_kept_map(const std::string& out, const AppContext& context, KeptMap& kept) {
  Session session = read_kept_state(out, "edit", context.memory());
  const std::string path = kept_state_path(out);
  if (session.terms.robot_toml.empty()) {
    throw DataError({path},
                    "does not tell its robot; `loopstone map LOG -o FOLDER --keep-state` "
                    "makes one that does");
  }
  kept.robot = parse_robot(session.terms.robot_toml, path);
  kept.options_toml = session.terms.options_toml;
  std::vector<OptionProblem> problems =
      apply_toml(list_options(kept.options), kept.options_toml, path);
  if (!problems.empty()) throw OptionsError(std::move(problems));
  kept.options.map.most_cells = most_cells(context);
  Mapper mapper(kept.robot, kept.options, context.threads());
  try {
    mapper.restore_state(std::move(session.mapper));
  } catch (const UsageError& error) {
    throw DataError({path}, std::string("is damaged: ") + error.what());
  }
  return mapper.settle();
}

MapEditor open_kept_map(const std::string& out, const AppContext& context, KeptMap& kept) {
  return MapEditor(settle_kept_map(out, context, kept), context.threads());
}

}  // namespace loopstone::app
