#include "graph_target.hpp"
#include "refusal.hpp"

// EDGE2 lines in both orders of their information: what is read in one, written as EDGE_SE2, is the
// same graph.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace loopstone;
  const std::string_view text = fuzz::text_of(data, size);
  for (const InformationOrder order :
       {InformationOrder::kGuess, InformationOrder::kG2o, InformationOrder::kToro}) {
    fuzz::expect_work_or_refusal(text, [&] {
      const GraphFile file = parse_g2o(text, "graph", order);
      const GraphFile again = parse_g2o(format_g2o(file));
      for (std::size_t i = 0; i < file.graph.edges.size(); ++i) {
        if (again.graph.edges[i].information != file.graph.edges[i].information) __builtin_trap();
      }
      fuzz::solve_graph(file);
    });
  }
  return 0;
}
