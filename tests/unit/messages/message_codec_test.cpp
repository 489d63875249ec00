#include "loopstone/messages/message_codec.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <limits>

#include "filled_message.hpp"

namespace loopstone {
namespace {

using test::decoded;
using test::encoded;
using test::flat;
using test::for_each_message;

template <typename F>
std::string error_of(const F& f) {
  try {
    f();
  } catch (const MessageError& error) {
    return error.what();
  }
  return "no error";
}

RC_GTEST_PROP(MessageCodec, GivesBackWhatItWrote, ()) {
  const auto seed = *rc::gen::arbitrary<std::uint64_t>();
  for_each_message([&]<typename M>() {
    const M message = test::random_message<M>(seed);
    const std::string values = flat(message);
    RC_ASSERT(flat(decoded<M>(WireFormat::kRos1, encoded(WireFormat::kRos1, message))) == values);
    RC_ASSERT(flat(decoded<M>(WireFormat::kCdr, encoded(WireFormat::kCdr, message))) == values);
    RC_ASSERT(flat(decoded<M>(WireFormat::kCdr, test::big_endian_cdr(message))) == values);
  });
}

RC_GTEST_PROP(MessageCodec, UsesAMessageAgain, ()) {
  const auto seed = *rc::gen::arbitrary<std::uint64_t>();
  for_each_message([&]<typename M>() {
    M message = test::random_message<M>(seed + 1);
    const M wanted = test::random_message<M>(seed);
    MessageDecoder<M>(WireFormat::kCdr).decode(encoded(WireFormat::kCdr, wanted), message);
    RC_ASSERT(flat(message) == flat(wanted));
  });
}

TEST(MessageCodecDamage, WhereverAMessageEndsTooEarlyItIsRefused) {
  for_each_message([]<typename M>() {
    const M message = test::random_message<M>(7);
    M read;
    for (const WireFormat format : {WireFormat::kRos1, WireFormat::kCdr}) {
      const MessageDecoder<M> decoder(format);
      const std::string bytes = encoded(format, message);
      for (std::size_t size = 0; size < bytes.size(); ++size) {
        // A buffer of its own, so that a sanitizer sees what is read behind its end.
        const std::vector<char> part(bytes.begin(),
                                     bytes.begin() + static_cast<std::ptrdiff_t>(size));
        EXPECT_THROW(decoder.decode(part, read), MessageError) << MessageType<M>::name() << size;
      }
      EXPECT_NO_THROW(decoder.decode(bytes, read));
    }
    const std::string big = test::big_endian_cdr(message);
    const MessageDecoder<M> decoder(WireFormat::kCdr);
    EXPECT_THROW(decoder.decode(std::string_view(big).substr(0, big.size() - 1), read),
                 MessageError);
  });
}

TEST(MessageCodecDamage, AnyByteMayBeAnother) {
  for_each_message([]<typename M>() {
    for (const WireFormat format : {WireFormat::kRos1, WireFormat::kCdr}) {
      const MessageDecoder<M> decoder(format);
      const std::string bytes = encoded(format, test::random_message<M>(3));
      M read;
      for (std::size_t i = 0; i < bytes.size(); ++i) {
        std::string spoiled = bytes;
        spoiled[i] = '\xff';
        try {
          decoder.decode(spoiled, read);
        } catch (const MessageError& error) {
          EXPECT_LE(error.offset(), bytes.size());
        }
      }
    }
  });
}

TEST(MessageCodecDamage, EncapsulationsThatAreNotReadAreNamed) {
  std::string bytes = encoded(WireFormat::kCdr, msg::String{"a"});
  msg::String read;
  const auto error_with = [&](char representation) {
    bytes[1] = representation;
    return error_of([&] { read = decoded<msg::String>(WireFormat::kCdr, bytes); });
  };
  EXPECT_EQ(error_with(1), "no error");
  EXPECT_EQ(read.data, "a");
  for (const char list : {2, 3}) EXPECT_NE(error_with(list).find("PL_CDR"), std::string::npos);
  for (char second = 6; second <= 0xb; ++second) {
    EXPECT_NE(error_with(second).find("XCDR2"), std::string::npos);
  }
  EXPECT_NE(error_with(0x40).find("0x0040"), std::string::npos);
  EXPECT_NE(error_of([] { (void)decoded<msg::String>(WireFormat::kCdr, ""); }), "no error");
}

TEST(MessageCodecDamage, ALengthIsHeldAgainstTheBytesBeforeMemoryIsTaken) {
  using namespace std::string_view_literals;
  const auto refuses = []<typename M>(const M& /*any*/, std::string_view bytes) {
    return error_of([&] { (void)decoded<M>(WireFormat::kRos1, bytes); }) != "no error";
  };
  EXPECT_TRUE(refuses(msg::String{}, "\xff\xff\xff\xff"sv));
  EXPECT_TRUE(refuses(msg::LaserEcho{}, "\xff\xff\xff\xff"sv));
  EXPECT_TRUE(refuses(msg::LaserEcho{}, "\x02\0\0\0\1\2\3\4\5\6\7"sv));
  EXPECT_TRUE(refuses(msg::TFMessage{}, "\xff\xff\xff\x7f"sv));
  EXPECT_TRUE(
      refuses(msg::MarkerArray{}, "\x10\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0"sv));
}

TEST(MessageCodec, StringsOfCdrMayLackTheirNul) {
  using namespace std::string_view_literals;
  const auto read = [](std::string_view bytes) {
    return decoded<msg::String>(WireFormat::kCdr, bytes).data;
  };
  EXPECT_EQ(read("\0\1\0\0\0\0\0\0"sv), "");
  EXPECT_EQ(read("\0\1\0\0\1\0\0\0\0"sv), "");
  EXPECT_EQ(read("\0\1\0\0\2\0\0\0ab"sv), "ab");
  EXPECT_EQ(read("\0\0\0\0\0\0\0\3ab\0"sv), "ab");
}

TEST(MessageCodec, PaddingOfCdrIsOptional) {
  const std::string bytes = encoded(WireFormat::kCdr, msg::String{"a"});
  for (std::size_t pad = 0; pad < 8; ++pad) {
    EXPECT_EQ(decoded<msg::String>(WireFormat::kCdr, bytes + std::string(pad, '\0')).data, "a");
  }
  EXPECT_NE(error_of([&] {
              (void)decoded<msg::String>(WireFormat::kCdr, bytes + std::string(8, '\0'));
            }).find("behind its end"),
            std::string::npos);
  EXPECT_THROW((void)decoded<msg::String>(WireFormat::kRos1,
                                          encoded(WireFormat::kRos1, msg::String{"a"}) + "b"),
               MessageError);
}

TEST(MessageCodec, TimesThatDoNotFitAreRefused) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  std::string bytes;
  const auto refused = [&](WireFormat format, std::int64_t seconds) {
    return error_of([&] { encode_message(format, msg::Clock{Stamp{seconds * kSecond}}, bytes); }) !=
           "no error";
  };
  EXPECT_FALSE(refused(WireFormat::kRos1, 0xffffffff));
  EXPECT_EQ(decoded<msg::Clock>(WireFormat::kRos1, bytes).clock.nanoseconds, 0xffffffff * kSecond);
  EXPECT_TRUE(refused(WireFormat::kRos1, 0x100000000));
  EXPECT_TRUE(refused(WireFormat::kRos1, -1));
  EXPECT_FALSE(refused(WireFormat::kCdr, 0x7fffffff));
  EXPECT_TRUE(refused(WireFormat::kCdr, 0x80000000));
  EXPECT_FALSE(refused(WireFormat::kCdr, -1));
  encode_message(WireFormat::kCdr, msg::Clock{Stamp{-1}}, bytes);
  EXPECT_EQ(decoded<msg::Clock>(WireFormat::kCdr, bytes).clock.nanoseconds, -1);
}

TEST(MessageCodec, TheHeaderIsReadAlone) {
  msg::Odometry message;
  message.header = {Stamp{5'000'000'006}, "odom"};
  for (const WireFormat format : {WireFormat::kRos1, WireFormat::kCdr}) {
    const std::string bytes = encoded(format, message);
    const auto header = decode_header(format, bytes);
    ASSERT_TRUE(header.has_value());
    EXPECT_EQ(header->stamp, message.header.stamp);
    EXPECT_EQ(header->frame_id, "odom");
    EXPECT_FALSE(decode_header(format, std::string_view(bytes).substr(0, 12)).has_value());
    EXPECT_FALSE(decode_header(format, {}).has_value());
  }
}

}  // namespace
}  // namespace loopstone
