#pragma once

#include <memory>

#include "loopstone/localization/localization_map.hpp"

namespace loopstone::python {

/// A known map made ready.
struct KnownMap {
  std::shared_ptr<const LocalizationMap> map{};
};

}  // namespace loopstone::python
