#include "mrclam_run.hpp"

#include <fmt/format.h>

namespace loopstone::app {

MrclamLog read_mrclam_run(const std::string& path, const LogFlags& flags,
                          const SightingNoise& noise, const AppContext& context) {
  ProblemPrinter print_problem(context);
  MrclamLog log =
      read_mrclam_drive(path,
                        {.strict = flags.strict,
                         .on_problem = [&](const LogProblem& problem) { print_problem(problem); }},
                        noise, context.memory());
  context.note(
      fmt::format("{}: robot {}, {} readings of landmarks; {} sightings of other robots are left "
                  "out",
                  path, log.robot, log.readings.size(), log.of_robots));
  return log;
}

}  // namespace loopstone::app
