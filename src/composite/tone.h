#pragma once

#include "core/vec.h"

namespace truescatter {

// How light becomes what a display shows, in linear units of its white, [0, 1].
//   linear: clipped at 1.
//   filmic: Narkowicz's fit of ACES (2015), y = x (2.51 x + 0.03) / (x (2.43 x + 0.59) + 0.14), clipped at 1,
//   which it reaches at x = 9.8: a soft shoulder, so that highlights on skin keep their shape.
enum class ToneCurve { linear, filmic };

// Negative light counts as none.
double tone(ToneCurve curve, double light);

}  // namespace truescatter
