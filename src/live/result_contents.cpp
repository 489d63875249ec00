#include <fmt/format.h>

#include <string_view>

#include "live/snapshot_contents.hpp"
#include "loopstone/base/thinned.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/report/quality_picture.hpp"
#include "report/quality_summary.hpp"
#include "report/written_states.hpp"

namespace loopstone {
namespace {

using Json = nlohmann::ordered_json;

double number_in(const Json& object, std::string_view name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_number() ? found->get<double>() : 0.0;
}

std::string text_in(const Json& object, std::string_view name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string{};
}

/// Parts that are certain to less than this are no place to look at [m].
constexpr double kLeastSigmaM = 0.1;

bool is_uncertain(const Json& part) { return number_in(part, "sigma_m") >= kLeastSigmaM; }

bool counts(const Json& region) {
  VisitContradiction one;
  one.wall_m = number_in(region, "wall_m");
  one.share = number_in(region, "share");
  one.apart_m = number_in(region, "apart_m");
  return is_contradiction(one);
}

/// Calls say(one) for each object of a list of that name, where there is one, that is one to tell.
template <typename IsOne, typename Say>
void add_places(const Json& quality, std::string_view name, std::vector<ViewPlace>& places,
                const IsOne& is_one, const Say& say) {
  const auto list = quality.find(name);
  if (list == quality.end() || !list->is_array()) return;
  for (const Json& one : *list) {
    if (!one.is_object() || !is_one(one)) continue;
    places.push_back({{number_in(one, "x_m"), number_in(one, "y_m")}, say(one)});
  }
}

}  // namespace

ViewVerdict verdict_of(const Json& quality, bool complete) {
  ViewVerdict verdict{.complete = complete};
  if (!quality.is_object()) return verdict;
  verdict.verdict = text_in(quality, "verdict");
  if (verdict.verdict == to_string(Verdict::kUnknown)) verdict.verdict.clear();
  verdict.sentence = text_in(quality, "sentence");
  if (const auto measures = quality.find("measures");
      measures != quality.end() && measures->is_object()) {
    for (const auto& [name, measure] : measures->items()) {
      const std::string word = measure.is_object() ? text_in(measure, "verdict") : std::string{};
      if (word == to_string(Verdict::kDoubtful) || word == to_string(Verdict::kBad))
        verdict.reasons.push_back(text_in(measure, "sentence"));
    }
  }
  add_places(quality, "contradictions", verdict.places, counts, [](const Json& one) {
    return fmt::format("two visits contradict each other over {:.1f} m of wall",
                       number_in(one, "wall_m"));
  });
  add_places(quality, "loose_parts", verdict.places, is_uncertain, [](const Json& one) {
    return fmt::format(
        "{:.0f} m of the path hang on {}: they may be off by {:.1f} m", number_in(one, "path_m"),
        number_in(one, "closures") > 0.0 ? "a single loop closure" : "no loop closure",
        number_in(one, "sigma_m"));
  });
  add_places(quality, "open_stretches", verdict.places, is_uncertain, [](const Json& one) {
    return fmt::format("a bare corridor of {:.0f} m, which may be {:.1f} m too long or too short",
                       number_in(one, "path_m"), number_in(one, "sigma_m"));
  });
  return verdict;
}

ViewVerdict verdict_of(const MapResult& result) {
  return verdict_of(quality_json(result), result.complete);
}

std::optional<ViewLayer> quality_layer_of(const MapResult& result) {
  const auto layer = draw_quality_layer(result.quality);
  if (!layer) return {};
  return ViewLayer{layer->corner, layer->resolution_m, encode_png(layer->image)};
}

void show_poses(ViewBoard& board, Stamp stamp, const MapResult& result, const MapSnapshot& last) {
  board.show_nodes(stamp, nodes_of(result, last));
  board.show_closures(stamp, closures_of(result, last));
  board.show_path(stamp, thinned(result.trajectory.poses(), kMostPathPoses));
  board.show_graph(stamp);
}

bool show_result(ViewBoard& board, Stamp stamp, const MapResult& result, const MapSnapshot& last) {
  show_poses(board, stamp, result, last);
  if (result.map_failure.empty()) {
    board.replace_tiles(stamp, result.map);
    board.show_grid(stamp, states_to_write(result.map));
  }
  board.show_verdict(stamp, verdict_of(result));
  const auto layer = quality_layer_of(result);
  if (layer) board.show_quality(stamp, *layer);
  return layer.has_value();
}

}  // namespace loopstone
