#include "loopstone/slam/decision_numbers.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <variant>

#include "loopstone/pipeline/site.hpp"
#include "loopstone/plan/extract_plan.hpp"
#include "loopstone/slam/map_editor.hpp"
#include "source_folder.hpp"

namespace loopstone {
namespace {

namespace fs = std::filesystem;

using testing::AnyOf;
using testing::StartsWith;

const fs::path kSource(LOOPSTONE_SOURCE_DIR);

TEST(DecisionNumbers, HaveAnOriginOfOneOfThreeKinds) {
  for (const NumberGroup& group : decision_numbers()) {
    for (const DecisionNumber& number : group.numbers) {
      EXPECT_THAT(number.origin, AnyOf(StartsWith("derived: "), StartsWith("measured by bench/"),
                                       StartsWith("chosen: ")))
          << group.name << "." << number.name;
      EXPECT_EQ(number.origin.find('\n'), std::string::npos) << number.name;
    }
  }
}

TEST(DecisionNumbers, AreFinite) {
  for (const NumberGroup& group : decision_numbers()) {
    for (const DecisionNumber& number : group.numbers) {
      const auto* real = std::get_if<double>(&number.value);
      EXPECT_TRUE(real == nullptr || std::isfinite(*real)) << group.name << "." << number.name;
    }
  }
}

TEST(DecisionNumbers, HaveNamesOfTheirOwn) {
  std::set<std::string> names;
  for (const NumberGroup& group : decision_numbers()) {
    EXPECT_FALSE(group.numbers.empty()) << group.name;
    for (const DecisionNumber& number : group.numbers) {
      const std::string name = group.name + "." + number.name;
      EXPECT_TRUE(names.insert(name).second) << name;
      EXPECT_EQ(name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_."), name.npos)
          << name;
    }
  }
}

/// A struct of numbers that nobody put on the list would be on no record.
TEST(DecisionNumbers, AreAllOnTheList) {
  std::size_t structs = 0;
  for (const char* const folder : {"include", "src"}) {
    for (const auto& entry : fs::recursive_directory_iterator(kSource / folder)) {
      if (!entry.is_regular_file()) continue;
      std::ifstream file(entry.path());
      for (std::string line; std::getline(file, line);) {
        if (line.starts_with("void visit_numbers(const ")) ++structs;
      }
    }
  }
  // Those of landmarks are on record where landmarks are mapped, landmark_numbers(), and those of
  // edits where a map was edited; those of plans in what `export --json` tells, and those of sites
  // in what `site show --json` does.
  EXPECT_EQ(decision_numbers().size() + edit_numbers().size() + plan_numbers().size() +
                site_numbers().size() + 1,
            structs)
      << "see decision_numbers.cpp";
}

TEST(DecisionNumbers, WereMeasuredByScriptsThatAreThere) {
  const std::string kMeasured = "measured by ";
  for (const NumberGroup& group : decision_numbers()) {
    for (const DecisionNumber& number : group.numbers) {
      if (!number.origin.starts_with(kMeasured)) continue;
      const std::size_t end = number.origin.find(':');
      const std::string script = number.origin.substr(kMeasured.size(), end - kMeasured.size());
      EXPECT_TRUE(fs::is_regular_file(kSource / script)) << number.name << ": " << script;
    }
  }
}

}  // namespace
}  // namespace loopstone
