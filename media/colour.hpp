#pragma once

#include <vector>

#include "core/image.hpp"

namespace mien::media {

enum class Chroma : std::uint8_t { quarter, full };  ///< 4:2:0, 4:4:4

/// A Y'CbCr picture of 8 bits that owns its planes. 4:2:0 chroma is sited left (between the rows, on the left
/// luma column), as MPEG-4, H.264, HEVC and AV1 take it when nothing is said.
struct YuvImage {
    int width = 0, height = 0;  ///< luma samples
    int chroma_width = 0, chroma_height = 0;
    std::vector<std::uint8_t> planes[3];  ///< tightly packed rows
    YuvView::Matrix matrix = YuvView::Matrix::bt709;
    bool full_range = false;

    YuvImage() = default;
    /// 4:2:0 needs even sizes.
    YuvImage(int w, int h, Chroma chroma, YuvView::Matrix matrix = YuvView::Matrix::bt709,
             bool full_range = false);
    YuvView view() const;
};

/// Converts `picture` (1, 3 or 4 channels; alpha is ignored) into `yuv`, whose size may be larger: the last
/// row and column are repeated. Integer-only, so every machine makes the same bytes. Chroma is filtered 1 2 1
/// across and 1 1 down.
void to_yuv(const Image& picture, YuvImage& yuv);

/// RGB by the picture's own matrix, range and siting; chroma is interpolated bilinearly, as a GPU's sampler
/// does.
Image to_rgb(const YuvView& picture);

}  // namespace mien::media
