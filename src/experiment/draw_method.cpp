#include "experiment/draw_method.h"

#include "methods/passes.h"

namespace truescatter {

Image draw_method(const Method& method, const MethodInputs& inputs) {
  const PreparedMethod prepared = method.prepare(inputs);
  Passes passes(inputs.context);
  prepared.render(passes);
  inputs.context.check(method.name.c_str());
  return gpu::read_texture(inputs.context, *prepared.output, 3);
}

}  // namespace truescatter
