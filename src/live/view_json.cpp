#include "live/view_json.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <nlohmann/json.hpp>

#include "loopstone/geometry/covariance.hpp"
#include "loopstone/sensor/scan_points.hpp"
#include "report/text.hpp"

namespace loopstone {
namespace {

using Json = nlohmann::ordered_json;

/// Texts need not be UTF-8; JSON must. A number that is not finite becomes null.
std::string text_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// Fewer digits than a double has are sent over and over.
double rounded(double value) {
  constexpr double kSteps = 1e4;
  return std::round(value * kSteps) / kSteps;
}

Json pose_json(const Pose2& pose) { return {pose.x, pose.y, pose.yaw}; }

template <typename T>
Json or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

double sigma_of(const Eigen::Matrix3d& covariance) {
  return largest_sigma(covariance.topLeftCorner<2, 2>());
}

std::string_view word_of(SubmapState state) {
  switch (state) {
    case SubmapState::kOpen:
      return "open";
    case SubmapState::kFrozen:
      return "frozen";
    case SubmapState::kDropped:
      break;
  }
  return "dropped";
}

Json scan_json(Stamp stamp, const std::shared_ptr<const MappedScan>& scan) {
  Json points = Json::array();
  if (scan) {
    for (const Eigen::Vector2d& point : scan_points(scan->scan, scan->robot_T_lidar)) {
      points.push_back(rounded(point.x()));
      points.push_back(rounded(point.y()));
    }
  }
  return {{"t", stamp.seconds()}, {"points", std::move(points)}};
}

Json closure_json(std::size_t id, const ViewClosure& shown) {
  const LoopClosure& closure = shown.closure;
  return {{"id", id},
          {"from", shown.from_node},
          {"to", shown.to_node},
          {"from_t", shown.from.seconds()},
          {"to_t", shown.to.seconds()},
          {"from_submap", closure.from_submap.index},
          {"to_submap", closure.to_submap.index},
          {"state", to_string(closure.state)},
          {"reason", to_string(closure.reason)},
          {"score", closure.score},
          {"second_score", or_null(closure.second_score)},
          {"overlap", closure.overlap},
          {"agreement", closure.agreement},
          {"chi2", or_null(closure.chi2)},
          {"sigma_m", sigma_of(closure.covariance)},
          {"by_appearance", closure.by_appearance}};
}

Json submap_json(std::size_t id, const ViewSubmap& submap) {
  Json outline = Json::array();
  for (const Eigen::Vector2f& point : submap.outline) {
    outline.push_back(rounded(point.x()));
    outline.push_back(rounded(point.y()));
  }
  return {{"id", id},
          {"state", word_of(submap.state)},
          {"pose", pose_json(submap.map_T_submap)},
          {"outline", std::move(outline)}};
}

/// Entry by entry: all of a day's list at once would be many times its text.
template <typename T>
std::string list_text(std::string_view name, std::span<const T> entries,
                      std::span<const std::size_t> places, Json (*json_of)(std::size_t, const T&)) {
  std::string text = fmt::format(R"({{"count":{},"{}":[)", entries.size(), name);
  for (const std::size_t place : places) {
    if (text.back() != '[') text += ',';
    text += text_of(json_of(place, entries[place]));
  }
  return text + "]}";
}

// Schemas: {"name": type}, where a type is a word of JSON schema.

Json type(const char* word) { return {{"type", word}}; }
Json number_or_null() { return {{"type", {"number", "null"}}}; }
Json list_of(Json items) { return {{"type", "array"}, {"items", std::move(items)}}; }
Json object_of(Json properties) {
  Json required = Json::array();
  for (const auto& [name, any] : properties.items()) required.push_back(name);
  return {{"type", "object"}, {"properties", std::move(properties)}, {"required", required}};
}
std::string schema_of(const char* title, Json properties) {
  Json schema = {{"$schema", "https://json-schema.org/draft/2020-12/schema"}, {"title", title}};
  schema.update(object_of(std::move(properties)));
  return schema.dump();
}

}  // namespace

std::string status_json(const ViewStatus& status) {
  return text_of({{"t", status.stamp.seconds()},
                  {"status", status.status},
                  {"scans", status.scans},
                  {"travelled_m", status.travelled_m},
                  {"submaps", status.submaps},
                  {"closures", status.closures},
                  {"rejected", status.rejected},
                  {"map_m2", status.map_m2},
                  {"realtime", status.realtime},
                  {"memory_mb", status.memory_mb},
                  {"figures", status.figures}});
}

std::string closures_json(std::span<const ViewClosure> closures,
                          std::span<const std::size_t> places) {
  return list_text("closures", closures, places, closure_json);
}

std::string submaps_json(std::span<const ViewSubmap> submaps, std::span<const std::size_t> places) {
  return list_text("submaps", submaps, places, submap_json);
}

std::string verdict_json(const ViewVerdict& verdict) {
  Json places = Json::array();
  for (const ViewPlace& place : verdict.places)
    places.push_back({{"x", place.where.x()}, {"y", place.where.y()}, {"text", place.text}});
  return text_of({{"verdict", verdict.verdict},
                  {"sentence", verdict.sentence},
                  {"reasons", verdict.reasons},
                  {"complete", verdict.complete},
                  {"places", std::move(places)}});
}

std::string warnings_json(std::span<const ViewWarning> warnings) {
  Json list = Json::array();
  for (const ViewWarning& warning : warnings) {
    list.push_back({{"t", warning.when ? Json(warning.when->seconds()) : Json(nullptr)},
                    {"text", warning.text}});
  }
  return text_of({{"warnings", std::move(list)}});
}

std::string layer_json(const ViewLayer& layer) {
  return text_of({{"x", layer.corner.x()},
                  {"y", layer.corner.y()},
                  {"resolution", layer.resolution_m},
                  {"png", base64(layer.png)}});
}

std::string evidence_json(std::size_t id, const ViewClosure& closure) {
  return text_of({{"id", id},
                  {"from", scan_json(closure.from, closure.from_scan)},
                  {"to", scan_json(closure.to, closure.to_scan)},
                  {"measured", pose_json(closure.closure.from_T_to)},
                  {"graph", pose_json(closure.from_T_to)}});
}

std::string status_schema() {
  return schema_of("loopstone status",
                   {{"t", type("number")},
                    {"status", type("string")},
                    {"scans", type("integer")},
                    {"travelled_m", type("number")},
                    {"submaps", type("integer")},
                    {"closures", type("integer")},
                    {"rejected", type("integer")},
                    {"map_m2", type("number")},
                    {"realtime", number_or_null()},
                    {"memory_mb", type("number")},
                    {"figures", {{"type", "object"}, {"additionalProperties", number_or_null()}}}});
}

std::string closures_schema() {
  Json states = Json::array();
  for (const std::string_view word : kWords<ClosureState>) states.push_back(word);
  return schema_of("loopstone closures", {{"count", type("integer")},
                                          {"closures", list_of(object_of({
                                                           {"id", type("integer")},
                                                           {"from", type("integer")},
                                                           {"to", type("integer")},
                                                           {"from_t", type("number")},
                                                           {"to_t", type("number")},
                                                           {"from_submap", type("integer")},
                                                           {"to_submap", type("integer")},
                                                           {"state", {{"enum", states}}},
                                                           {"reason", type("string")},
                                                           {"score", type("number")},
                                                           {"second_score", number_or_null()},
                                                           {"overlap", type("number")},
                                                           {"agreement", type("number")},
                                                           {"chi2", number_or_null()},
                                                           {"sigma_m", number_or_null()},
                                                           {"by_appearance", type("boolean")},
                                                       }))}});
}

std::string submaps_schema() {
  return schema_of(
      "loopstone submaps",
      {{"count", type("integer")},
       {"submaps", list_of(object_of({{"id", type("integer")},
                                      {"state", {{"enum", {"open", "frozen", "dropped"}}}},
                                      {"pose", list_of(type("number"))},
                                      {"outline", list_of(type("number"))}}))}});
}

std::string verdict_schema() {
  return schema_of(
      "loopstone verdict",
      {{"verdict", {{"enum", {"good", "doubtful", "bad", ""}}}},
       {"sentence", type("string")},
       {"reasons", list_of(type("string"))},
       {"complete", type("boolean")},
       {"places", list_of(object_of(
                      {{"x", type("number")}, {"y", type("number")}, {"text", type("string")}}))}});
}

std::string warnings_schema() {
  return schema_of(
      "loopstone warnings",
      {{"warnings", list_of(object_of({{"t", number_or_null()}, {"text", type("string")}}))}});
}

std::string layer_schema() {
  return schema_of("loopstone picture on the map", {{"x", type("number")},
                                                    {"y", type("number")},
                                                    {"resolution", type("number")},
                                                    {"png", type("string")}});
}

}  // namespace loopstone
