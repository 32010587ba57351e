#pragma once

#include "methods/method.h"

namespace truescatter {

// What others build on; its row in the registry is made from the same.
Method pscbf_method();

}  // namespace truescatter
