#include "methods/method.h"

namespace truescatter {

// No scattering: exitance is irradiance (a BRDF). The baseline that every method must beat.
//
// Limits: constant light stays constant, it is the identity, and a mirrored frame gives the mirrored result,
// all exactly: nothing is computed.
Method none_method() {
  Method method;
  method.name = "none";
  method.title = "No scattering";
  method.source = "baseline";
  method.memory = {.bytes_per_pixel = 0.0};
  method.own_target = [](const Profile&, const Settings&) { return OwnTarget{}; };
  method.prepare = [](const MethodInputs& inputs) {
    return PreparedMethod{[](Passes&) {}, &inputs.frame.irradiance};
  };
  return method;
}

}  // namespace truescatter
