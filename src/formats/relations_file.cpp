#include "loopstone/formats/relations_file.hpp"

#include "formats/atomic_file.hpp"
#include "formats/text_lines.hpp"
#include "loopstone/formats/decimal_stamp.hpp"
#include "loopstone/geometry/pose3.hpp"

namespace loopstone {

namespace {

Stamp parse_stamp(std::string_view word, const Location& location) {
  const auto stamp = parse_decimal_stamp(word);
  if (!stamp) throw DataError(location, "'" + std::string(word) + "' is not a time in seconds");
  return *stamp;
}

Relation parse_relation(std::string_view line, const Location& location) {
  const std::vector<std::string_view> words = split_words(line);
  if (words.size() != 8) {
    throw DataError(location,
                    "a relation has 8 numbers, t1 t2 x y z roll pitch yaw; this line has " +
                        std::to_string(words.size()));
  }
  double pose[6];
  for (std::size_t i = 0; i < 6; ++i) pose[i] = parse_finite(words[i + 2], location);
  const bool planar = pose[3] == 0.0 && pose[4] == 0.0;
  const Pose2 from_T_to = planar ? Pose2{pose[0], pose[1], wrap_angle(pose[5])}
                                 : project_to_plane(Pose3::from_roll_pitch_yaw(
                                       {pose[0], pose[1], pose[2]}, pose[3], pose[4], pose[5]));
  return {parse_stamp(words[0], location), parse_stamp(words[1], location), from_T_to};
}

}  // namespace

std::vector<Relation> parse_relations(std::string_view text, const std::string& path_for_errors) {
  std::vector<Relation> relations;
  for_each_line(text, [&](std::string_view line, std::int64_t number) {
    const std::string_view content = trim(line);
    if (content.empty() || content.front() == '#') return;
    relations.push_back(parse_relation(content, {path_for_errors, number, {}}));
  });
  if (relations.empty()) throw DataError({path_for_errors}, "holds no relation");
  return relations;
}

std::vector<Relation> read_relations(const std::string& path, const MemoryBudget& budget) {
  return parse_relations(read_whole_file(path, budget.most_text_bytes()), path);
}

}  // namespace loopstone
