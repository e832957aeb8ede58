#pragma once

#include <array>
#include <cassert>
#include <cstdint>
#include <vector>

#include "core/rational.hpp"

namespace mien {

/// 8-bit picture, rows from the top, channels interleaved: 1 (grey), 3 (RGB) or 4 (RGBA), sRGB-encoded.
struct Image {
    int width = 0;
    int height = 0;
    int channels = 3;
    std::vector<std::uint8_t> pixels;

    Image() = default;
    Image(int w, int h, int c) : width(w), height(h), channels(c), pixels(std::size_t(w) * h * c) {}
    std::uint8_t* at(int x, int y) { return pixels.data() + (std::size_t(y) * width + x) * channels; }
    const std::uint8_t* at(int x, int y) const { return pixels.data() + (std::size_t(y) * width + x) * channels; }
};

/// 2-D float map, rows from the top, channels interleaved, linear values.
struct FloatMap {
    int width = 0;
    int height = 0;
    int channels = 1;
    std::vector<float> values;

    FloatMap() = default;
    FloatMap(int w, int h, int c) : width(w), height(h), channels(c), values(std::size_t(w) * h * c) {}
    float* at(int x, int y) { return values.data() + (std::size_t(y) * width + x) * channels; }
    const float* at(int x, int y) const { return values.data() + (std::size_t(y) * width + x) * channels; }
};

/// The sRGB transfer curve (IEC 61966-2-1), both ways, on [0, 1].
float srgb_to_linear(float encoded);
float linear_to_srgb(float linear);

/// A decoded video picture as planes of 8 bits, still Y'CbCr; converted in the shader. The planes belong to `owner`'s maker.
struct YuvView {
    enum class Matrix : std::uint8_t { bt709, bt601 };
    /// Where the sample of a 2 x 2 chroma block lies: on its left column between the rows, in its middle, or on its top
    /// left luma sample. Chroma of full size has no siting.
    enum class Siting : std::uint8_t { left, centre, top_left };
    int width = 0, height = 0;                 ///< luma samples
    int chroma_width = 0, chroma_height = 0;   ///< samples of each chroma plane
    std::array<const std::uint8_t*, 3> planes{};
    std::array<int, 3> strides{};              ///< bytes per row
    Matrix matrix = Matrix::bt709;
    bool full_range = false;
    Siting siting = Siting::left;
};

/// Frames of a texture, read one at a time because a minute of 1024 x 1024 does not fit in memory.
class TextureSource {
public:
    virtual ~TextureSource() = default;
    virtual int width() const = 0;
    virtual int height() const = 0;
    virtual std::int64_t frames() const = 0;
    /// RGB. Cheap for ascending frame numbers; any order is allowed. Not thread-safe.
    virtual Result<Image> read(std::int64_t frame) = 0;
};

/// Interleaved PCM in [-1, 1].
struct Sound {
    int sample_rate = 48000;  ///< Hz
    int channels = 1;
    std::vector<float> samples;

    std::int64_t length() const { return std::int64_t(samples.size()) / channels; }  ///< samples per channel
    double seconds() const { return double(length()) / sample_rate; }
};

}  // namespace mien
