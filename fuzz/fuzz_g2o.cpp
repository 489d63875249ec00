#include <cstddef>
#include <cstdint>
#include <string_view>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/g2o.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const loopstone::GraphFile file =
        loopstone::parse_g2o({reinterpret_cast<const char*>(data), size});
    // What was read can be written and read again.
    const loopstone::GraphFile again = loopstone::parse_g2o(loopstone::format_g2o(file));
    if (again.ids != file.ids || again.landmark_ids != file.landmark_ids ||
        again.graph.edges.size() != file.graph.edges.size() ||
        again.graph.priors.size() != file.graph.priors.size() ||
        again.graph.landmark_edges.size() != file.graph.landmark_edges.size() ||
        again.graph.fixed != file.graph.fixed) {
      __builtin_trap();
    }
    loopstone::require_connected(file, "graph");
  } catch (const loopstone::DataError&) {
    // Damage is expected to be refused, and nothing worse.
  }
  return 0;
}
