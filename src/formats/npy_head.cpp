#include "formats/npy_head.hpp"

#include <optional>
#include <sstream>
#include <string_view>

#include "formats/npy.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

/// Reads the Python literal {'descr': '<f8', 'fortran_order': False, 'shape': (3, 4), } and nothing
/// more general.
class DictParser {
 public:
  DictParser(std::string_view text, const Location& where) : text_(text), where_(where) {}

  NpyHeader parse() {
    NpyHeader header;
    bool has_descr = false;
    bool has_order = false;
    bool has_shape = false;
    expect('{');
    while (!accept('}')) {
      const std::string_view key = quoted();
      expect(':');
      if (key == "descr") {
        take_descr(header);
        has_descr = true;
      } else if (key == "fortran_order") {
        header.fortran_order = boolean();
        has_order = true;
      } else if (key == "shape") {
        header.shape = tuple();
        has_shape = true;
      } else {
        fail("has an unknown key '" + std::string(key.substr(0, 24)) + "'");
      }
      if (!accept(',')) {
        expect('}');
        break;
      }
    }
    if (!has_descr || !has_order || !has_shape) fail("lacks descr, fortran_order or shape");
    check_size(header);
    return header;
  }

 private:
  [[noreturn]] void fail(const std::string& reason) const {
    throw DataError(where_, "the head of the array " + reason);
  }
  void skip_blanks() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\n')) ++at_;
  }
  bool accept(char wanted) {
    skip_blanks();
    if (at_ >= text_.size() || text_[at_] != wanted) return false;
    ++at_;
    return true;
  }
  void expect(char wanted) {
    if (!accept(wanted)) fail("is damaged: no '" + std::string(1, wanted) + "' where one belongs");
  }
  std::string_view quoted() {
    skip_blanks();
    const char quote = at_ < text_.size() ? text_[at_] : '\0';
    if (quote == '[') fail("describes records with named fields; only plain numbers are read");
    if (quote != '\'' && quote != '"') fail("is damaged: a quoted word is missing");
    const std::size_t end = text_.find(quote, at_ + 1);
    if (end == text_.npos) fail("is damaged: a quote is not closed");
    const std::string_view word = text_.substr(at_ + 1, end - at_ - 1);
    at_ = end + 1;
    return word;
  }
  bool boolean() {
    skip_blanks();
    const std::string_view rest = text_.substr(at_);
    const bool yes = rest.starts_with("True");
    if (!yes && !rest.starts_with("False")) fail("is damaged: fortran_order is not True or False");
    at_ += yes ? 4 : 5;
    return yes;
  }
  std::vector<std::int64_t> tuple() {
    std::vector<std::int64_t> sizes;
    expect('(');
    while (!accept(')')) {
      sizes.push_back(size());
      if (sizes.size() > 32) fail("has more than 32 dimensions");
      if (!accept(',')) {
        expect(')');
        break;
      }
    }
    return sizes;
  }
  std::int64_t size() {
    skip_blanks();
    std::int64_t value = 0;
    const std::size_t first = at_;
    for (; at_ < text_.size() && text_[at_] >= '0' && text_[at_] <= '9'; ++at_) {
      value = value * 10 + (text_[at_] - '0');
      if (value > (std::int64_t{1} << 48)) fail("has an impossible size in its shape");
    }
    if (at_ == first) fail("is damaged: the shape is not made of whole numbers");
    if (at_ < text_.size() && text_[at_] == 'L') ++at_;  // Python 2 wrote long integers so
    return value;
  }
  void take_descr(NpyHeader& header) {
    const std::string_view descr = quoted();
    const std::string shown(descr.substr(0, 24));
    if (descr.find('O') != descr.npos) {
      fail("is of type '" + shown + "': Python objects (pickles) are never read");
    }
    if (descr.size() != 3) fail("is of type '" + shown + "'; only numbers are read");
    const char order = descr[0];
    header.kind = descr[1];
    header.element_bytes = descr[2] - '0';
    const int bytes = header.element_bytes;
    const bool whole = (header.kind == 'i' || header.kind == 'u') &&
                       (bytes == 1 || bytes == 2 || bytes == 4 || bytes == 8);
    const bool real = header.kind == 'f' && (bytes == 2 || bytes == 4 || bytes == 8);
    const bool truth = header.kind == 'b' && bytes == 1;
    if (!whole && !real && !truth) fail("is of type '" + shown + "'; only numbers are read");
    header.big_endian = order == '>';
    if (order != '<' && order != '|' && order != '=' && order != '>') {
      fail("is of type '" + shown + "'; only numbers are read");
    }
  }
  void check_size(const NpyHeader& header) const {
    std::int64_t count = 1;
    for (const std::int64_t size : header.shape) {
      if (size != 0 && count > (std::int64_t{1} << 48) / size) fail("has an impossible shape");
      count *= size;
    }
  }

  std::string_view text_;
  const Location& where_;
  std::size_t at_ = 0;
};

}  // namespace

std::int64_t NpyHeader::count() const {
  std::int64_t product = 1;
  for (const std::int64_t size : shape) product *= size;
  return product;
}

NpyHeader parse_npy_dict(std::string_view text, const Location& where) {
  return DictParser(text, where).parse();
}

std::string npy_head(const std::string& descr, bool fortran_order,
                     std::span<const std::int64_t> shape) {
  std::ostringstream text;
  text << "{'descr': '" << descr << "', 'fortran_order': " << (fortran_order ? "True" : "False")
       << ", 'shape': (";
  for (std::size_t i = 0; i < shape.size(); ++i) text << (i == 0 ? "" : " ") << shape[i] << ',';
  std::string dict = text.str();
  if (shape.size() > 1) dict.pop_back();
  dict += "), }";
  constexpr std::size_t kFixed = 10;  // magic, version, length
  dict.append((64 - (kFixed + dict.size() + 1) % 64) % 64, ' ');
  dict += '\n';
  std::string head("\x93NUMPY\x01\x00", 8);
  head += static_cast<char>(dict.size() & 0xff);
  head += static_cast<char>(dict.size() >> 8);
  return head + dict;
}

}  // namespace loopstone
