#include "loopstone/base/robust_kernel.hpp"

#include <string>

#include "loopstone/base/error.hpp"

namespace loopstone {

RobustKernel robust_kernel_from(std::string_view name) {
  std::string known;
  for (const auto& [kernel_name, kernel] : kRobustKernelNames) {
    if (name == kernel_name) return kernel;
    known += (known.empty() ? "" : ", ") + std::string(kernel_name);
  }
  throw UsageError("robust kernel: '" + std::string(name) + "' is none of " + known);
}

}  // namespace loopstone
