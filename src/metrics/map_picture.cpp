#include "metrics/map_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "metrics/color_map.h"

namespace truescatter {
namespace {

// A 5 x 7 bitmap font for what a colour bar says; each row's five low bits, the leftmost highest.
struct Glyph {
  char character;
  std::array<std::uint8_t, 7> rows;
};

constexpr std::array<Glyph, 42> kFont = {
    {{'0', {14, 17, 19, 21, 25, 17, 14}}, {'1', {4, 12, 4, 4, 4, 4, 14}},
     {'2', {14, 17, 1, 6, 8, 16, 31}},    {'3', {14, 17, 1, 6, 1, 17, 14}},
     {'4', {2, 6, 10, 18, 31, 2, 2}},     {'5', {31, 16, 30, 1, 1, 17, 14}},
     {'6', {6, 8, 16, 30, 17, 17, 14}},   {'7', {31, 1, 2, 4, 8, 8, 8}},
     {'8', {14, 17, 17, 14, 17, 17, 14}}, {'9', {14, 17, 17, 15, 1, 2, 12}},
     {'.', {0, 0, 0, 0, 0, 12, 12}},      {'-', {0, 0, 0, 31, 0, 0, 0}},
     {'+', {0, 4, 4, 31, 4, 4, 0}},       {'|', {4, 4, 4, 4, 4, 4, 4}},
     {'A', {14, 17, 17, 31, 17, 17, 17}}, {'B', {30, 17, 17, 30, 17, 17, 30}},
     {'C', {14, 17, 16, 16, 16, 17, 14}}, {'D', {30, 17, 17, 17, 17, 17, 30}},
     {'E', {31, 16, 16, 30, 16, 16, 31}}, {'F', {31, 16, 16, 30, 16, 16, 16}},
     {'G', {14, 17, 16, 23, 17, 17, 14}}, {'H', {17, 17, 17, 31, 17, 17, 17}},
     {'I', {14, 4, 4, 4, 4, 4, 14}},      {'J', {1, 1, 1, 1, 17, 17, 14}},
     {'K', {17, 18, 20, 24, 20, 18, 17}}, {'L', {16, 16, 16, 16, 16, 16, 31}},
     {'M', {17, 27, 21, 21, 17, 17, 17}}, {'N', {17, 25, 21, 19, 17, 17, 17}},
     {'O', {14, 17, 17, 17, 17, 17, 14}}, {'P', {30, 17, 17, 30, 16, 16, 16}},
     {'Q', {14, 17, 17, 17, 21, 18, 13}}, {'R', {30, 17, 17, 30, 20, 18, 17}},
     {'S', {15, 16, 16, 14, 1, 1, 30}},   {'T', {31, 4, 4, 4, 4, 4, 4}},
     {'U', {17, 17, 17, 17, 17, 17, 14}}, {'V', {17, 17, 17, 17, 17, 10, 4}},
     {'W', {17, 17, 17, 21, 21, 27, 17}}, {'X', {17, 10, 4, 4, 4, 10, 17}},
     {'Y', {17, 17, 10, 4, 4, 4, 4}},     {'Z', {31, 1, 2, 4, 8, 16, 31}},
     {'_', {0, 0, 0, 0, 0, 0, 31}},       {'/', {1, 1, 2, 4, 8, 16, 16}}}};

constexpr int kGlyphAdvance = 6;

void draw_text(Image& image, int left, int top, std::string_view text, const Vec3d& color) {
  for (const char raw : text) {
    const char character = raw >= 'a' && raw <= 'z' ? static_cast<char>(raw - 'a' + 'A') : raw;
    const auto glyph =
        std::find_if(kFont.begin(), kFont.end(), [&](const Glyph& g) { return g.character == character; });
    for (int row = 0; glyph != kFont.end() && row < 7; ++row) {
      for (int column = 0; column < 5; ++column) {
        const bool set = ((glyph->rows[static_cast<std::size_t>(row)] >> (4 - column)) & 1U) != 0;
        const int x = left + column;
        const int y = top + row;
        if (set && x >= 0 && x < image.width() && y >= 0 && y < image.height()) image.set_rgb(x, y, color);
      }
    }
    left += kGlyphAdvance;
  }
}

int text_width(std::string_view text) { return kGlyphAdvance * static_cast<int>(text.size()) - 1; }

Vec3d color_of(MapKind kind, double value) {
  return kind == MapKind::magnitude ? magnitude_color(std::abs(value)) : signed_color(value);
}

constexpr int kBarHeight = 34;

// The bar below a map of height `top`.
void draw_bar(Image& picture, int top, MapKind kind, double range, const std::string& title) {
  const Vec3d ink(0.92, 0.92, 0.92);
  const ColorBar bar = color_bar(picture.width(), top);
  for (int y = top; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) picture.set_rgb(x, y, Vec3d::Constant(0.13));
  }
  for (int y = bar.top_px; y < bar.top_px + bar.height_px; ++y) {
    for (int x = 0; x < bar.width_px; ++x) {
      const double t = (x + 0.5) / bar.width_px;
      picture.set_rgb(bar.left_px + x, y, color_of(kind, kind == MapKind::magnitude ? t : 2.0 * t - 1.0));
    }
  }
  const double low = kind == MapKind::magnitude ? 0.0 : -range;
  const std::array<double, 3> ticks = {low, 0.5 * (low + range), range};
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    const std::string label = fmt::format("{:.3g}", ticks[i]);
    const int at = bar.left_px + static_cast<int>(static_cast<double>(i) * 0.5 * bar.width_px);
    const int left = std::clamp(at - text_width(label) / 2, 1, picture.width() - text_width(label) - 1);
    draw_text(picture, left, top + 25, label, ink);
  }
  draw_text(picture, bar.left_px, top + 3, title, ink);
}

}  // namespace

ColorBar color_bar(int map_width_px, int map_height_px) {
  const int margin = std::max(8, map_width_px / 16);
  return {margin, map_height_px + 13, std::max(0, map_width_px - 2 * margin), 9};
}

Image map_picture(const Image& map, const Image& mask, MapKind kind, double range, const std::string& title) {
  Image picture(map.width(), map.height() + kBarHeight, 3);
  for (int y = 0; y < map.height(); ++y) {
    for (int x = 0; x < map.width(); ++x) {
      const bool inside = mask.at(x, y, 0) != 0.0F;
      picture.set_rgb(x, y,
                      inside ? color_of(kind, luminance(map.rgb(x, y)) / range) : Vec3d::Constant(0.22));
    }
  }
  draw_bar(picture, map.height(), kind, range, title);
  return picture;
}

Image display_picture(const Image& rgb, double exposure) {
  Image picture(rgb.width(), rgb.height(), 3);
  for (int y = 0; y < rgb.height(); ++y) {
    for (int x = 0; x < rgb.width(); ++x) {
      const Vec3d v = rgb.rgb(x, y) * exposure;
      picture.set_rgb(x, y, {srgb_encode(v.x()), srgb_encode(v.y()), srgb_encode(v.z())});
    }
  }
  return picture;
}

double round_range(double value) {
  assert(value > 0.0);
  const double decade = std::pow(10.0, std::floor(std::log10(value)));
  for (const double step : {1.0, 2.0, 5.0}) {
    if (value <= step * decade * (1.0 + 1e-12)) return step * decade;
  }
  return 10.0 * decade;
}

}  // namespace truescatter
