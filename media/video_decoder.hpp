#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/hash.hpp"
#include "core/image.hpp"
#include "core/result.hpp"

namespace mien::media {

struct VideoPicture {
    YuvView picture;
    std::shared_ptr<const void> owner;  ///< keeps the planes alive
};

struct VideoDecoderSettings {
    std::string codec;                                ///< mpeg4, h264, hevc, av1
    ByteView codec_config;                            ///< only read during open()
    int width = 0, height = 0;                        ///< coded size; a picture of another size is refused
    YuvView::Matrix matrix = YuvView::Matrix::bt709;  ///< where the bitstream does not say
    bool full_range = false;
    int threads = 0;  ///< 0: two, without added delay; more decode several pictures at once, that many late
};

/// Turns packets from anywhere into pictures. Damage is an error, never a concealed picture. Not thread-safe.
class VideoDecoder {
public:
    static Result<VideoDecoder> open(const VideoDecoderSettings& settings);
    VideoDecoder(VideoDecoder&&) noexcept;
    VideoDecoder& operator=(VideoDecoder&&) noexcept;
    ~VideoDecoder();

    /// Forgets everything; the next packet is a key frame.
    void restart();
    /// Feeds one packet; gives the pictures that are ready, in presentation order.
    Result<std::vector<VideoPicture>> decode(ByteView packet);
    /// Gives the pictures still inside; restart() before the next packet.
    Result<std::vector<VideoPicture>> drain();

private:
    struct State;
    explicit VideoDecoder(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace mien::media
