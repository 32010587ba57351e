#include "core/image_codec.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <memory>

namespace truescatter {
namespace {

// Colours are written and read as they are, not divided or multiplied by a fourth channel.
constexpr const char* kUnassociatedAlpha = "oiio:UnassociatedAlpha";
// The time would be written otherwise: equal pictures are equal files.
constexpr const char* kDateTime = "DateTime";

OIIO::ImageSpec spec_of(const EncodeRequest& request) {
  OIIO::ImageSpec spec(request.width, request.height, static_cast<int>(request.channels.size()),
                       request.is_float ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT8);
  if (request.is_float) {
    spec.channelnames = request.channels;
    spec.attribute("compression", "zip");
    spec.attribute(kDateTime, "");
  } else {
    spec.attribute(kUnassociatedAlpha, 1);
  }
  for (const auto& [name, text] : request.texts) spec.attribute(name, text);
  return spec;
}

// Into memory: the library's writers close their files without looking whether the last bytes went in, which
// on a full disk leaves half a picture and no word of it.
std::string encode(const EncodeRequest& request, std::vector<unsigned char>& encoded) {
  OIIO::Filesystem::IOVecOutput memory;
  OIIO::Filesystem::IOProxy* proxy = &memory;
  OIIO::ImageSpec spec = spec_of(request);
  spec.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
  const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(request.file_name);
  if (!output) return "no writer for this image format: " + OIIO::geterror();
  if (!output->open(request.file_name, spec) || !output->write_image(spec.format, request.pixels) ||
      !output->close())
    return "cannot write image: " + output->geterror();
  encoded = memory.buffer();
  return "";
}

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
  static constexpr truescatter::ImageCodec kCodec = {truescatter::encode, truescatter::decode};
  return &kCodec;
}
