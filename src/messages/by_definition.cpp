#include "messages/by_definition.hpp"

namespace loopstone {

std::string read_text(WireReader& in, Kind kind) {
  return kind == Kind::kWstring ? in.wide_text() : std::string(in.text());
}

std::size_t read_count(WireReader& in, const Layout& layout, const FieldLayout& field) {
  if (field.shape == Shape::kOne) return 1;
  const std::size_t size = std::max<std::size_t>(words_of(field.kind).size, 1);
  if (field.shape == Shape::kArray) {
    if (field.count > in.remaining() / size) {
      throw MessageError(in.offset(), "the message ends within the array " + shown(field.name));
    }
    return field.count;
  }
  const bool is_empty = field.kind == Kind::kStruct && layout.structs[field.nested].fields.empty();
  const std::size_t count = in.count(is_empty ? 0 : size);
  return is_empty ? 0 : count;
}

void skip_elements(WireReader& in, const Layout& layout, const FieldLayout& field,
                   std::size_t count) {
  switch (field.kind) {
    case Kind::kString:
    case Kind::kWstring:
      for (std::size_t i = 0; i < count; ++i) (void)read_text(in, field.kind);
      return;
    case Kind::kTime:
    case Kind::kDuration:
      return in.skip(2 * count, 4);
    case Kind::kStruct:
      for (std::size_t i = 0; i < count; ++i) {
        for (const FieldLayout& inner : layout.structs[field.nested].fields) {
          skip_elements(in, layout, inner, read_count(in, layout, inner));
        }
      }
      return;
    default:
      in.skip(count, words_of(field.kind).size);
  }
}

}  // namespace loopstone
