#pragma once

#include <vector>

#include "media/colour.hpp"

namespace mien::encoder {

/// Takes detail out of what is little seen before an encoder sees it, for encoders that quantise every block alike.
///
/// With a step `q` for everything, a block of weight w < 1 should have had the step q / sqrt(w) (texture_regions): its error may have
/// a variance that is q^2 (1 / w - 1) / 12 larger. What such a step would have lost is mostly detail smaller than itself. So the
/// coefficients c of the block's 8 x 8 cosine transform shrink by t^2 / |c| with t^2 = q^2 (1 / w - 1), none through zero
/// (the positive-part estimator of James and Stein 1961 for a single coefficient): what is small goes, what is large stays, and
/// nothing jumps from frame to frame. Within a group that is done to what has changed since the frame before, as the coarser step
/// would have been taken to what a skin that lies still in its atlas leaves to code: what changes little stands still and costs nothing.
/// This ends at sixteen times the step.
class TextureShrink {
public:
    /// weights: width * height, mean 1; of a picture whose coded size may be larger.
    TextureShrink(const std::vector<float>& weights, int width, int height);

    /// Filters a picture of the coded size, in place. step: of the encoder, in grey levels of an orthonormal transform. before: what the
    /// frame before it became, null at the start of a group.
    void apply(media::YuvImage& picture, double step, const media::YuvImage* before) const;

private:
    struct Plane {
        int across = 0, down = 0;  ///< whole blocks
        std::vector<float> excess;  ///< 1 / w - 1 of each
    };
    Plane luma_, chroma_;
};

}  // namespace mien::encoder
