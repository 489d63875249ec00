#include "loopstone/report/plan_outputs.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

using Json = nlohmann::json;
using testing::HasSubstr;

/// One room of 4 x 3 m with a door in its upper wall, and a thing.
VectorPlan small_plan() {
  VectorPlan plan;
  const auto segment = [&](double x0, double y0, double x1, double y1, PlanLayer layer) {
    plan.segments.push_back({.from = {x0, y0},
                             .to = {x1, y1},
                             .sigma_across_m = 0.002,
                             .sigma_yaw_rad = 0.001,
                             .sigma_from_m = 0.003,
                             .sigma_to_m = 0.004,
                             .layer = layer});
  };
  segment(0, 0, 4, 0, PlanLayer::kStructure);
  segment(4, 0, 4, 3, PlanLayer::kStructure);
  segment(4, 3, 2.5, 3, PlanLayer::kStructure);
  segment(1.5, 3, 0, 3, PlanLayer::kStructure);
  segment(0, 3, 0, 0, PlanLayer::kHidden);
  segment(1, 1, 2, 1, PlanLayer::kMovable);
  plan.rooms.push_back(
      {.outline = {{{{0, 0}, {4, 0}, {4, 3}, {0, 3}}},
                   {PlanSide::kWall, PlanSide::kWall, PlanSide::kDoor, PlanSide::kHidden}},
       .area_m2 = 12.0,
       .area_sigma_m2 = 0.02,
       .perimeter_m = 14.0,
       .doors = {0},
       .hidden_m = 3.0});
  plan.doors.push_back({.from = {2.5, 3.06},
                        .to = {1.5, 3.06},
                        .width_m = 1.0,
                        .width_sigma_m = 0.01,
                        .depth_m = 0.12,
                        .room = 0});
  plan.axes.push_back({.yaw_rad = 0.0, .sigma_rad = 0.001, .share = 1.0});
  return plan;
}

/// The entities of a DXF file, each as its pairs. An own small reader: group codes and values by
/// turns.
struct DxfEntity {
  std::string kind;
  std::multimap<int, std::string> pairs;
  [[nodiscard]] double number(int code) const { return std::stod(pairs.find(code)->second); }
  [[nodiscard]] std::string text(int code) const { return pairs.find(code)->second; }
};

std::vector<DxfEntity> parse_dxf(const std::string& text) {
  std::istringstream stream(text);
  std::string code;
  std::string value;
  std::string section;
  std::vector<DxfEntity> entities;
  bool names_section = false;
  while (std::getline(stream, code) && std::getline(stream, value)) {
    const int number = std::stoi(code);
    if (number == 0) {
      names_section = value == "SECTION";
      if (value == "ENDSEC") section.clear();
      if (section == "ENTITIES") entities.push_back({value, {}});
    } else if (names_section && number == 2) {
      section = value;
      names_section = false;
    } else if (section == "ENTITIES") {
      entities.back().pairs.emplace(number, value);
    }
  }
  EXPECT_EQ(value, "EOF");
  return entities;
}

TEST(PlanDxf, HasEveryPartOnItsLayer) {
  std::map<std::string, int> counts;
  for (const DxfEntity& entity : parse_dxf(format_plan_dxf(small_plan())))
    ++counts[entity.kind + " " + entity.text(8)];
  const std::map<std::string, int> expected{
      {"LINE STRUCTURE", 4}, {"LINE HIDDEN", 1},  {"LINE MOVABLE", 1}, {"LINE DOORS", 1},
      {"POLYLINE ROOMS", 1}, {"VERTEX ROOMS", 4}, {"SEQEND ROOMS", 1}, {"TEXT AREAS", 1}};
  EXPECT_EQ(counts, expected);
}

TEST(PlanDxf, KeepsCoordinatesInMetres) {
  const std::vector<DxfEntity> entities = parse_dxf(format_plan_dxf(small_plan()));
  const DxfEntity& second = entities[1];
  EXPECT_EQ(second.kind, "LINE");
  EXPECT_DOUBLE_EQ(second.number(10), 4.0);
  EXPECT_DOUBLE_EQ(second.number(20), 0.0);
  EXPECT_DOUBLE_EQ(second.number(11), 4.0);
  EXPECT_DOUBLE_EQ(second.number(21), 3.0);
  EXPECT_EQ(entities.back().text(1), "R1 12.00 m2");
}

