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

/// Sets the step of every lane that shrinks, by the first `frames` frames, encoded at the quality that has about the asked rate. What
/// quantiser step q its encoder takes there nobody tells, but its error does: an even quantiser of step q errs by q^2 / 12. Of not
/// shrinking at all, q, and its doubles or halves as long as these get better, that is taken with which weighted error times bits is
/// least (squared errors fall about as bits grow).
Result<void> choose_steps(TextureSource& source, TextureFill& fill, const std::vector<TextureLane*>& lanes, std::int64_t frames,
                          const Progress& progress);

}  // namespace mien::encoder
