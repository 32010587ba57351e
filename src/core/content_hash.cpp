#include "core/content_hash.h"

#include <OpenImageIO/hash.h>

#include <algorithm>
#include <cassert>
#include <cctype>
#include <fstream>
#include <vector>

#include "core/error.h"

namespace truescatter {

struct ContentHash::State {
  OIIO::SHA1 hash;
  bool done = false;
};

ContentHash::ContentHash() : state_(std::make_unique<State>()) {}
ContentHash::~ContentHash() = default;

void ContentHash::append(const void* bytes, std::size_t count) {
  assert(!state_->done);
  if (count > 0) state_->hash.append(bytes, count);
}

void ContentHash::append(const std::string& text) {
  append(text.size());
  append(text.data(), text.size());
}

std::string ContentHash::hex() {
  assert(!state_->done);
  state_->done = true;
  std::string digits = state_->hash.digest();
  std::transform(digits.begin(), digits.end(), digits.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return digits;
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
