#include <algorithm>
#include <charconv>
#include <map>

#include "messages/layout.hpp"

namespace loopstone {
namespace {

constexpr std::size_t kMostName = 128;
constexpr int kMostNested = 16;

bool starts_word(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_word(char c) { return starts_word(c) || (c >= '0' && c <= '9'); }

/// Words, numbers, strings and single characters, without comments, directives and annotations.
class Tokens {
 public:
  explicit Tokens(std::string_view text) : text_(text) { advance(); }

  [[nodiscard]] std::string_view peek() const { return token_; }
  [[nodiscard]] bool at_end() const { return token_.empty(); }
  std::string_view next() {
    const std::string_view token = token_;
    if (token.empty()) fail("ends in the middle");
    advance();
    return token;
  }
  bool accept(std::string_view wanted) {
    if (token_ != wanted) return false;
    advance();
    return true;
  }
  void expect(std::string_view wanted) {
    if (!accept(wanted)) fail("lacks a '" + std::string(wanted) + "'");
  }
  [[noreturn]] void fail(const std::string& what) const {
    throw MessageError(0, "the definition in IDL " + what + " at '" + shown(token_) + "'");
  }

 private:
  void advance() {
    token_ = raw();
    while (token_ == "@") {
      (void)raw();  // the annotation's name
      token_ = raw();
      if (token_ != "(") continue;
      int open = 1;
      while (open > 0 && !token_.empty()) {
        token_ = raw();
        open += token_ == "(" ? 1 : token_ == ")" ? -1 : 0;
      }
      token_ = raw();
    }
  }
  std::string_view raw() {
    skip_blanks();
    if (at_ >= text_.size()) return {};
    std::size_t end = at_ + 1;
    const char first = text_[at_];
    if (is_word(first)) {
      while (end < text_.size() && (is_word(text_[end]) || text_.substr(end, 2) == "::" ||
                                    text_.substr(end - 1, 2) == "::")) {
        ++end;
      }
    } else if (first == '"' || first == '\'') {
      while (end < text_.size() && text_[end] != first) end += text_[end] == '\\' ? 2 : 1;
      end = std::min(end + 1, text_.size());
    }
    const std::string_view token = text_.substr(at_, end - at_);
    at_ = end;
    return token;
  }
  void skip_blanks() {
    while (at_ < text_.size()) {
      const std::string_view rest = text_.substr(at_);
      std::size_t skipped = 0;
      if (rest.starts_with("//") || rest[0] == '#' || rest.starts_with("====") ||
          rest.starts_with("IDL: ")) {
        skipped = rest.find('\n');
      } else if (rest.starts_with("/*")) {
        skipped = rest.find("*/", 2);
        if (skipped != rest.npos) skipped += 2;
      } else if (std::string_view(" \t\r\n").find(rest[0]) != rest.npos) {
        skipped = 1;
      } else {
        return;
      }
      at_ = skipped == rest.npos ? text_.size() : at_ + skipped;
    }
  }

  std::string_view text_;
  std::size_t at_ = 0;
  std::string_view token_;
};

class IdlParser {
 public:
  explicit IdlParser(std::string_view text) : tokens_(text) {}

  std::vector<ParsedStruct> parse() {
    while (!tokens_.at_end()) definition(0);
    return std::move(types_);
  }

 private:
  void definition(int nested) {
    if (nested > kMostNested) tokens_.fail("nests too deep");
    if (tokens_.accept("module")) {
      const std::size_t outer = scope_.size();
      scope_ += std::string(tokens_.next().substr(0, kMostName)) + "/";
      tokens_.expect("{");
      while (!tokens_.accept("}")) definition(nested + 1);
      scope_.resize(outer);
    } else if (tokens_.accept("struct")) {
      structure();
    } else if (tokens_.accept("typedef")) {
      const ParsedField alias = member();
      aliases_[scope_ + alias.name] = alias;
    } else if (tokens_.accept("const")) {
      while (tokens_.peek() != ";") (void)tokens_.next();
    } else {
      tokens_.fail("has what is not read");
    }
    (void)tokens_.accept(";");
  }

  void structure() {
    ParsedStruct made{.name = canonical_type(scope_ + std::string(tokens_.next()))};
    tokens_.expect("{");
    while (!tokens_.accept("}")) {
      made.fields.push_back(member());
      tokens_.expect(";");
    }
    types_.push_back(std::move(made));
  }

  /// "sequence<float, 5> ranges" or "double covariance[36]".
  ParsedField member() {
    ParsedField field;
    if (tokens_.accept("sequence")) {
      tokens_.expect("<");
      element(field);
      if (field.shape != Shape::kOne) tokens_.fail("has arrays of arrays, which are not read,");
      if (tokens_.accept(",")) (void)tokens_.next();
      tokens_.expect(">");
      field.shape = Shape::kSequence;
    } else {
      element(field);
    }
    const std::string_view name = tokens_.next();
    if (!starts_word(name[0]) || name.size() > kMostName) tokens_.fail("has no name of a field");
    field.name = name;
    if (tokens_.accept("[")) {
      if (field.shape != Shape::kOne) tokens_.fail("has arrays of arrays, which are not read,");
      field.shape = Shape::kArray;
      field.count = whole(tokens_.next());
      tokens_.expect("]");
    }
    return field;
  }

  /// A type, with its typedef put in place.
  void element(ParsedField& field) {
    std::string type(tokens_.next().substr(0, 2 * kMostName));
    while (type == "unsigned" || type == "long" || type == "unsigned long") {
      const std::string_view more = tokens_.peek();
      if (more != "long" && more != "short" && more != "double") break;
      type += " " + std::string(tokens_.next());
    }
    if ((type == "string" || type == "wstring") && tokens_.accept("<")) {
      (void)tokens_.next();
      tokens_.expect(">");
    }
    for (const KindWords& kind : kKinds) {
      if (!kind.idl.empty() && (kind.idl == type || (kind.msg == type && type != "byte"))) {
        field.type = kind.msg;
        return;
      }
    }
    std::string name;
    for (const char c : type) {
      if (c != ':') {
        name += c;
      } else if (!name.empty() && name.back() != '/') {
        name += '/';
      }
    }
    // In the inner scope first.
    for (std::string scope = scope_;; scope.resize(scope.rfind('/', scope.size() - 2) + 1)) {
      if (const auto alias = aliases_.find(scope + name); alias != aliases_.end()) {
        field = alias->second;
        return;
      }
      if (scope.size() < 2) break;
    }
    field.type = canonical_type(name);
  }

  std::size_t whole(std::string_view word) const {
    std::uint32_t value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc{} || end != word.data() + word.size()) {
      tokens_.fail("has a size that is no whole number of 32 bits,");
    }
    return value;
  }

  Tokens tokens_;
  std::string scope_;
  std::map<std::string, ParsedField> aliases_;
  std::vector<ParsedStruct> types_;
};

}  // namespace

std::vector<ParsedStruct> parse_idl(std::string_view text) { return IdlParser(text).parse(); }

}  // namespace loopstone
