#pragma once

#include "core/hash.hpp"
#include "core/image.hpp"
#include "core/result.hpp"

namespace mien::media {

/// A JPEG or PNG picture in memory as RGB; alpha is dropped, grey spread, 16 bits rounded. Sides up to 8192.
Result<Image> decode_picture(ByteView bytes);

/// JPEG bytes of a picture, 4:4:4, nearly lossless: for static textures inside a model.
Result<Bytes> encode_jpeg(const Image& picture);

}  // namespace mien::media
