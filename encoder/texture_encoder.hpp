#pragma once

#include <optional>
#include <string>

#include "core/clip.hpp"
#include "core/progress.hpp"
#include "core/result.hpp"
#include "protocol/stream.hpp"

namespace mien::encoder {

struct TextureOptions {
    std::string codec = "h264";      ///< mpeg4, h264, hevc, av1
    std::optional<double> kbps;      ///< average; or else
    std::optional<double> quality;   ///< 0 worst .. 100 visually lossless, mapped to the codec's own scale
    std::string speed;               ///< the codec's own preset name; empty: a sane default
    std::int64_t group_frames = 30;  ///< closed groups aligned with motion; 0: the whole clip
};

struct EncodedTexture {
    protocol::TextureInfo info;
    Bytes codec_config;
    std::string codec;
    std::vector<protocol::Group> groups;  ///< slot 0; one object per frame, decoding order
};

/// Encodes clip.texture (not null). Texels outside the charts (clip.mask, else the neutral mesh's texture
/// triangles) are filled from the charts' edges so that nothing bleeds and gaps cost little.
Result<EncodedTexture> encode_texture(const Clip& clip, const TextureOptions& options,
                                      const Progress& progress = {});

/// Names that encode_texture takes and this build can really encode.
std::vector<std::string> texture_codecs();

}  // namespace mien::encoder
