#include "graph_target.hpp"
#include "refusal.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace loopstone;
  return fuzz::expect_work_or_refusal(fuzz::text_of(data, size), [&] {
    const GraphFile file = parse_g2o(fuzz::text_of(data, size));
    // What was read can be written and read again.
    const GraphFile again = parse_g2o(format_g2o(file));
    if (again.ids != file.ids || again.landmark_ids != file.landmark_ids ||
        again.graph.edges.size() != file.graph.edges.size() ||
        again.graph.priors.size() != file.graph.priors.size() ||
        again.graph.landmark_edges.size() != file.graph.landmark_edges.size() ||
        again.graph.fixed != file.graph.fixed) {
      __builtin_trap();
    }
    fuzz::solve_graph(file);
  });
}
