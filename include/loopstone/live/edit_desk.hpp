#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/live/view_board.hpp"
#include "loopstone/live/view_server.hpp"
#include "loopstone/slam/map_edit.hpp"
#include "loopstone/slam/settled_map.hpp"

namespace loopstone {

struct EditDeskOptions {
  std::string file{};     ///< where the edits are saved, for clients
  std::string command{};  ///< what does the same without a view
  /// Saves the edits as TOML; what it throws is told to the client. Empty: they can't be saved.
  std::function<void(const std::string& toml)> save{};
  Threads threads{};
};

/// A finished map in the hands of a view's clients: what they post is done to it at once, and shown
/// on the board; the map is drawn anew on a thread of the desk's own. docs/live_view.md has the
/// addresses and what is answered.
///
///   EditDesk desk(mapper.settle(), {}, view.board(), options);
///   server.on_get([&](auto path) { return desk.get(path); });
///   server.on_post([&](auto path, auto body) { return desk.post(path, body); });
///
/// get() and post() may be called by any thread; an edit takes some tens of milliseconds there.
/// Memory: the scans once, and twice what else a map is made of.
class EditDesk {
 public:
  /// \param before  edits that the map has, which clients build on and cannot undo
  EditDesk(const SettledMap& map, std::span<const MapEdit> before, ViewBoard& board,
           EditDeskOptions options);
  /// What is being drawn is given up.
  ~EditDesk();
  EditDesk(const EditDesk&) = delete;
  EditDesk& operator=(const EditDesk&) = delete;

  /// Nothing: no address of the desk's.
  [[nodiscard]] std::optional<HttpAnswer> get(std::string_view path) const;
  [[nodiscard]] std::optional<HttpAnswer> post(std::string_view path, std::string_view body);
  /// Returns when the map is drawn with all edits.
  void wait_until_drawn() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace loopstone
