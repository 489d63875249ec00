# cmake -D PAGE=viewer/built/index.html -D SOURCE=page.cpp -P EmbedPage.cmake
# Writes a C++ source whose view_page() gives the file's bytes.
file(READ "${PAGE}" bytes HEX)
string(LENGTH "${bytes}" digits)
math(EXPR size "${digits} / 2")
string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
string(REGEX REPLACE "((0x..,){20})" "    \\1\n" bytes "${bytes}")
file(
  WRITE "${SOURCE}"
  "// Made of ${PAGE} by cmake/EmbedPage.cmake.
#include \"live/page.hpp\"

namespace loopstone {
namespace {

constexpr unsigned char kPage[] = {
${bytes}
};

}  // namespace

std::string_view view_page() {
  return {reinterpret_cast<const char*>(kPage), ${size}};
}

}  // namespace loopstone
")
