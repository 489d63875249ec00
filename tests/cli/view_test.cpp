// `loopstone view` and `map --view`, seen by a client of sockets alone.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "loopstone/formats/tum.hpp"
#include "loopstone/messages/message_codec.hpp"
#include "run_program.hpp"
#include "source_folder.hpp"
#include "support/seen_list.hpp"
#include "support/temp_dir.hpp"
#include "support/web_client.hpp"

namespace loopstone::test {
namespace {

using Json = nlohmann::json;
using testing::HasSubstr;
using Words = std::vector<std::string>;

/// A page that looks: subscribes to what is advertised, and keeps the last message of each topic.
class Viewer {
 public:
  explicit Viewer(std::uint16_t port) : client_(port) {
    EXPECT_EQ(client_.open_socket().status, 101);
  }

  /// Takes messages until it is so; a minute without any is an error.
  void look_until(const std::function<bool()>& is_so) {
    while (!is_so()) {
      const auto message = client_.receive();
      if (!message) throw std::runtime_error("the server closed too early");
      take(*message);
    }
  }
  [[nodiscard]] bool has(const std::string& topic) const { return last_.contains(topic); }
  [[nodiscard]] const std::string& bytes(const std::string& topic) const { return last_.at(topic); }
  [[nodiscard]] Json json(const std::string& topic) const { return Json::parse(bytes(topic)); }
  /// As its changes have left it.
  [[nodiscard]] Json closures() const { return closures_.entries(); }
  template <typename M>
  [[nodiscard]] M message(const std::string& topic) const {
    M read;
    MessageDecoder<M>(WireFormat::kCdr).decode(bytes(topic), read);
    return read;
  }
  [[nodiscard]] int count(const std::string& topic) const {
    const auto found = counts_.find(topic);
    return found == counts_.end() ? 0 : found->second;
  }
  [[nodiscard]] const std::set<std::string>& topics() const { return advertised_; }
  [[nodiscard]] const Json& info() const { return info_; }
  /// Of the last message of a topic [s].
  [[nodiscard]] double time(const std::string& topic) const { return times_.at(topic); }
  /// -1 as long as nothing was said.
  [[nodiscard]] int playback() const { return playback_; }

  void control(bool play, float speed, double seek_s = -1.0) {
    std::string bytes = "\x03";
    const auto append = [&](const auto& value) {
      bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
    };
    append(static_cast<std::uint8_t>(play ? 0 : 1));
    append(speed);
    append(static_cast<std::uint8_t>(seek_s >= 0.0 ? 1 : 0));
    append(static_cast<std::uint64_t>(std::max(seek_s, 0.0) * 1e9));
    append(std::uint32_t{1});
    client_.send_bytes(bytes + "r");
  }
  [[nodiscard]] WebClient& client() { return client_; }

 private:
  void take(const WebClient::Message& message) {
    if (message.is_text) {
      const Json json = Json::parse(message.bytes);
      if (json["op"] == "serverInfo") info_ = json;
      if (json["op"] == "advertise") subscribe(json["channels"]);
      return;
    }
    if (message.bytes.front() == 5) playback_ = message.bytes[1];
    if (message.bytes.front() != 1) return;
    std::uint32_t id = 0;
    std::uint64_t nanoseconds = 0;
    std::memcpy(&id, message.bytes.data() + 1, sizeof id);
    std::memcpy(&nanoseconds, message.bytes.data() + 5, sizeof nanoseconds);
    const std::string& topic = topic_of_.at(id);
    last_[topic] = message.bytes.substr(13);
    if (topic == "/loopstone/closures") closures_.take(json(topic), "closures");
    times_[topic] = static_cast<double>(nanoseconds) * 1e-9;
    ++counts_[topic];
  }

  void subscribe(const Json& channels) {
    Json wishes = Json::array();
    for (const Json& channel : channels) {
      const auto id = channel["id"].get<std::uint32_t>();
      topic_of_[id + 100] = channel["topic"];
      advertised_.insert(channel["topic"]);
      wishes.push_back({{"id", id + 100}, {"channelId", id}});
    }
    client_.send_text(Json{{"op", "subscribe"}, {"subscriptions", wishes}}.dump());
  }

