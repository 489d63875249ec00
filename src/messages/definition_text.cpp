#include "messages/definition_text.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "messages/hashes.hpp"

namespace loopstone {
namespace {

/// builtin_interfaces' Time and Duration are alike, and of ROS 2 only.
StructLayout builtin(Kind kind) {
  return {.name = kind == Kind::kTime ? "builtin_interfaces/Time" : "builtin_interfaces/Duration",
          .fields = {{.name = "sec", .kind = Kind::kInt32}, {"nanosec", Kind::kUint32}}};
}

bool is_builtin(Kind kind, WireFormat format) {
  return format == WireFormat::kCdr && (kind == Kind::kTime || kind == Kind::kDuration);
}

std::string type_of(const Layout& layout, const FieldLayout& field, WireFormat format) {
  if (field.kind == Kind::kStruct) return layout.structs[field.nested].name;
  if (is_builtin(field.kind, format)) return builtin(field.kind).name;
  return std::string(words_of(field.kind).msg);
}

std::string brackets_of(const FieldLayout& field) {
  return field.shape == Shape::kOne     ? ""
         : field.shape == Shape::kArray ? fmt::format("[{}]", field.count)
                                        : "[]";
}

/// The types that a type uses, in the order in which they are met.
void gather(const Layout& layout, const StructLayout& type, WireFormat format,
            std::vector<StructLayout>& used) {
  for (const FieldLayout& field : type.fields) {
    const bool is_struct = field.kind == Kind::kStruct;
    if (!is_struct && !is_builtin(field.kind, format)) continue;
    StructLayout part = is_struct ? layout.structs[field.nested] : builtin(field.kind);
    if (std::ranges::count(used, part.name, &StructLayout::name) > 0) continue;
    used.push_back(part);
    gather(layout, part, format, used);
  }
}

std::string text_of(const Layout& layout, const StructLayout& type, WireFormat format) {
  std::string text;
  for (const std::string& constant : type.constants) text += constant + "\n";
  for (const FieldLayout& field : type.fields) {
    text +=
        fmt::format("{}{} {}\n", type_of(layout, field, format), brackets_of(field), field.name);
  }
  return text;
}

std::string md5_of_struct(const Layout& layout, const StructLayout& type) {
  std::string text;
  for (const std::string& constant : type.constants) text += constant + "\n";
  for (const FieldLayout& field : type.fields) {
    text +=
        field.kind == Kind::kStruct
            ? fmt::format("{} {}\n", md5_of_struct(layout, layout.structs[field.nested]),
                          field.name)
            : fmt::format("{}{} {}\n", words_of(field.kind).msg, brackets_of(field), field.name);
  }
  if (!text.empty()) text.pop_back();
  return md5_of(text);
}

std::string json_of(const Layout& layout, const StructLayout& type) {
  constexpr int kArray = 48;
  constexpr int kSequence = 144;
  std::string fields;
  for (const FieldLayout& field : type.fields) {
    const bool nested = field.kind == Kind::kStruct || is_builtin(field.kind, WireFormat::kCdr);
    const int id = words_of(field.kind).rihs01 + (field.shape == Shape::kArray      ? kArray
                                                  : field.shape == Shape::kSequence ? kSequence
                                                                                    : 0);
    fields += fmt::format(
        R"({}{{"name": "{}", "type": {{"type_id": {}, "capacity": {}, "string_capacity": 0, )"
        R"("nested_type_name": "{}"}}}})",
        fields.empty() ? "" : ", ", field.name, id, field.shape == Shape::kArray ? field.count : 0,
        nested ? ros2_type(type_of(layout, field, WireFormat::kCdr)) : "");
  }
  return fmt::format(R"({{"type_name": "{}", "fields": [{}]}})", ros2_type(type.name), fields);
}

}  // namespace

std::string definition_text(const Layout& layout, WireFormat format) {
  std::vector<StructLayout> used;
  gather(layout, layout.message(), format, used);
  std::string text = text_of(layout, layout.message(), format);
  for (const StructLayout& type : used) {
    text += std::string(80, '=') + "\nMSG: " + type.name + "\n" + text_of(layout, type, format);
  }
  return text;
}

std::string md5_of(const Layout& layout) { return md5_of_struct(layout, layout.message()); }

std::string rihs01_of(const Layout& layout) {
  std::vector<StructLayout> used;
  gather(layout, layout.message(), WireFormat::kCdr, used);
  std::ranges::sort(used, {}, &StructLayout::name);
  std::string others;
  for (const StructLayout& type : used) {
    others += (others.empty() ? "" : ", ") + json_of(layout, type);
  }
  return "RIHS01_" + sha256_of(fmt::format(
                         R"({{"type_description": {}, "referenced_type_descriptions": [{}]}})",
                         json_of(layout, layout.message()), others));
}

}  // namespace loopstone
