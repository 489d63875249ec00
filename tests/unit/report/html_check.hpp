#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace loopstone::test {

/// A page needs nothing else: no network, no script, no other file. Its pictures lie in it. Every
/// tag that is opened is closed.
inline void expect_self_contained(std::string html) {
  for (auto picture = html.find("data:image/png;base64,"); picture != std::string::npos;
       picture = html.find("data:image/png;base64,", picture)) {
    html.erase(picture, html.find('"', picture) - picture);
  }
  for (const char* outside : {"http", "//", "<script", "<link", "@import", "url(", "<iframe",
                              "src=\"/", "file:", "nan"}) {
    const auto at = html.find(outside);
    EXPECT_EQ(at, std::string::npos)
        << outside << " in: " << html.substr(at > 60 ? at - 60 : 0, 120);
  }
  std::vector<std::string> open;
  for (auto at = html.find('<'); at != std::string::npos; at = html.find('<', at + 1)) {
    const auto end = html.find('>', at);
    ASSERT_NE(end, std::string::npos);
    const bool closing = html[at + 1] == '/';
    const auto name_begin = at + (closing ? 2 : 1);
    const std::string name =
        html.substr(name_begin, html.find_first_of(" />\n", name_begin) - name_begin);
    if (html[end - 1] == '/' || name == "meta" || name == "img" || name == "br" ||
        name == "!DOCTYPE")
      continue;
    if (!closing) {
      open.push_back(name);
    } else {
      ASSERT_FALSE(open.empty());
      ASSERT_EQ(open.back(), name);
      open.pop_back();
    }
  }
  EXPECT_TRUE(open.empty());
}

}  // namespace loopstone::test
