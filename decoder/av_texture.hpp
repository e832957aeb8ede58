#pragma once

#include <memory>

#include "core/image.hpp"
#include "core/result.hpp"
#include "protocol/stream.hpp"

namespace mien::decoder {

/// One decoded texture picture; keeps its planes alive.
struct TextureFrame {
    std::int64_t frame = 0;  ///< number in the stream
    YuvView picture;
    std::shared_ptr<const void> owner;
};

/// Turns the objects of one texture rung into pictures. Not thread-safe.
class TextureDecoder {
public:
    /// threads: 0 lets the codec choose.
    static Result<TextureDecoder> create(const protocol::Track& track, const protocol::Rung& rung,
                                         int threads = 0);
    TextureDecoder(TextureDecoder&&) noexcept;
    TextureDecoder& operator=(TextureDecoder&&) noexcept;
    ~TextureDecoder();

    /// Drops what is inside; the next object starts a group whose first frame has number `first_frame`.
    void begin_group(std::int64_t first_frame);
    /// Feeds one object; gives the pictures that are ready, in presentation order.
    Result<std::vector<TextureFrame>> push(const protocol::Object& object);
    /// The group of `frames` frames is over: gives the pictures still inside. When fewer objects came, because the file or the
    /// line ended, those are dropped: objects come in decoding order, and without all of them nobody knows whose frames they are.
    Result<std::vector<TextureFrame>> end_group(std::int64_t frames);

private:
    struct State;
    explicit TextureDecoder(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

/// RGB of a decoded picture, by its own matrix and range. The plain twin of the player's shader.
Image to_rgb(const YuvView& picture);

/// A static texture blob (JPEG or PNG bytes). RGB.
Result<Image> decode_picture(ByteView bytes);

}  // namespace mien::decoder
