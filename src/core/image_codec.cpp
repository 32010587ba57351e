#include "core/image_codec.h"

#include <OpenImageIO/imageio.h>

#include <memory>

namespace truescatter {
namespace {

// Colours are read as they are, not divided or multiplied by a fourth channel.
constexpr const char* kUnassociatedAlpha = "oiio:UnassociatedAlpha";
PictureHeader header_of(const OIIO::ImageSpec& spec) {
  PictureHeader header{
      spec.width, spec.height, spec.depth, spec.channelnames, spec.format.is_floating_point(), {}};
  // A file need not name them all.
  header.channels.resize(static_cast<std::size_t>(spec.nchannels));
  for (const OIIO::ParamValue& attribute : spec.extra_attribs) {
    if (attribute.type() == OIIO::TypeDesc::STRING)
      header.texts.emplace(attribute.name().string(), attribute.get_string());
  }
  return header;
}

std::string decode(const std::filesystem::path& path,
                   const std::function<float*(const PictureHeader&)>& storage) {
  OIIO::ImageSpec as_stored;
  as_stored.attribute(kUnassociatedAlpha, 1);
  const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::open(path.string(), &as_stored);
  if (!input) return "cannot read this image: " + OIIO::geterror();
  const OIIO::ImageSpec& spec = input->spec();
  float* pixels = storage(header_of(spec));
  if (pixels != nullptr && !input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, pixels))
    return "cannot read the pixels: " + input->geterror();
  return "";
}

}  // namespace
}  // namespace truescatter

extern "C" const truescatter::ImageCodec* truescatter_image_codec() {
  static constexpr truescatter::ImageCodec kCodec = {truescatter::decode};
  return &kCodec;
}
