#include "report/text.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace loopstone {
namespace {

TEST(ReportText, HtmlIsEscaped) {
  EXPECT_EQ(escape_html("<b a=\"1\" c='2'>&"), "&lt;b a=&quot;1&quot; c=&#39;2&#39;&gt;&amp;");
  EXPECT_EQ(escape_html("gr\xC3\xBC\xC3\x9F \xE2\x82\xAC"), "gr\xC3\xBC\xC3\x9F \xE2\x82\xAC");
  EXPECT_EQ(escape_html("a\xFF\x01z\xE2\x82"), "a\xEF\xBF\xBDz\xEF\xBF\xBD\xEF\xBF\xBD");
}

TEST(ReportText, Base64OfRfc4648) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64("\xFF\xEF"), "/+8=");
}

TEST(ReportText, NumbersForPeople) {
  EXPECT_EQ(with_thousands(0), "0");
  EXPECT_EQ(with_thousands(999), "999");
  EXPECT_EQ(with_thousands(-1000), "-1,000");
  EXPECT_EQ(with_thousands(12345678), "12,345,678");
  EXPECT_EQ(readable(0.0), "0");
  EXPECT_EQ(readable(0.012345), "0.0123");
  EXPECT_EQ(readable(9.994), "9.99");
  EXPECT_EQ(readable(9.996), "10.0");
  EXPECT_EQ(readable(-12.34), "-12.3");
  EXPECT_EQ(readable(99.96), "100");
  EXPECT_EQ(readable(1234.5), "1,235");
  EXPECT_EQ(readable(std::numeric_limits<double>::quiet_NaN()), "n/a");
  EXPECT_EQ(readable_time(8.61), "8.61 s");
  EXPECT_EQ(readable_time(59.96), "1 min 00 s");
  EXPECT_EQ(readable_time(2691.0), "44 min 51 s");
  EXPECT_EQ(readable_time(3661.0), "1 h 01 min");
  EXPECT_EQ(readable_bytes(100), "100 bytes");
  EXPECT_EQ(readable_bytes(1536), "1.5 KiB");
  EXPECT_EQ(readable_bytes(176160768), "168 MiB");
}

}  // namespace
}  // namespace loopstone
