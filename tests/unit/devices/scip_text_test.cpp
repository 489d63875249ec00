#include "devices/scip_text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace loopstone {
namespace {

using testing::HasSubstr;

std::string line(std::string_view text) { return std::string(text) + scip_checksum(text) + "\n"; }

std::vector<ScipReply> replies_of(std::string_view bytes, const std::string& echo = {}) {
  ScipReplies replies;
  replies.expect_echo(echo);
  replies.add(bytes);
  std::vector<ScipReply> all;
  while (auto reply = replies.next()) all.push_back(*std::move(reply));
  return all;
}

TEST(ScipText, ChecksumsAreThoseOfTheDocument) {
  EXPECT_EQ(scip_checksum("00"), 'P');
  EXPECT_EQ(scip_checksum("99"), 'b');
  EXPECT_EQ(scip_checksum("PROT:SCIP 2.0"), 'N');
  EXPECT_EQ(checked_line("00P"), "00");
  EXPECT_FALSE(checked_line("00Q"));
  EXPECT_FALSE(checked_line("P"));
  EXPECT_FALSE(checked_line(""));
}

TEST(ScipText, NumbersAreThoseOfTheDocument) {
  // Its examples of two, three and four characters.
  EXPECT_EQ(scip_number("CB"), 1234U);
  EXPECT_EQ(scip_number("1Dh"), 5432U);
  EXPECT_EQ(scip_number("m2@0"), 16000000U);
  EXPECT_EQ(scip_number("oooo"), (1U << 24) - 1);
  EXPECT_FALSE(scip_number("1D/"));
  EXPECT_FALSE(scip_number("1Dp"));
}

TEST(ScipText, RepliesEndWithAnEmptyLine) {
  const auto replies = replies_of("QT\n00P\n\nPP\r\n00P\r\nDMIN:20;1\r\n\r\nBM\n0");
  ASSERT_EQ(replies.size(), 2U);
  EXPECT_EQ(replies[0].echo, "QT");
  EXPECT_EQ(replies[0].status(), "00");
  EXPECT_EQ(replies[1].echo, "PP");
  EXPECT_EQ(replies[1].lines, (std::vector<std::string>{"00P", "DMIN:20;1"}));
}

TEST(ScipText, DamagedStatusIsNone) {
  EXPECT_EQ(replies_of("QT\n01P\n\n").at(0).status(), "");
  EXPECT_EQ(replies_of("QT\n\n").at(0).status(), "");
  EXPECT_EQ(replies_of("QT\n000@\n\n").at(0).status(), "");
}

TEST(ScipText, ANewScanEndsOneWithoutEnd) {
  const std::string echo = "MD0000000101000";
  const auto replies = replies_of(echo + "\n99b\nabc" + "\n" + echo + "\n99b\n\n", echo);
  ASSERT_EQ(replies.size(), 2U);
  EXPECT_EQ(replies[0].lines, (std::vector<std::string>{"99b", "abc"}));
  EXPECT_EQ(replies[1].lines, (std::vector<std::string>{"99b"}));
}

TEST(ScipText, NoiseWithoutEndIsCut) {
  ScipReplies replies;
  for (int i = 0; i < 100; ++i) replies.add(std::string(1000, 'x'));
  int cut = 0;
  while (replies.next()) ++cut;
  EXPECT_EQ(cut, 3);
  replies.add("\n\nQT\n00P\n\n");
  ScipReply last;
  while (auto reply = replies.next()) last = *std::move(reply);
  EXPECT_EQ(last.echo, "QT");
}

TEST(ScipText, FactsLeaveTheirSemicolonOut) {
  const auto facts = scip_facts(replies_of("VV\n00P\nPROT:SCIP 2.0;N\nSERI:a:b;" +
                                           std::string(1, scip_checksum("SERI:a:b")) + "\n\n")
                                    .at(0));
  ASSERT_TRUE(facts);
  EXPECT_EQ(facts->at("PROT"), "SCIP 2.0");
  EXPECT_EQ(facts->at("SERI"), "a:b");
  EXPECT_FALSE(scip_facts(replies_of("VV\n00P\nPROT:SCIP 2.1;N\n\n").at(0)));
  EXPECT_FALSE(scip_facts(replies_of("VV\n00P\nN\n\n").at(0)));
}

TEST(ScipText, CommandsAreWrittenAsTheDocumentSays) {
  ScipRequest request{.first_step = 44, .last_step = 725};
  EXPECT_EQ(request.command(), "MD0044072501000");
  request.characters = 2;
  request.interval = 3;
  EXPECT_EQ(request.command(), "MS0044072501300");
  request.intensities = true;
  request.characters = 3;
  EXPECT_EQ(request.command(), "ME0044072501300");
}

/// 25 beams of three characters: a line of 64 and one of 11.
std::string scan_text(const ScipRequest& request) {
  std::string data;
  for (int i = 0; i < request.beams(); ++i) {
    const int number = 1000 + i;
    for (int k = 2; k >= 0; --k) data += static_cast<char>((number >> (6 * k) & 63) + 48);
  }
  std::string text = request.command() + "\n" + line("99") + line("0012");
  for (std::size_t at = 0; at < data.size(); at += 64) text += line(data.substr(at, 64));
  return text + "\n";
}

TEST(ScipText, ScansAreDecodedAcrossTheirLines) {
  const ScipRequest request{.first_step = 0, .last_step = 24};
  const std::string text = scan_text(request);
  EXPECT_EQ(text.size(), request.scan_bytes());
  const auto scan = decode_scip_scan(replies_of(text).at(0), request);
  ASSERT_TRUE(scan);
  EXPECT_EQ(scan->stamp_ms, 64U + 2U);
  ASSERT_EQ(scan->ranges.size(), 25U);
  for (std::uint32_t i = 0; i < 25; ++i) EXPECT_EQ(scan->ranges[i], 1000U + i);
}

TEST(ScipText, AnyDamageOfAScanIsSeen) {
  const ScipRequest request{.first_step = 0, .last_step = 24};
  const std::string good = scan_text(request);
  const std::size_t status_at = good.find('\n') + 1;
  for (std::size_t at = status_at; at + 1 < good.size(); ++at) {
    std::string changed = good;
    changed[at] = static_cast<char>(changed[at] == '0' ? '1' : changed[at] - 1);
    std::string shorter = good;
    shorter.erase(at, 1);
    for (const std::string& bad : {changed, shorter}) {
      for (const ScipReply& reply : replies_of(bad))
        EXPECT_FALSE(reply.echo == request.command() && decode_scip_scan(reply, request))
            << "byte " << at;
    }
  }
  ScipRequest other = request;
  other.last_step = 25;
  EXPECT_FALSE(decode_scip_scan(replies_of(good).at(0), other));
}

TEST(ScipText, NumbersThatAreNoRangesAreTold) {
  const ScipRanges utm{23, 60000};
  EXPECT_FLOAT_EQ(utm.range_m(23), 0.023F);
  EXPECT_FLOAT_EQ(utm.range_m(60000), 60.0F);
  EXPECT_EQ(utm.range_m(60001), std::numeric_limits<float>::infinity());
  EXPECT_EQ(utm.range_m(65533), std::numeric_limits<float>::infinity());
  EXPECT_EQ(utm.range_m(1), std::numeric_limits<float>::infinity());
  for (const std::uint32_t bad : {0U, 2U, 3U, 4U, 5U, 22U})
    EXPECT_TRUE(std::isnan(utm.range_m(bad)));
  const ScipRanges urg{20, 5600};
  EXPECT_EQ(urg.range_m(0), std::numeric_limits<float>::infinity());
  EXPECT_EQ(urg.range_m(6), std::numeric_limits<float>::infinity());
  for (const std::uint32_t bad : {1U, 7U, 16U, 19U}) EXPECT_TRUE(std::isnan(urg.range_m(bad)));
}

TEST(ScipText, StatusesAreToldInWords) {
  EXPECT_EQ(words_of_status("XX", "0E"), "status 0E: it does not know the command");
  EXPECT_THAT(words_of_status("MD0000108001000", "04"), HasSubstr("last step is out of range"));
  EXPECT_THAT(words_of_status("MD0000108001000", "30"), HasSubstr("to check itself"));
  EXPECT_THAT(words_of_status("ME0000108001000", "55"), HasSubstr("switch it off and on"));
  EXPECT_THAT(words_of_status("BM", "01"), HasSubstr("laser has failed"));
  EXPECT_THAT(words_of_status("PP", "77"), HasSubstr("does not explain"));
  EXPECT_THAT(words_of_status("PP", ""), HasSubstr("damaged"));
}

}  // namespace
}  // namespace loopstone
