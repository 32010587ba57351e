#pragma once

#include <string>
#include <string_view>

namespace truescatter {

// A picture of a fit from its FIT.json: above, the profile R (solid) and its Gaussians S (dashed) against r;
// below, |R - S|, solid where S is too bright and dashed where it is too dark; both axes of both logarithmic,
// a colour for each channel. Its <desc> says by which program and commit the fit was made, where the fit
// does. Self-contained SVG. Throws Error (input) if the text is no FIT.json with a curve.
std::string fit_plot_svg(std::string_view fit_json);

}  // namespace truescatter
