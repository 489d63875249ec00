#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "formats/carmen_line.hpp"
#include "formats/carmen_survey.hpp"
#include "loopstone/formats/log_reader.hpp"

namespace loopstone {

/// Times of the scans that a survey of a CARMEN log looks at, stretch by stretch of the file.
class CarmenTimesSample {
 public:
  struct Scan {
    CarmenTag tag = CarmenTag::kFlaser;
    CarmenTimes times{};
  };

  void begin_stretch() { stretches_.emplace_back(); }
  /// Of a lidar that several tags report only the first tag counts.
  void add(const CarmenScan& scan);

  [[nodiscard]] const std::vector<std::vector<Scan>>& stretches() const { return stretches_; }
  /// Whether the first scan is of a laser that CARMEN drove at a serial line.
  [[nodiscard]] bool is_of_a_sick() const { return is_of_a_sick_; }

 private:
  std::vector<std::vector<Scan>> stretches_{};
  std::array<std::optional<CarmenTag>, kCarmenLidars> tags_{};
  std::optional<CarmenTag> first_{};
  bool is_of_a_sick_ = true;
};

/// Decides by the sample whose stamps are used, and fills what the survey says of it. The scans'
/// own stamps are given up when a fifth of the sample would be lost by them; then the logger's are
/// taken if they are better, else they are made up from the order of the file and a rate: that of
/// the stamps, if most of their steps can be those of a laser, else that of the logger's, else what
/// lasers of this kind usually have.
void choose_stamps(const CarmenTimesSample& sample, StampUse wanted, CarmenSurvey& survey);

}  // namespace loopstone
