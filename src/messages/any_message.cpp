#include <fmt/format.h>

#include "messages/by_definition.hpp"

namespace loopstone {
namespace {

class Teller {
 public:
  using Values = AnyMessageDecoder::Values;

  Teller(WireReader& in, const Layout& layout, std::size_t most_elements)
      : in_(in), layout_(layout), most_elements_(most_elements) {}

  Values tell() {
    tell_struct(layout_.root, {});
    in_.expect_end();
    return std::move(values_);
  }

 private:
  /// So that a hostile message does not become a thousand times its size.
  static constexpr std::size_t kMostValues = 20'000;

  void tell_struct(std::size_t type, const std::string& path) {
    for (const FieldLayout& field : layout_.structs[type].fields) {
      const std::string own = path.empty() ? field.name : path + "." + field.name;
      const std::size_t count = read_count(in_, layout_, field);
      std::size_t told = 0;
      if (field.shape == Shape::kOne) {
        tell_element(field, own);
        continue;
      }
      for (; told < std::min(count, most_elements_); ++told) {
        tell_element(field, fmt::format("{}[{}]", own, told));
      }
      skip_elements(in_, layout_, field, count - told);
    }
  }

  void tell_element(const FieldLayout& field, const std::string& path) {
    if (field.kind == Kind::kStruct) return tell_struct(field.nested, path);
    if (values_.numbers.size() + values_.strings.size() + values_.stamps.size() >= kMostValues ||
        field.name == kDummyField) {
      return skip_elements(in_, layout_, field, 1);
    }
    if (is_number(field.kind)) {
      values_.numbers[path] = read_number<double>(in_, field.kind);
    } else if (field.kind == Kind::kTime) {
      values_.stamps[path] = Stamp{in_.nanoseconds(false)};
    } else if (field.kind == Kind::kDuration) {
      values_.numbers[path] = Duration{in_.nanoseconds(true)}.seconds();
    } else {
      values_.strings[path] = read_text(in_, field.kind);
    }
  }

  WireReader& in_;
  const Layout& layout_;
  std::size_t most_elements_;
  Values values_;
};

}  // namespace

struct AnyMessageDecoder::Impl {
  WireFormat format;
  Layout layout;
};

AnyMessageDecoder::AnyMessageDecoder(WireFormat format, const MessageDefinition& definition)
    : impl_(new Impl{format, parse_definition(format, definition)}) {}

AnyMessageDecoder::~AnyMessageDecoder() = default;
AnyMessageDecoder::AnyMessageDecoder(AnyMessageDecoder&&) noexcept = default;
AnyMessageDecoder& AnyMessageDecoder::operator=(AnyMessageDecoder&&) noexcept = default;

AnyMessageDecoder::Values AnyMessageDecoder::decode(std::span<const char> bytes,
                                                    std::size_t most_elements) const {
  WireReader in(impl_->format, bytes);
  return Teller(in, impl_->layout, most_elements).tell();
}

}  // namespace loopstone
