#include "loopstone/live/edit_desk.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <thread>

#include "loopstone/formats/edits_file.hpp"
#include "loopstone/slam/map_editor.hpp"
#include "loopstone/slam/mapper.hpp"
#include "support/simulated_log.hpp"
#include "unit/live/recorded_view.hpp"

namespace loopstone {
namespace {

using Json = nlohmann::json;

/// A finished map of a few rooms on a desk.
class Desk : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const test::SimulatedLog log = test::simulate_log("rooms", 1, {.duration_s = 90.0});
    Mapper mapper(log.robot, MapOptions{}, Threads{2});
    for (const SensorMessage& message : log.messages) mapper.add(message);
    map_ = new SettledMap(mapper.settle());
  }
  static void TearDownTestSuite() {
    delete map_;
    map_ = nullptr;
  }

  [[nodiscard]] std::unique_ptr<EditDesk> desk(std::vector<MapEdit> before = {}) {
    return std::make_unique<EditDesk>(*map_, before, board_,
                                      EditDeskOptions{.file = "out.edits.toml",
                                                      .command = "loopstone edit",
                                                      .save =
                                                          [this](const std::string& toml) {
                                                            if (is_full_)
                                                              throw std::runtime_error("disk full");
                                                            saved_ = toml;
                                                          },
                                                      .threads = Threads{2}});
  }
  static Json state(const EditDesk& desk) { return Json::parse(desk.get("/api/edits")->body); }
  static HttpAnswer post(EditDesk& desk, const std::string& toml) {
    return *desk.post("/api/edits", Json{{"toml", toml}}.dump());
  }
  static std::string box(const std::string& kind) {
    return "[[edit]]\nkind = \"" + kind + "\"\nbox = [-1, -1, 1, 1]\n";
  }
  /// The first closure that stands.
  static std::string delete_a_closure() {
    for (const LoopClosure& closure : map_->settled.closures) {
      if (!closure.stands()) continue;
      return "[[edit]]\nkind = \"delete_closure\"\nfrom_node = " +
             std::to_string(closure.from.index) +
             "\nto_node = " + std::to_string(closure.to.index) + "\n";
    }
    throw std::runtime_error("the map has no closure");
  }

  static inline SettledMap* map_ = nullptr;
  test::RecordedView view_{};
  ViewBoard board_{view_.sink()};
  std::string saved_{};
  bool is_full_ = false;
};

TEST_F(Desk, DoesWhatIsPostedAndShowsIt) {
  const auto desk = this->desk();
  EXPECT_EQ(state(*desk)["edits"].size(), 0U);
  EXPECT_EQ(state(*desk)["revision"], 0);
  const HttpAnswer answer = post(*desk, delete_a_closure());
  ASSERT_EQ(answer.status, 200) << answer.body;
  const Json now = Json::parse(answer.body);
  ASSERT_EQ(now["edits"].size(), 1U);
  EXPECT_EQ(now["edits"][0]["kind"], "delete_closure");
  EXPECT_EQ(now["edits"][0]["applied"], true);
  EXPECT_FALSE(now["edits"][0]["told"].get<std::string>().empty());
  EXPECT_EQ(now["revision"], 1);
  // The graph is there at once, the map a little later.
  const auto nodes = view_.all("/loopstone/trajectory");
  EXPECT_FALSE(nodes.empty());
  desk->wait_until_drawn();
  EXPECT_EQ(state(*desk)["drawn"], 1);
  EXPECT_FALSE(view_.all("/loopstone/tiles").empty());
  EXPECT_FALSE(view_.last_json("/loopstone/verdict")["verdict"].get<std::string>().empty());

  MapEditor editor(*map_, Threads{1});
  for (const MapEdit& edit : parse_edits(delete_a_closure(), "test")) editor.add(edit);
  const MapResult expected = editor.draw().result;
  const auto path = view_.last<msg::Path>("/path");
  ASSERT_EQ(path.poses.size(), expected.trajectory.size());
  EXPECT_EQ(path.poses.back().pose.position.x, expected.trajectory.back().pose.x)
      << "as the library alone does it";
}

