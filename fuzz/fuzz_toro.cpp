#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string_view>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/g2o.hpp"

// EDGE2 lines in both orders of their information: what is read in one, written as EDGE_SE2, is the same graph.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using loopstone::InformationOrder;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  for (const InformationOrder order :
       {InformationOrder::kGuess, InformationOrder::kG2o, InformationOrder::kToro}) {
    try {
      const loopstone::GraphFile file = loopstone::parse_g2o(text, "graph", order);
      const loopstone::GraphFile again = loopstone::parse_g2o(loopstone::format_g2o(file));
      for (std::size_t i = 0; i < file.graph.edges.size(); ++i) {
        if (again.graph.edges[i].information != file.graph.edges[i].information) __builtin_trap();
      }
    } catch (const loopstone::DataError&) {
      // Damage is expected to be refused, and nothing worse.
    }
  }
  return 0;
}
