#include "core/content_hash.h"

#include <OpenImageIO/hash.h>

#include <algorithm>
#include <cassert>
#include <cctype>

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

}  // namespace truescatter
