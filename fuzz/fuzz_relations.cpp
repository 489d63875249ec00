#include "loopstone/formats/relations_file.hpp"
#include "refusal.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace loopstone;
  return fuzz::expect_work_or_refusal(fuzz::text_of(data, size), [&] {
    const std::vector<Relation> relations = parse_relations(fuzz::text_of(data, size));
    Trajectory trajectory;
    for (const Relation& relation : relations) {
      (void)trajectory.append(relation.from, {});
      (void)trajectory.append(relation.to, relation.from_T_to);
    }
    for (const auto order : {RelationErrorOrder::kMeasuredTimesInverseExpected,
                             RelationErrorOrder::kInverseExpectedTimesMeasured}) {
      (void)relations_error(trajectory, relations, order);
    }
  });
}
