#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/clip.hpp"
#include "core/progress.hpp"
#include "core/result.hpp"
#include "protocol/stream.hpp"

namespace mien::encoder {

/// One quality of the texture track.
struct TextureRung {
    double kbps = 0;  ///< average
    int width = 0;    ///< texels across, the height in proportion; 0: as many as the clip's
};

struct TextureOptions {
    static constexpr std::size_t kMaxRungs = 16;  ///< a stream has slots for other tracks, too

    std::string codec = "h264";      ///< mpeg4, h264, hevc, av1
    std::optional<double> kbps;      ///< average; or else
    std::optional<double> quality;   ///< 0 worst .. 100 visually lossless, mapped to the codec's own scale
    std::vector<TextureRung> rungs;  ///< lowest rate first, instead of kbps and quality
    std::string speed;               ///< the codec's own preset name; empty: a sane default
    std::int64_t group_frames = 30;  ///< closed groups aligned with motion; 0: the whole clip
    bool weighted = true;            ///< bits go where viewers look; else to all texels alike
};

struct EncodedTextureRung {
    int width = 0, height = 0;  ///< texels
    std::optional<double> asked_kbps;
    double kbps = 0;            ///< what it came to: an encoder has a coarsest and a finest step
    Bytes codec_config;
    std::vector<protocol::Group> groups;  ///< slot 0; one object per frame, decoding order
};

struct EncodedTexture {
    protocol::TextureInfo info;
    std::string codec;
    std::vector<EncodedTextureRung> rungs;  ///< as asked; one without TextureOptions::rungs
};

/// Encodes clip.texture (not null). Texels outside the charts (clip.mask, else the neutral mesh's texture
/// triangles) are filled from the charts' edges so that nothing bleeds and gaps cost little. Bits go where
/// viewers look (texture_weights), through regions where the encoder takes them, else by taking detail from the rest (TextureShrink). All rungs are encoded while
/// the texture is read once; only those whose rate control misses are encoded again, together.
Result<EncodedTexture> encode_texture(const Clip& clip, const TextureOptions& options,
                                      const Progress& progress = {});

/// Names that encode_texture takes and this build can really encode.
std::vector<std::string> texture_codecs();

}  // namespace mien::encoder
