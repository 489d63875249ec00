#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app.hpp"
#include "loopstone/live/view_board.hpp"
#include "loopstone/live/view_server.hpp"

// What the commands share that show something in the browser.

namespace loopstone::app {

struct ViewFlags {
  std::uint16_t port = ViewServerOptions{}.port;
  std::string listen = ViewServerOptions{}.address;
  std::string token{};
  std::vector<std::string> origins{};
  bool no_open = false;
  friend bool operator==(const ViewFlags&, const ViewFlags&) = default;
};

/// --port, --listen, --token, --origin, --no-open.
void add_view_flags(CLI::App& command, ViewFlags& flags);

/// What is shown.
struct ViewAbout {
  std::string name{};
  std::string mode{};                    ///< "replay", "mapping", "localizing"
  std::optional<PlaybackRange> range{};  ///< clients may seek in it
  bool can_edit = false;
};

/// A server with a board.
class LiveView {
 public:
  /// Throws UsageError for flags that make no sense.
  LiveView(const ViewFlags& flags, const ViewAbout& about);
  ~LiveView() { close(); }
  LiveView(const LiveView&) = delete;
  LiveView& operator=(const LiveView&) = delete;

  [[nodiscard]] ViewServer& server() { return server_; }
  [[nodiscard]] ViewBoard& board() { return board_; }

  /// Who answers what the board does not. Before open().
  void on_get(std::function<std::optional<HttpAnswer>(std::string_view path)> answer) {
    others_ = std::move(answer);
  }

  /// Listens, says where, and shows it in the user's browser where there is a screen. Throws
  /// UsageError when the port is taken.
  void open(const AppContext& context);
  /// Until Ctrl-C; not when that came already.
  void stay_open(const AppContext& context);
  [[nodiscard]] std::string url() const { return server_.url(); }
  /// Nothing is asked of what is shown any more.
  void close() { server_.stop(); }

 private:
  [[nodiscard]] std::optional<HttpAnswer> answer(std::string_view path) const;

  bool opens_browser_;
  std::string about_json_;
  std::function<std::optional<HttpAnswer>(std::string_view path)> others_{};
  ViewServer server_;
  ViewBoard board_;
};

/// Closes a view before that goes which its clients ask: stands behind it, so that it goes first.
class ClosesFirst {
 public:
  explicit ClosesFirst(LiveView& view) : view_(view) {}
  ~ClosesFirst() { view_.close(); }
  ClosesFirst(const ClosesFirst&) = delete;
  ClosesFirst& operator=(const ClosesFirst&) = delete;

 private:
  LiveView& view_;
};

/// What is said to the Ctrl-C that ends a view.
inline constexpr const char* kViewEnds = "the view ends";

}  // namespace loopstone::app
