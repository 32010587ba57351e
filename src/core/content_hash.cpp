#include "core/content_hash.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <openssl/evp.h>

#include <array>
#include <cassert>
#include <fstream>
#include <vector>

#include "core/error.h"

namespace truescatter {

namespace {

// OpenSSL fails where memory is out, or where an administrator has forbidden SHA-1.
void check(int ok) {
  if (ok != 1) throw_run_error("OpenSSL cannot compute SHA-1");
}

}  // namespace

struct ContentHash::State {
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context{EVP_MD_CTX_new(), EVP_MD_CTX_free};
  bool done = false;
};

ContentHash::ContentHash() : state_(std::make_unique<State>()) {
  check(EVP_DigestInit_ex(state_->context.get(), EVP_sha1(), nullptr));
}
ContentHash::~ContentHash() = default;

void ContentHash::append(const void* bytes, std::size_t count) {
  assert(!state_->done);
  if (count > 0) check(EVP_DigestUpdate(state_->context.get(), bytes, count));
}

void ContentHash::append(const std::string& text) {
  append(text.size());
  append(text.data(), text.size());
}

std::string ContentHash::hex() {
  assert(!state_->done);
  state_->done = true;
  std::array<unsigned char, 20> digest;
  unsigned int size = 0;
  check(EVP_DigestFinal_ex(state_->context.get(), digest.data(), &size));
  assert(size == digest.size());
  return fmt::format("{:02x}", fmt::join(digest, ""));
}

std::string hash_of_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  ContentHash hash;
  std::vector<char> block(1U << 20U);
  while (in.read(block.data(), static_cast<std::streamsize>(block.size())) || in.gcount() > 0)
    hash.append(block.data(), static_cast<std::size_t>(in.gcount()));
  if (!in.eof()) throw_input_error({file.string()}, "cannot read this file");
  return hash.hex();
}

}  // namespace truescatter