TEST(PlanGeojson, ComesBackInMetres) {
  const GeoAnchor anchor{.latitude_deg = 48.26, .longitude_deg = 11.67, .bearing_deg = 30.0};
  const Json json = Json::parse(format_plan_geojson(small_plan(), anchor));
  EXPECT_EQ(json.at("type"), "FeatureCollection");
  std::map<std::string, int> layers;
  // An independent plane: metres of a degree by series (Snyder 1987, "Map projections", p. 24 f.).
  const double phi = radians(48.26);
  const double north_m = 111132.954 - 559.822 * std::cos(2 * phi) + 1.175 * std::cos(4 * phi);
  const double east_m =
      111412.84 * std::cos(phi) - 93.5 * std::cos(3 * phi) + 0.118 * std::cos(5 * phi);
  const auto in_map = [&](const Json& position) {
    const double east = (position.at(0).get<double>() - 11.67) * east_m;
    const double north = (position.at(1).get<double>() - 48.26) * north_m;
    const double turn = radians(30.0);  // of x, clockwise from north
    return Eigen::Vector2d(std::sin(turn) * east + std::cos(turn) * north,
                           -std::cos(turn) * east + std::sin(turn) * north);
  };
  for (const Json& feature : json.at("features")) {
    EXPECT_EQ(feature.at("type"), "Feature");
    ++layers[feature.at("properties").at("layer").get<std::string>()];
    if (feature.at("properties").at("layer") != "room") continue;
    const Json& ring = feature.at("geometry").at("coordinates").at(0);
    ASSERT_EQ(ring.size(), 5U);
    EXPECT_EQ(ring.front(), ring.back());
    EXPECT_LT((in_map(ring.at(2)) - Eigen::Vector2d(4.0, 3.0)).norm(), 0.0005);
    EXPECT_LT((in_map(ring.at(3)) - Eigen::Vector2d(0.0, 3.0)).norm(), 0.0005);
    EXPECT_EQ(feature.at("properties").at("sides"), Json({"wall", "wall", "door", "hidden"}));
    EXPECT_EQ(feature.at("properties").at("area_m2"), 12.0);
  }
  const std::map<std::string, int> expected{
      {"room", 1}, {"structure", 4}, {"hidden", 1}, {"movable", 1}, {"door", 1}};
  EXPECT_EQ(layers, expected);
}

TEST(LongitudeLatitude, GoesTheRightWay) {
  const GeoAnchor anchor{.latitude_deg = -33.9, .longitude_deg = 179.9999, .bearing_deg = 90.0};
  const Eigen::Vector2d here = longitude_latitude(anchor, {0.0, 0.0});
  EXPECT_NEAR(here.x(), 179.9999, 1e-12);
  EXPECT_NEAR(here.y(), -33.9, 1e-12);
  const Eigen::Vector2d east = longitude_latitude(anchor, {100.0, 0.0});  // across the date line
  EXPECT_LT(east.x(), -179.99);
  EXPECT_NEAR(east.y(), -33.9, 1e-7);
  const Eigen::Vector2d north = longitude_latitude(anchor, {0.0, 100.0});
  EXPECT_GT(north.y(), -33.9);
  EXPECT_NEAR(north.x(), 179.9999, 1e-12);
}

TEST(PlanSvg, IsInMillimetresWithYUpwardsOnThePaper) {
  const std::string svg = format_plan_svg(small_plan(), {.name = "A < B"});
  EXPECT_THAT(svg, HasSubstr("width=\"297mm\" height=\"210mm\" viewBox=\"0 0 297 210\""));
  EXPECT_THAT(svg, HasSubstr("A &lt; B"));
  EXPECT_THAT(svg, HasSubstr("1 : 50"));
  EXPECT_THAT(svg, HasSubstr("12.00 m²"));
  const std::size_t group = svg.find("id=\"structure\"");
  ASSERT_NE(group, std::string::npos);
  const std::regex line(R"(M([\d.]+) ([\d.]+)L([\d.]+) ([\d.]+))");
  std::smatch first;
  const std::string walls = svg.substr(group, svg.find("</g>", group) - group);
  ASSERT_TRUE(std::regex_search(walls, first, line));
  // 4 m at 1 : 50 are 80 mm; the first wall is the lowest, and farthest down the page.
  EXPECT_NEAR(std::stod(first[3]) - std::stod(first[1]), 80.0, 0.01);
  double lowest = 0.0;
  for (auto it = std::sregex_iterator(walls.begin(), walls.end(), line);
       it != std::sregex_iterator(); ++it) {
    lowest = std::max({lowest, std::stod((*it)[2]), std::stod((*it)[4])});
  }
  EXPECT_NEAR(std::stod(first[2]), lowest, 1e-9);
  for (const char* id : {"hidden", "movable", "doors", "rooms", "labels", "dimensions"})
    EXPECT_THAT(svg, HasSubstr("id=\"" + std::string(id) + "\""));
}

