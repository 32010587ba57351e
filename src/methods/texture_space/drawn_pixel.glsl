// Which pixels a screen pass of texture space is for: all of the skin, or with CHARACTERS that of one character.
SAMPLER(irradiance);
#ifdef CHARACTERS
SAMPLER(character);  // r: its number from 1 on skin
uniform float drawn;

bool is_drawn(ivec2 p) { return read_texel(character, p).r == drawn; }
#else
bool is_drawn(ivec2 p) { return read_texel(irradiance, p).a > 0.0; }
#endif
