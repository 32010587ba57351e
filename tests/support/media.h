#pragma once

#include "profile/medium.h"

namespace truescatter::test {

// Measured by Jensen et al. 2001, green.
inline const Medium kSkin1Green{0.17, 0.88, 1.3};
inline const Medium kMarbleGreen{0.0041, 2.62, 1.5};

}  // namespace truescatter::test
