#include "core/content_hash.h"

#include <gtest/gtest.h>

#include "core/vec.h"

namespace truescatter {
namespace {

std::string hash_of(const std::string& bytes) {
  ContentHash hash;
  hash.append(bytes.data(), bytes.size());
  return hash.hex();
}

// FIPS 180-2, appendix A, and the empty message.
TEST(ContentHash, IsSha1) {
  EXPECT_EQ(hash_of("abc"), "a9993e364706816aba3e25717850c26c9cd0d89d");
  EXPECT_EQ(hash_of("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "84983e441c3bd26ebaae4aa1f95129e5e54670f1");
  EXPECT_EQ(hash_of(std::string(1000000, 'a')), "34aa973cd4c4daa4f61eeb2bdbad27316534016f");
  EXPECT_EQ(hash_of(""), "da39a3ee5e6b4b0d3255bfef95601890afd80709");
}

TEST(ContentHash, TakesPiecesAsTheWhole) {
  ContentHash pieces;
  for (const double x : {1.0, -2.0, 3.5}) pieces.append(x);
  ContentHash whole;
  whole.append(Vec3d(1.0, -2.0, 3.5));
  EXPECT_EQ(pieces.hex(), whole.hex());
}

// Without their lengths both would be "abc".
TEST(ContentHash, TellsWhereATextEnds) {
  ContentHash a;
  a.append(std::string("ab"));
  a.append(std::string("c"));
  ContentHash b;
  b.append(std::string("a"));
  b.append(std::string("bc"));
  EXPECT_NE(a.hex(), b.hex());
}

}  // namespace
}  // namespace truescatter
