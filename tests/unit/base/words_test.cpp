#include "loopstone/base/words.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace loopstone {
namespace {

using testing::ElementsAre;

/// The table has an order of its own.
enum class Weather { kRain, kSun, kFog };

constexpr auto words_of(Weather /*any*/) {
  using enum Weather;
  return std::array{Word{kSun, "sun"}, Word{kRain, "rain"}, Word{kFog, "thick fog"}};
}

enum class WithoutTable { kA };

TEST(Words, ComeFromOneTableBothWays) {
  for (const auto& [value, word] : kWordTable<Weather>) {
    EXPECT_EQ(to_string(value), word);
    EXPECT_EQ(find_word<Weather>(word), value);
  }
  EXPECT_THAT(kWords<Weather>, ElementsAre("sun", "rain", "thick fog"));
}

TEST(Words, AreKnownWhenTheProgramIsCompiled) {
  static_assert(to_string(Weather::kFog) == "thick fog");
  static_assert(find_word<Weather>("rain") == Weather::kRain);
  static_assert(!find_word<Weather>("Rain"));
  static_assert(WithWords<Weather>);
  static_assert(!WithWords<WithoutTable>);
  static_assert(!WithWords<int>);
}

TEST(Words, OfNoEnumeratorAreUnknown) { EXPECT_EQ(to_string(static_cast<Weather>(3)), "unknown"); }

enum class Tide { kLow, kHigh };

constexpr auto words_of(Tide /*any*/) { return std::array{Word{Tide::kLow, "low"}}; }

enum class Wind { kCalm, kGale, kStorm };

constexpr auto words_of(Wind /*any*/) {
  return std::array{Word{Wind::kCalm, "calm"}, Word{Wind::kStorm, "storm"}};
}

enum class Moon { kNew, kFull };

constexpr auto words_of(Moon /*any*/) {
  return std::array{Word{Moon::kNew, "new"}, Word{Moon::kNew, "none"}};
}

TEST(Words, AForgottenEnumeratorDoesNotCompile) {
  static_assert(has_all_words<Weather>());
  static_assert(!has_all_words<Tide>(), "the last one has no word");
  static_assert(!has_all_words<Wind>(), "nor has one in the middle");
  static_assert(!has_all_words<Moon>(), "two words for one");
}

TEST(WordField, ReadsAndSetsItsField) {
  Weather weather = Weather::kSun;
  const WordField field(weather);
  EXPECT_EQ(*field, "sun");
  EXPECT_TRUE(field.set("thick fog"));
  EXPECT_EQ(weather, Weather::kFog);
  EXPECT_EQ(*field, "thick fog");
  EXPECT_FALSE(field.set("fog"));
  EXPECT_FALSE(field.set(""));
  EXPECT_EQ(weather, Weather::kFog) << "a refused word changes nothing";
  EXPECT_THAT(field.words(), ElementsAre("sun", "rain", "thick fog"));
}

}  // namespace
}  // namespace loopstone
