#include "loopstone/formats/ucsd_pictures.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/image.hpp"
#include "support/temp_dir.hpp"

namespace loopstone::test {
namespace {

TEST(UcsdPictures, HaveTheNamesAndTheSamplesOfTheLayout) {
  const TempDir folder;
  UcsdPictures pictures{folder.path().string(), 23};
  pictures.make_folders();
  const ColourImage colour{2, 1, {1, 2, 3, 250, 251, 252}};
  const RawDepthImage depth{2, 2, {0, 513, 1023, 65535}};
  pictures.write_colour(0, colour);
  pictures.write_depth(41, depth);
  const Image read = read_image(folder / "dataRGBD/RGB23/rgb23_1.png");
  EXPECT_EQ(read.bytes, colour.rgb);
  EXPECT_EQ(read.channels, 3);
  const Image numbers = read_image(folder / "dataRGBD/Disparity23/disparity23_42.png");
  ASSERT_EQ(numbers.bytes_per_sample, 2);
  EXPECT_EQ(numbers.sample(0, 1), 513);
  EXPECT_EQ(numbers.sample(1, 0), 1023);
  EXPECT_EQ(numbers.sample(1, 1), 65535);

  pictures.holds_disparity = false;
  pictures.make_folders();
  pictures.write_depth(0, depth);
  EXPECT_EQ(read_image(folder / "dataRGBD/Depth23/depth23_1.png").bytes, numbers.bytes);
}

TEST(UcsdPictures, SayWhereTheyCantBeWritten) {
  const TempDir folder;
  folder.write("dataRGBD", "a file where a folder should be");
  const UcsdPictures pictures{folder.path().string()};
  EXPECT_THROW(pictures.make_folders(), DataError);
  EXPECT_THROW(pictures.write_colour(0, {1, 1, {0, 0, 0}}), DataError);
}

}  // namespace
}  // namespace loopstone::test
