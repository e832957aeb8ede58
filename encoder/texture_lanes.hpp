#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/clip.hpp"
#include "core/progress.hpp"
#include "encoder/texture_fill.hpp"
#include "encoder/texture_shrink.hpp"
#include "media/video_encoder.hpp"

namespace mien::encoder {

/// What an encoder made of a clip's texture.
struct TextureRun {
    Bytes codec_config;
    std::vector<media::VideoPacket> packets;

    double kbps(Rational frame_rate, std::int64_t frames) const;
};

/// One rung on its way.
struct TextureLane {
    int width = 0, height = 0;              ///< texels, at most the source's
    media::VideoEncoderSettings settings;   ///< kbps: what the rate control is told to meet what is asked
    std::vector<float> weights;             ///< width * height, mean 1; empty: all texels alike
    std::shared_ptr<const TextureShrink> shrink;  ///< null: the encoder takes regions, or there are no weights
    double step = 0;                        ///< of the shrink
};

/// Reads the first `frames` frames of the texture once, fills their gaps and encodes them for all these lanes. Each has an encoder
/// and packets of its own, so the number of threads changes nothing.
Result<std::vector<TextureRun>> encode_lanes(TextureSource& source, TextureFill& fill, const std::vector<TextureLane*>& lanes,
                                             std::int64_t frames, const Progress& progress);

/// Mean weighted squared error of a run's luma, of the frames that it holds.
Result<double> weighted_error(TextureSource& source, TextureFill& fill, const TextureLane& lane, const TextureRun& run);

}  // namespace mien::encoder