  WebClient client_;
  std::map<std::uint32_t, std::string> topic_of_{};
  std::set<std::string> advertised_{};
  std::map<std::string, std::string> last_{};
  std::map<std::string, double> times_{};
  std::map<std::string, int> counts_{};
  SeenList closures_{};
  Json info_{};
  int playback_ = -1;
};

/// Runs the program until `look` has seen enough, then Ctrl-C.
/// \param look  is given the port
ProgramResult view(const Words& arguments, const std::function<void(std::uint16_t)>& look) {
  return interrupt_after(arguments, [&](const std::function<std::string()>& errors) {
    std::smatch found;
    std::string text;
    for (int i = 0; i < 30'000; ++i) {
      text = errors();
      if (std::regex_search(text, found, std::regex("view at http://127.0.0.1:(\\d+)/"))) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    ASSERT_FALSE(found.empty()) << text;
    look(static_cast<std::uint16_t>(std::stoi(found[1])));
  });
}

class ViewCommand : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    dir_ = new TempDir;
    log_ = *dir_ / "sim";
    map_ = *dir_ / "map";
    ASSERT_EQ(run_program({"simulate", "rooms", "-o", log_, "--seed", "2", "--duration", "40",
                           "--beams", "181", "--quiet"})
                  .exit_code,
              0);
    const ProgramResult mapped = run_program({"map", log_, "-o", map_, "--quiet"});
    ASSERT_EQ(mapped.exit_code, 0) << mapped.error;
    summary_ = Json::parse(dir_->read("map/summary.json"));
  }
  static void TearDownTestSuite() {
    delete dir_;
    dir_ = nullptr;
  }
  static std::size_t closures() {
    const std::string csv = dir_->read("map/loop_closures.csv");
    return count_lines(csv) - 1;
  }
  /// Who comes now gets all of it, and where the robot is.
  static void expect_finished_map(std::uint16_t port) {
    Viewer viewer(port);
    viewer.look_until([&] {
      return viewer.has("/loopstone/quality") && viewer.has("/loopstone/trajectory") &&
             viewer.has("/loopstone/tiles") && viewer.has("/pose");
    });
    EXPECT_EQ(viewer.closures().size(), closures());
    EXPECT_EQ(viewer.json("/loopstone/verdict")["sentence"], summary_["quality"]["sentence"]);
    EXPECT_EQ(viewer.json("/loopstone/verdict")["complete"], true);
    const auto tiles = viewer.message<msg::MapTiles>("/loopstone/tiles");
    EXPECT_TRUE(tiles.whole);
    EXPECT_GT(tiles.ids.size(), 2U);
    const auto nodes = viewer.message<msg::Trajectory>("/loopstone/trajectory");
    EXPECT_GT(nodes.count, 10U);
    EXPECT_EQ(nodes.t.size(), nodes.count);
    for (const Json& closure : viewer.closures()) {
      ASSERT_LT(closure["to"].get<std::size_t>(), nodes.count);
      EXPECT_NEAR(nodes.t[closure["to"].get<std::size_t>()], closure["to_t"].get<double>(), 1e-6);
    }
  }

