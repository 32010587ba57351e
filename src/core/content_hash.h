#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <type_traits>

namespace truescatter {

// A name for content: 160 bits (SHA-1), so that two contents never share one by chance. Values are taken by
// their bytes, which tells -0 from 0.
class ContentHash {
 public:
  ContentHash();
  ~ContentHash();
  ContentHash(const ContentHash&) = delete;
  ContentHash& operator=(const ContentHash&) = delete;

  void append(const void* bytes, std::size_t count);
  // A number.
  template <typename Number>
  requires std::is_arithmetic_v<Number>
  void append(Number value) { append(&value, sizeof(value)); }
  // The components of an Eigen vector of fixed size.
  template <typename Vector>
  requires(Vector::SizeAtCompileTime > 0) void append(const Vector& vector) {
    append(vector.data(), sizeof(typename Vector::Scalar) * Vector::SizeAtCompileTime);
  }
  // A text, with its length.
  void append(const std::string& text);

  // 40 hexadecimal digits of all that was appended. Once: nothing can be appended afterwards.
  std::string hex();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// ContentHash of a file's bytes, read piece by piece. Throws Error (input) that names the file if it cannot
// be read.
std::string hash_of_file(const std::filesystem::path& file);

}  // namespace truescatter
