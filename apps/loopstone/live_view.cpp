#include "live_view.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <thread>

#include "interrupt.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/version.hpp"

namespace loopstone::app {

namespace {

constexpr std::chrono::milliseconds kGlance{50};

ViewServerOptions options_of(const ViewFlags& flags, const ViewAbout& about) {
  return {.name = "loopstone: " + about.name,
          .address = flags.listen,
          .port = flags.port,
          .token = flags.token,
          .origins = flags.origins,
          .range = about.range};
}

std::string about_of(const ViewAbout& about) {
  const nlohmann::ordered_json json = {{"program", "loopstone"},
                                       {"version", kVersion},
                                       {"mode", about.mode},
                                       {"name", about.name},
                                       {"can_seek", about.range.has_value()},
                                       {"can_edit", about.can_edit}};
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// Somebody sits in front of this machine.
bool has_screen() {
  const auto is_set = [](const char* name) {
    const char* value = std::getenv(name);
    return value != nullptr && *value != '\0';
  };
  return (is_set("DISPLAY") || is_set("WAYLAND_DISPLAY")) && ::isatty(STDERR_FILENO) == 1;
}

/// Where it does not work the user has the address.
void show_in_browser(const std::string& url) {
  std::string program = "xdg-open";
  std::string address = url;
  char* const arguments[] = {program.data(), address.data(), nullptr};
  pid_t child = 0;
  posix_spawn_file_actions_t actions;
  if (posix_spawn_file_actions_init(&actions) != 0) return;
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  (void)posix_spawnp(&child, program.c_str(), &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
}

}  // namespace

void add_view_flags(CLI::App& command, ViewFlags& flags) {
  command
      .add_option("--port", flags.port, "of the view: where it listens; 0 takes any that is free")
      ->type_name("N")
      ->capture_default_str();
  command
      .add_option("--listen", flags.listen,
                  "of the view: an address of this machine, in digits; others than this machine "
                  "reach 0.0.0.0, which needs --token")
      ->type_name("ADDRESS")
      ->capture_default_str();
  command
      .add_option("--token", flags.token,
                  "of the view: a secret of 8 characters or more, which its address then ends with")
      ->type_name("TEXT");
  command
      .add_option("--origin", flags.origins,
                  "of the view: pages of this host may connect, such as https://app.foxglove.dev; "
                  "may be given several times")
      ->type_name("URL")
      ->allow_extra_args(false);
  command.add_flag("--no-open", flags.no_open, "of the view: do not open the browser");
}

LiveView::LiveView(const ViewFlags& flags, const ViewAbout& about)
    : opens_browser_(!flags.no_open),
      about_json_(about_of(about)),
      server_(options_of(flags, about)),
      board_(sink_of(server_)) {
  server_.on_get([this](std::string_view path) { return answer(path); });
}

std::optional<HttpAnswer> LiveView::answer(std::string_view path) const {
  if (path == "/api/about") return HttpAnswer{.body = about_json_};
  if (auto answer = board_.answer(path)) return answer;
  return others_ ? others_(path) : std::nullopt;
}

void LiveView::open(const AppContext& context) {
  server_.start();
  context.note("view at " + server_.url());
  if (opens_browser_ && has_screen()) show_in_browser(server_.url());
}

void LiveView::stay_open(const AppContext& context) {
  if (interrupted()) return;
  const HeldInterrupt held(kViewEnds);
  context.note("the view stays at " + server_.url() + " until Ctrl-C");
  while (!interrupted()) std::this_thread::sleep_for(kGlance);
}

}  // namespace loopstone::app
