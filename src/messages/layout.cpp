#include "messages/layout.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

namespace loopstone {
namespace {

constexpr std::size_t kMostText = std::size_t{1} << 20;
constexpr std::size_t kMostDepth = 32;

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool same_struct(const Layout& a, std::size_t in_a, const Layout& b, std::size_t in_b) {
  const auto& fields = a.structs[in_a].fields;
  const auto& others = b.structs[in_b].fields;
  return std::ranges::equal(fields, others, [&](const FieldLayout& one, const FieldLayout& two) {
    return same_name(one.name, two.name) && bytes_of(one.kind) == bytes_of(two.kind) &&
           one.shape == two.shape && (one.shape != Shape::kArray || one.count == two.count) &&
           (one.kind != Kind::kStruct || same_struct(a, one.nested, b, two.nested));
  });
}

std::optional<Kind> kind_of(std::string_view type) {
  if (type == "builtin_interfaces/Time") return Kind::kTime;
  if (type == "builtin_interfaces/Duration") return Kind::kDuration;
  for (std::size_t i = 0; i + 1 < kKinds.size(); ++i) {
    if (kKinds[i].msg == type) return static_cast<Kind>(i);
  }
  return std::nullopt;
}

class Linker {
 public:
  Linker(const std::vector<ParsedStruct>& types, WireFormat format)
      : types_(types), format_(format), done_(types.size()), active_(types.size(), false) {
    // Of types that are told twice the first counts.
    for (std::size_t i = 0; i < types.size(); ++i) {
      const std::string& name = types[i].name;
      places_.try_emplace(name, i);
      if (i > 0) short_names_.try_emplace(name.substr(name.rfind('/') + 1), i);
    }
  }

  Layout link() {
    if (types_.empty()) throw MessageError(0, "the definition is empty");
    layout_.root = place_of(0, 0).place;
    return std::move(layout_);
  }

 private:
  struct Linked {
    std::size_t place = 0;
    std::size_t depth = 0;
  };

  Linked place_of(std::size_t type, std::size_t level) {
    if (done_[type]) return *done_[type];
    if (active_[type])
      throw MessageError(0, "the definition of " + name_of(type) + " contains itself");
    if (level > kMostDepth) throw_deep();
    active_[type] = true;
    StructLayout made{.name = types_[type].name};
    std::size_t depth = 0;
    std::set<std::string_view> names;
    for (const ParsedField& parsed : types_[type].fields) {
      if (!names.insert(parsed.name).second) {
        throw MessageError(0, "the definition has two fields " + shown(parsed.name));
      }
      FieldLayout field{.name = parsed.name, .shape = parsed.shape, .count = parsed.count};
      if (const auto kind = kind_of(parsed.type)) {
        field.kind = *kind;
      } else {
        const Linked nested = place_of(find(parsed.type, types_[type].name), level + 1);
        field.kind = Kind::kStruct;
        field.nested = nested.place;
        depth = std::max(depth, nested.depth + 1);
      }
      if (depth > kMostDepth) throw_deep();
      if (!is_empty(field)) made.fields.push_back(std::move(field));
    }
    if (made.fields.empty() && format_ == WireFormat::kCdr) {
      made.fields.push_back({.name = std::string(kDummyField)});
    }
    active_[type] = false;
    layout_.structs.push_back(std::move(made));
    done_[type] = Linked{layout_.structs.size() - 1, depth};
    return *done_[type];
  }

  /// Whether it never has a byte.
  bool is_empty(const FieldLayout& field) const {
    if (field.shape == Shape::kSequence) return false;
    return (field.shape == Shape::kArray && field.count == 0) ||
           (field.kind == Kind::kStruct && layout_.structs[field.nested].fields.empty());
  }

  std::size_t find(std::string_view name, std::string_view user) const {
    if (name.find('/') != name.npos) {
      if (const auto at = places_.find(name); at != places_.end()) return at->second;
    }
    // Of the same package; that of the message itself is not told.
    const std::string package(user.substr(0, user.find('/') + 1));
    if (const auto at = places_.find(package + std::string(name)); at != places_.end()) {
      return at->second;
    }
    // Names of packages change: "Header" was roslib's once.
    const bool is_whole = name.find('/') != name.npos;
    const std::string_view short_name = is_whole ? name.substr(name.find('/') + 1) : name;
    const auto at = short_names_.find(short_name);
    if ((is_whole || package.empty()) && at != short_names_.end()) {
      return at->second;
    }
    throw MessageError(0, "the definition lacks the type " + shown(name));
  }

  std::string name_of(std::size_t type) const {
    return types_[type].name.empty() ? "the message" : shown(types_[type].name);
  }
  [[noreturn]] static void throw_deep() {
    throw MessageError(0, "the definition nests deeper than 32 types");
  }

  const std::vector<ParsedStruct>& types_;
  WireFormat format_;
  std::map<std::string, std::size_t, std::less<>> places_;
  std::map<std::string, std::size_t, std::less<>> short_names_;  ///< without their packages
  std::vector<std::optional<Linked>> done_;
  std::vector<bool> active_;
  Layout layout_;
};

}  // namespace

bool same_name(std::string_view a, std::string_view b) {
  return std::ranges::equal(a, b, {}, lower, lower);
}

std::string shown(std::string_view text) {
  constexpr std::size_t kMost = 60;
  std::string result(text.substr(0, kMost));
  for (char& c : result) {
    if (c < ' ' || c > '~') c = '?';
  }
  return result;
}

bool same_layout(const Layout& a, const Layout& b) { return same_struct(a, a.root, b, b.root); }

Layout link_types(const std::vector<ParsedStruct>& types, WireFormat format) {
  return Linker(types, format).link();
}

Layout parse_definition(WireFormat format, const MessageDefinition& definition) {
  if (definition.language == DefinitionLanguage::kNone) {
    throw MessageError(0, "there is no definition of the message");
  }
  if (definition.text.size() > kMostText) {
    throw MessageError(0, "the definition is longer than 1 MiB");
  }
  return link_types(definition.language == DefinitionLanguage::kRos2Idl
                        ? parse_idl(definition.text)
                        : parse_msg(definition.text, definition.language),
                    format);
}

}  // namespace loopstone
