#pragma once

#include <functional>
#include <optional>

#include "core/error.h"

namespace truescatter::test {

// The Error that `body` throws; nothing if it returns. Any other exception passes through and fails the test.
inline std::optional<Error> error_of(const std::function<void()>& body) {
  try {
    body();
  } catch (const Error& error) {
    return error;
  }
  return std::nullopt;
}

}  // namespace truescatter::test