  static inline TempDir* dir_ = nullptr;
  static inline std::string log_;
  static inline std::string map_;
  static inline Json summary_;
};

const std::set<std::string> kTopics{"/tf",
                                    "/tf_static",
                                    "/scan",
                                    "/pose",
                                    "/map",
                                    "/path",
                                    "/graph",
                                    "/loopstone/tiles",
                                    "/loopstone/trajectory",
                                    "/loopstone/status",
                                    "/loopstone/closures",
                                    "/loopstone/submaps",
                                    "/loopstone/verdict",
                                    "/loopstone/warnings",
                                    "/loopstone/quality",
                                    "/loopstone/texture"};

TEST_F(ViewCommand, ShowsAFinishedMap) {
  const ProgramResult result =
      view({"view", map_, "--port", "0", "--no-open", "--json"}, [](std::uint16_t port) {
        Viewer viewer(port);
        viewer.look_until([&] {
          return viewer.has("/scan") && viewer.has("/loopstone/quality") &&
                 viewer.has("/loopstone/status");
        });
        EXPECT_EQ(viewer.topics(), kTopics);
        EXPECT_EQ(viewer.info()["capabilities"], (Json{"time", "playbackControl"}));
        expect_finished_map(port);
        EXPECT_EQ(viewer.message<msg::Path>("/path").poses.size(), summary_["scans"]);
        const Json quality = viewer.json("/loopstone/quality");
        EXPECT_GT(quality["resolution"].get<double>(), 0.0);
        EXPECT_THAT(quality["png"].get<std::string>(), testing::StartsWith("iVBORw0KGgo"));

        WebClient http(port);
        const Json about = Json::parse(http.get("/api/about").body);
        EXPECT_EQ(about["mode"], "replay");
        EXPECT_EQ(about["name"], "map");
        EXPECT_EQ(about["can_seek"], true);
        const Json evidence = Json::parse(http.get("/api/closures/0").body);
        EXPECT_GT(evidence["from"]["points"].size(), 100U);  // the log is beside it
        EXPECT_EQ(evidence["measured"].size(), 3U);
        EXPECT_EQ(http.get("/api/closures/100000").status, 404);
      });
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(Json::parse(result.out)["url"].get<std::string>(), HasSubstr("http://127.0.0.1:"));
}

TEST_F(ViewCommand, GoesWhereAClientWantsToBe) {
  const Trajectory path = read_tum(map_ + "/trajectory.tum");
  const double start_s = path.front().stamp.seconds();
  const ProgramResult result =
      view({"view", map_, "--port", "0", "--no-open", "--speed", "2"}, [&](std::uint16_t port) {
        Viewer viewer(port);
        viewer.look_until([&] { return viewer.has("/pose"); });
        for (const double after_s : {30.0, 10.0, 20.0}) {
          viewer.control(false, 1.0F, start_s + after_s);
          viewer.look_until([&] {
            return viewer.playback() == 1 &&
                   std::abs(viewer.time("/pose") - start_s - after_s) < 0.15;
          });
          const auto pose = viewer.message<msg::PoseWithCovarianceStamped>("/pose");
          const auto expected = path.at(pose.header.stamp);
          ASSERT_TRUE(expected.has_value());
          EXPECT_NEAR(pose.pose.pose.position.x, expected->x, 1e-6);
        }
        viewer.control(true, 0.0F);
        viewer.look_until([&] { return viewer.playback() == 3; });
        expect_finished_map(port);
      });
  EXPECT_EQ(result.exit_code, 0) << result.error;
}

TEST_F(ViewCommand, MapsALogWhileItIsReplayed) {
  const ProgramResult result =
      view({"view", log_, "--port", "0", "--no-open", "--speed", "40"}, [](std::uint16_t port) {
        Viewer viewer(port);
        viewer.look_until([&] { return viewer.has("/scan") && viewer.has("/loopstone/tiles"); });
        const double start_s = viewer.info()["dataStartTime"]["sec"].get<double>();
        viewer.look_until(
            [&] { return viewer.playback() == 3 && viewer.has("/loopstone/quality"); });
        viewer.look_until([&] { return viewer.json("/loopstone/verdict")["complete"] == true; });
        expect_finished_map(port);
        EXPECT_EQ(viewer.json("/loopstone/status")["scans"], summary_["scans"]);

        // Back: anew up to there.
        viewer.control(false, 1.0F, start_s + 20.0);
        viewer.look_until([&] {
          return viewer.playback() == 1 && std::abs(viewer.time("/pose") - start_s - 20.0) < 1.5 &&
                 viewer.json("/loopstone/status")["scans"] < summary_["scans"];
        });
        viewer.look_until([&] { return viewer.json("/loopstone/verdict")["complete"] == false; });
        WebClient http(port);
        EXPECT_EQ(Json::parse(http.get("/api/about").body)["name"], "sim");
      });
  EXPECT_EQ(result.exit_code, 0) << result.error;
}

TEST_F(ViewCommand, TheSameMapIsMadeWhoeverLooksOn) {
  const std::string out = *dir_ / "seen";
  const ProgramResult result =
      view({"map", log_, "-o", out, "--view", "--port", "0", "--no-open"}, [](std::uint16_t port) {
        Viewer viewer(port);
        viewer.look_until([&] {
          return viewer.has("/loopstone/verdict") &&
                 viewer.json("/loopstone/verdict")["complete"] == true;
        });
        viewer.look_until([&] { return viewer.has("/pose"); });
        expect_finished_map(port);
        EXPECT_EQ(viewer.info()["capabilities"], Json{"time"});
        WebClient http(port);
        const Json about = Json::parse(http.get("/api/about").body);
        EXPECT_EQ(about["mode"], "mapping");
        EXPECT_EQ(about["can_seek"], false);
        // The results are there before Ctrl-C comes.
        for (int i = 0; i < 30'000 && !std::filesystem::exists(*dir_ / "seen/summary.json"); ++i)
          std::this_thread::sleep_for(std::chrono::milliseconds(2));
        std::this_thread::sleep_for(std::chrono::milliseconds(500));
      });
  EXPECT_EQ(result.exit_code, 0) << result.error;
  for (const char* name : {"trajectory.tum", "trajectory.csv", "graph.g2o", "map.pgm", "map.yaml",
                           "loop_closures.csv", "map.png", "quality.png"})
    EXPECT_EQ(dir_->read(std::string("map/") + name), dir_->read(std::string("seen/") + name))
        << name;
}

/// What Foxglove's own client saw, as view_client.js tells it; nothing without Node or the client.
std::optional<Json> seen_by_foxglove(std::uint16_t port, const std::string& modules) {
  const std::string command =
      "NODE_PATH='" + modules + "' node '" LOOPSTONE_SOURCE_DIR "/tests/oracles/view_client.js' " +
      std::to_string(port) + " /tf /scan /map /loopstone/tiles /loopstone/closures";
  FILE* const pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return {};
  std::string text;
  std::array<char, 4096> part{};
  while (const std::size_t count = std::fread(part.data(), 1, part.size(), pipe))
    text.append(part.data(), count);
  EXPECT_EQ(::pclose(pipe), 0) << text;
  return Json::parse(text);
}

TEST_F(ViewCommand, FoxglovesOwnClientUnderstandsIt) {
  const std::string modules = LOOPSTONE_SOURCE_DIR "/build/oracles/node_modules";
  if (!std::filesystem::exists(modules + "/@foxglove/ws-protocol") ||
      std::system("node --version >/dev/null 2>&1") != 0)
    GTEST_SKIP() << "Foxglove's client is not installed (scripts/install_oracles.sh)";
  const ProgramResult result =
      view({"view", map_, "--port", "0", "--no-open"}, [&](std::uint16_t port) {
        const auto seen = seen_by_foxglove(port, modules);
        ASSERT_TRUE(seen.has_value());
        EXPECT_EQ((*seen)["info"]["name"], "loopstone: map");
        EXPECT_EQ((*seen)["channels"].size(), kTopics.size());
        EXPECT_EQ((*seen)["channels"]["/scan"]["schemaName"], "sensor_msgs/msg/LaserScan");
        EXPECT_GT((*seen)["messages"]["/map"]["bytes"], 1000);
        // Its version knows no playback; of all else nothing is strange to it.
        for (const Json& error : (*seen)["errors"])
          EXPECT_THAT(error.get<std::string>(), HasSubstr("opcode in binary message: 5"));
      });
  EXPECT_EQ(result.exit_code, 0) << result.error;
}

TEST_F(ViewCommand, ASlowClientMissesScansAndNothingElse) {
  const ProgramResult result =
      view({"view", log_, "--port", "0", "--no-open", "--speed", "10"}, [](std::uint16_t port) {
        Viewer slow(port);
        slow.look_until([&] { return slow.has("/scan"); });
        // It does not read until all is over, as another one knows.
        Viewer other(port);
        other.look_until([&] { return other.playback() == 3 && other.has("/loopstone/quality"); });
        slow.look_until([&] { return slow.playback() == 3 && slow.has("/loopstone/quality"); });
        slow.look_until([&] { return slow.json("/loopstone/verdict")["complete"] == true; });
        EXPECT_EQ(slow.closures(), other.closures());
        EXPECT_EQ(slow.bytes("/graph"), other.bytes("/graph"));
        EXPECT_LT(slow.count("/scan"), summary_["scans"].get<int>());
      });
  EXPECT_EQ(result.exit_code, 0) << result.error;
}

TEST_F(ViewCommand, ScansMayLieElsewhereOrNowhere) {
  const TempDir dir;
  std::filesystem::copy(map_, dir / "map");
  Json summary = summary_;
  summary["log"] = dir / "gone";
  dir.write("map/summary.json", summary.dump());
  const auto look = [](bool has_scans) {
    return [has_scans](std::uint16_t port) {
      Viewer viewer(port);
      viewer.look_until([&] { return viewer.count("/pose") > 3; });
      EXPECT_EQ(viewer.has("/scan"), has_scans);
    };
  };
  const ProgramResult without =
      view({"view", dir / "map", "--port", "0", "--no-open"}, look(false));
  EXPECT_EQ(without.exit_code, 0);
  EXPECT_THAT(without.error, HasSubstr("scans are not shown"));
  EXPECT_EQ(
      view({"view", dir / "map", "--log", log_, "--port", "0", "--no-open"}, look(true)).exit_code,
      0);
}

TEST_F(ViewCommand, SaysWhatIsWrong) {
  const auto expect_error = [](const Words& arguments, int code, const std::string& words) {
    const ProgramResult result = run_program(arguments);
    EXPECT_EQ(result.exit_code, code) << result.error;
    EXPECT_THAT(result.error, HasSubstr(words));
  };
  expect_error({"view", map_, "--listen", "0.0.0.0"}, 2, "token is needed");
  expect_error({"view", map_, "--listen", "nowhere"}, 2, "no address");
  expect_error({"view", map_, "--token", "short"}, 2, "8 characters");
  expect_error({"view", map_, "--speed", "-1"}, 2, "--speed");
  expect_error({"view", map_, "--port", "70000"}, 2, "--port");
  expect_error({"view", *dir_ / "nothing"}, 1, "nothing");
  expect_error({"view", log_, "--log", log_}, 2, "--log");
  expect_error({"view", "/dev/stdin"}, 2, "a pipe can be read once only");
  expect_error({"map", log_, "-o", *dir_ / "x", "--view", "--pipeline", "scan_to_scan"}, 2,
               "--view");
  expect_error({"map", log_, "-o", *dir_ / "x", "--port", "0"}, 2, "are of --view");
  const ProgramResult taken = view({"view", map_, "--port", "0", "--no-open"}, [&](std::uint16_t
                                                                                       port) {
    const std::string number = std::to_string(port);
    expect_error({"view", map_, "--port", number}, 2, "port " + number + " of 127.0.0.1 is taken");
    const std::string out = *dir_ / "none";
    expect_error({"map", log_, "-o", out, "--view", "--port", number}, 2, "is taken");
    EXPECT_FALSE(std::filesystem::exists(out));
  });
  EXPECT_EQ(taken.exit_code, 0);
}

TEST_F(ViewCommand, ATokenIsPartOfTheAddress) {
  const ProgramResult result = view(
      {"view", map_, "--port", "0", "--no-open", "--token", "a secret!"}, [](std::uint16_t port) {
        WebClient http(port);
        EXPECT_EQ(http.get("/").status, 401);
        EXPECT_EQ(http.get("/?token=a%20secret%21").status, 200);
      });
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out, HasSubstr("?token=a%20secret%21"));
}

TEST_F(ViewCommand, ShowsWhereARobotThatIsLocalisedLiveMayBe) {
  const ProgramResult result = view(
      {"live", "--source", "replay:" + log_, "--speed", "4", "--map", map_, "--port", "0",
       "--no-open"},
      [](std::uint16_t port) {
        Viewer viewer(port);
        viewer.look_until([&] {
          return viewer.has("/particles") && viewer.has("/pose") &&
                 viewer.has("/loopstone/tiles") && viewer.has("/loopstone/status") &&
                 viewer.count("/particles") > 3;
        });
        const auto particles = viewer.message<msg::PoseArray>("/particles");
        EXPECT_EQ(particles.header.frame_id, "map");
        EXPECT_GT(particles.poses.size(), 10U);
        const Json status = viewer.json("/loopstone/status");
        EXPECT_GE(status["figures"]["probability"].get<double>(), 0.0);
        EXPECT_GT(status["map_m2"].get<double>(), 10.0) << "the map is there from the beginning";
        WebClient http(port);
        EXPECT_EQ(Json::parse(http.get("/api/about").body)["mode"], "localizing");
      });
  EXPECT_EQ(result.exit_code, 0) << result.error;
}

TEST_F(ViewCommand, ShowsAMapThatIsMadeLive) {
  const std::string out = *dir_ / "live";
  const ProgramResult result =
      view({"live", "--source", "replay:" + log_, "--speed", "20", "-o", out, "--port", "0",
            "--no-open"},
           [](std::uint16_t port) {
             Viewer viewer(port);
             viewer.look_until([&] {
               return viewer.has("/pose") && viewer.count("/loopstone/tiles") > 2 &&
                      viewer.has("/loopstone/status") && viewer.has("/scan");
             });
             EXPECT_EQ(viewer.json("/loopstone/status")["status"], "tracked");
           });
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(Json::parse(dir_->read("live/summary.json"))["complete"], true);
}

TEST_F(ViewCommand, AMapThatIsPutRightInItIsPutRightByTheSavedEditsToo) {
  const std::string kept = *dir_ / "kept";
  ASSERT_EQ(run_program({"map", log_, "-o", kept, "--keep-state", "--quiet"}).exit_code, 0);
  const ProgramResult result =
      view({"view", kept, "--edit", "--port", "0", "--no-open"}, [&](std::uint16_t port) {
        Viewer viewer(port);
        viewer.look_until([&] { return viewer.has("/loopstone/trajectory"); });
        WebClient http(port);
        EXPECT_EQ(Json::parse(http.get("/api/about").body)["can_edit"], true);
        const Json edit{{"toml", "[[edit]]\nkind = \"ignore\"\nfrom_node = 10\nto_node = 20\n"}};
        const Json state = Json::parse(http.post("/api/edits", edit.dump()).body);
        ASSERT_EQ(state["edits"].size(), 1U);
        EXPECT_EQ(state["edits"][0]["applied"], true);
        EXPECT_EQ(Json::parse(http.post("/api/edits/save", "{}").body)["saved"], 1);
        for (int i = 0; i < 600; ++i) {
          const Json now = Json::parse(http.get("/api/edits").body);
          if (now["drawn"] == now["revision"]) return;
          std::this_thread::sleep_for(std::chrono::milliseconds(50));
        }
        FAIL() << "the map was not drawn";
      });
  EXPECT_EQ(result.exit_code, 0) << result.error;
  const ProgramResult edited = run_program(
      {"edit", kept, "--edits", kept + ".edits.toml", "-o", *dir_ / "edited", "--quiet"});
  EXPECT_EQ(edited.exit_code, 0) << edited.error;

  const ProgramResult refused = run_program({"view", map_, "--edit", "--no-open", "--port", "0"});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.error, HasSubstr("--keep-state"));
  EXPECT_EQ(run_program({"view", log_, "--edit"}).exit_code, 2);
}

}  // namespace
}  // namespace loopstone::test