TEST(PlanPdf, HasObjectsWhereItsTableSays) {
  const std::string pdf = format_plan_pdf(small_plan(), {.name = "Büro (1)"});
  EXPECT_EQ(pdf.substr(0, 8), "%PDF-1.4");
  const std::size_t start = std::stoul(pdf.substr(pdf.rfind("startxref") + 10));
  std::istringstream table(pdf.substr(start));
  std::string word;
  int first = 0;
  int count = 0;
  table >> word >> first >> count;
  EXPECT_EQ(word, "xref");
  for (int i = 0; i < count; ++i) {
    std::size_t offset = 0;
    std::string generation;
    std::string kind;
    table >> offset >> generation >> kind;
    if (i == 0) continue;
    const std::string expected = std::to_string(i) + " 0 obj";
    EXPECT_EQ(pdf.substr(offset, expected.size()), expected);
  }
  EXPECT_THAT(pdf, HasSubstr("(B\\374ro \\0501\\051)"));
  const std::size_t stream = pdf.find("stream\n") + 7;
  const std::size_t length = std::stoul(pdf.substr(pdf.find("/Length ") + 8));
  EXPECT_EQ(pdf.substr(stream + length, 9), "endstream");
}

TEST(PlanOutputs, AreTheSameBytesEachTime) {
  EXPECT_EQ(format_plan_svg(small_plan(), {}), format_plan_svg(small_plan(), {}));
  EXPECT_EQ(format_plan_pdf(small_plan(), {}), format_plan_pdf(small_plan(), {}));
  EXPECT_EQ(format_plan_dxf(small_plan()), format_plan_dxf(small_plan()));
}

TEST(PlanOutputs, AreCalledAsTheirMapIs) {
  for (const char* path : {"office", "out/office", "out/office/", "./office.yaml", "a/office.site"})
    EXPECT_EQ(plan_name(path), "office") << path;
}

/// A wall along x, seen from below, in a map in memory.
MapResult map_with_a_wall() {
  const GridFrame frame{.resolution = 0.05, .columns = 120, .rows = 60};
  MapResult map;
  map.map.log_odds = Grid<float>(frame, -3.0F);
  map.map.observed = Grid<std::uint8_t>(frame, 1);
  for (int column = 10; column < 110; ++column) map.map.log_odds[{column, 40}] = 3.0F;
  return map;
}

TEST(PlanOfAMapInMemory, GoesThroughItsCells) {
  const VectorPlan plan = plan_of(map_with_a_wall(), nullptr);
  EXPECT_FALSE(plan.from_scans);
  ASSERT_FALSE(plan.segments.empty());
  EXPECT_NEAR(plan.segments.front().middle().y(), 2.02, 0.05);
  EXPECT_EQ(plan_of(map_with_a_wall(), MappedScans{}, {}).segments.size(), plan.segments.size());
}

TEST(PlanOfAMapInMemory, ThereIsNoneOfAMapThatCouldNotBeDrawn) {
  MapResult map = map_with_a_wall();
  map.map_failure = "the map is too large";
  try {
    (void)plan_of(map, nullptr);
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_STREQ(error.what(), "the map is too large");
  }
}

TEST(PlanOutputs, APlanOfNothingIsASheet) {
  EXPECT_THAT(format_plan_svg({}, {}), HasSubstr("</svg>"));
  EXPECT_TRUE(parse_dxf(format_plan_dxf({})).empty());
}

}  // namespace
}  // namespace loopstone