TEST_F(Desk, UndoesAndSaves) {
  const auto desk = this->desk();
  EXPECT_EQ(desk->post("/api/edits/undo", "{}")->status, 409) << "there is nothing to undo";
  (void)post(*desk, box("keep_out"));
  (void)post(*desk, "[[edit]]\nkind = \"as_edited\"\n" + box("erase"));
  ASSERT_EQ(desk->post("/api/edits/save", "{}")->status, 200);
  const std::vector<MapEdit> both = parse_edits(saved_, "saved");
  EXPECT_EQ(both.size(), 3U);
  EXPECT_EQ(state(*desk)["saved"], 2);

  const Json undone = Json::parse(desk->post("/api/edits/undo", "{}")->body);
  ASSERT_EQ(undone["edits"].size(), 1U) << "the marker before it goes, too";
  EXPECT_EQ(undone["edits"][0]["kind"], "keep_out");
  EXPECT_EQ(undone["edits"][0]["polygon"].size(), 8U);
  EXPECT_EQ(undone["revision"], 3);

  is_full_ = true;
  const auto failed = desk->post("/api/edits/save", "{}");
  EXPECT_EQ(failed->status, 500);
  EXPECT_NE(failed->body.find("disk full"), std::string::npos);
  EXPECT_EQ(state(*desk)["saved"], 2);
}

TEST_F(Desk, BuildsOnEditsThatWereThere) {
  const auto desk = this->desk(parse_edits(box("erase"), "before"));
  EXPECT_EQ(state(*desk)["edits"].size(), 0U);
  EXPECT_EQ(desk->post("/api/edits/undo", "{}")->status, 409) << "they are not the client's";
  (void)post(*desk, box("keep_out"));
  ASSERT_EQ(desk->post("/api/edits/save", "{}")->status, 200);
  EXPECT_EQ(parse_edits(saved_, "saved").size(), 1U);
}

TEST_F(Desk, RefusesWhatItDoesNotUnderstand) {
  const auto desk = this->desk();
  for (const std::string body :
       {"", "[]", "{", R"({"toml": 5})", R"({"toml": "[[edit]]\nkind=7"})"}) {
    const auto answer = desk->post("/api/edits", body);
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->status, 400) << body;
    EXPECT_FALSE(Json::parse(answer->body)["error"].get<std::string>().empty());
  }
  EXPECT_EQ(state(*desk)["revision"], 0) << "nothing was done";
  EXPECT_FALSE(desk->get("/api/other"));
  EXPECT_FALSE(desk->post("/api/other", "{}"));
  // An edit that can't be done is on the list, says why, and changes nothing.
  const Json refused = Json::parse(
      post(*desk, "[[edit]]\nkind = \"delete_closure\"\nfrom_node = 0\nto_node = 1\n").body);
  EXPECT_EQ(refused["edits"][0]["applied"], false);
  (void)post(*desk, box("keep_out"));
  ASSERT_EQ(desk->post("/api/edits/save", "{}")->status, 200);
  EXPECT_EQ(parse_edits(saved_, "saved").size(), 1U) << "only what was done";
  EXPECT_FALSE(refused["edits"][0]["told"].get<std::string>().empty());
}

TEST_F(Desk, GivesTheScansOfNodes) {
  const auto desk = this->desk();
  const Json scan = Json::parse(desk->get("/api/nodes/3/scan")->body);
  EXPECT_GT(scan["points"].size(), 100U);
  EXPECT_EQ(desk->get("/api/nodes/999999/scan")->status, 404);
  EXPECT_EQ(desk->get("/api/nodes/-1/scan")->status, 404);
  EXPECT_EQ(desk->get("/api/nodes/3x/scan")->status, 404);
}

TEST_F(Desk, MayGoWhileItDraws) {
  for (int i = 0; i < 3; ++i) {
    const auto desk = this->desk();
    (void)post(*desk, box("erase"));
    std::this_thread::sleep_for(std::chrono::milliseconds(10 * i));
    (void)post(*desk, box("keep_out"));
  }
}

}  // namespace
}  // namespace loopstone
