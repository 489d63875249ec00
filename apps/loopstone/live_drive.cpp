#include "live_drive.hpp"

#include "live_sources.hpp"
#include "loopstone/base/release_memory.hpp"

namespace loopstone::app {

LiveDrive::LiveDrive(const LiveArguments& arguments, std::string_view step,
                     const AppContext& context)
    : arguments_(arguments),
      step_(step),
      context_(context),
      name_(names_of_sources(arguments)),
      print_problem_(context),
      log_(live_sources(arguments), log_options()),
      display_(context) {
  keep_memory_compact();
}

LiveLogOptions LiveDrive::log_options() {
  LiveLogOptions options{.reading = app::log_options(arguments_.reading, context_, &print_problem_),
                         .on_news = [this](const LiveNews& news) { tell(news); },
                         .idle =
                             [this] {
                               if (watch_.idle) watch_.idle();
                             }};
  if (arguments_.end_after_s > 0.0) options.end_after_s = arguments_.end_after_s;
  return options;
}

void LiveDrive::tell(const LiveNews& news) {
  const std::string text = news.source + ": " + news.text;
  if (news.is_trouble) {
    context_.warn(text);
  } else {
    context_.note(text);
  }
  if (!watch_.warn) return;
  watch_.warn(text);
  if (arguments_.listener != nullptr) arguments_.listener->add(news);
}

std::optional<RobotModel> LiveDrive::wait_for_robot() {
  context_.note("waiting for " + name_);
  if (!log_.wait_for_sources()) {
    context_.warn("nothing came, and nothing was written");
    return {};
  }
  tell_choices(log_, context_);
  return robot_of(log_, context_);
}

std::unique_ptr<LiveView> LiveDrive::make_view(const char* mode) const {
  if (arguments_.no_view) return nullptr;
  return std::make_unique<LiveView>(arguments_.view, ViewAbout{.name = name_, .mode = mode});
}

void LiveDrive::run(const RobotModel& robot,
                    const std::function<void(const SensorMessage&, PoseLines&)>& use) {
  PoseLines poses(arguments_.poses, context_);
  LiveRecorder recorder(arguments_.record, robot, context_);
  messages_.emplace(log_, LogCut{}, !context_.robot_given(), step_, watch_by(display_));
  while (const auto message = messages_->next()) {
    recorder.add(*message);
    if (arguments_.listener != nullptr) arguments_.listener->add(*message);
    use(*message, poses);
  }
  recorder.finish();
  ProgressDisplay::clear_line();
}

void add_live_outputs(const LiveArguments& arguments, Outputs& outputs) {
  if (!arguments.record.empty()) outputs.add_file("--record", arguments.record);
  if (!arguments.poses.empty()) outputs.add_file("--poses", arguments.poses);
}

}  // namespace loopstone::app
