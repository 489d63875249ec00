#include "messages/hashes.hpp"

#include <gtest/gtest.h>

namespace loopstone {
namespace {

TEST(TypeHashes, Md5IsThatOfRfc1321) {
  EXPECT_EQ(md5_of(std::string_view{}), "d41d8cd98f00b204e9800998ecf8427e");
  EXPECT_EQ(md5_of("message digest"), "f96b697d7cb7938d525a2f31aaf161d0");
  EXPECT_EQ(md5_of("1234567890123456789012345678901234567890123456789012345678901234567890123456789"
                   "0"),
            "57edf4a22be3c955ac49da2e2107b67a");
}

TEST(TypeHashes, Sha256IsThatOfFips180) {
  EXPECT_EQ(sha256_of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256_of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256_of("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
}

// Digits 0 of the lengths around a block's end, by Python's hashlib.
TEST(TypeHashes, TakeTextsAroundTheEndOfABlock) {
  EXPECT_EQ(md5_of(std::string(55, '0')), "d7fe636bd28e2ee2ba4d6c5898318699");
  EXPECT_EQ(sha256_of(std::string(55, '0')),
            "9f8ef876f51f5313c91cc3f6b8119af09d8bbdd72098fa149b2780eb3591d6be");
  EXPECT_EQ(md5_of(std::string(56, '0')), "ce992c2ad906967c63c3f9ab0c2294a9");
  EXPECT_EQ(sha256_of(std::string(56, '0')),
            "bd03ac1428f0ea86f4b83a731ffc7967bb82866d8545322f888d2f6e857ffc18");
  EXPECT_EQ(md5_of(std::string(63, '0')), "5703db92acb9d45e3975822c9206453f");
  EXPECT_EQ(sha256_of(std::string(63, '0')),
            "c7dc2d25e306355c97af916e8d50b27a948506a74c6b2dd1b29e2b63d0a3aa8c");
  EXPECT_EQ(md5_of(std::string(64, '0')), "10eab6008d5642cf42abd2aa41f847cb");
  EXPECT_EQ(sha256_of(std::string(64, '0')),
            "60e05bd1b195af2f94112fa7197a5c88289058840ce7c6df9693756bc6250f55");
  EXPECT_EQ(md5_of(std::string(65, '0')), "f8c702aaa8c658413a4efb3a614d7707");
  EXPECT_EQ(sha256_of(std::string(65, '0')),
            "e531ef0f962409170917abf9de3287afec23dd1c42c9e1fea66c5feab99e8f7c");
}

}  // namespace
}  // namespace loopstone
