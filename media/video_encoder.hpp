#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/hash.hpp"
#include "core/rational.hpp"
#include "core/result.hpp"
#include "media/colour.hpp"

namespace mien::media {

/// The size that is really coded for `side` texels as shown: even, because chroma is halved, and at least 64,
/// because some encoders take no less. What is added on the right and at the bottom is cut off after
/// decoding.
constexpr int coded_side(int side) {
    return side < 64 ? 64 : side + (side & 1);
}

/// A rectangle of the coded picture whose quantiser is finer or coarser than what the rate control would give it.
struct VideoRegion {
    int left = 0, top = 0, right = 0, bottom = 0;  ///< right and bottom not included
    double qp_offset = 0;                          ///< H.264's scale, six to a doubling of the step; < 0: finer
};

struct VideoEncoderSettings {
    std::string codec = "h264";  ///< mpeg4, h264, hevc, av1
    int width = 0, height = 0;   ///< coded size: coded_side() of the picture's
    Rational frame_rate{30, 1};
    std::optional<double> kbps;  ///< average over the clip; else
    /// 0 .. 100: x264 and x265 CRF 46 .. 12, AV1 CRF 63 .. 12, MPEG-4 quantiser 31 .. 2, below which its rate control does not go
    /// either; the others go on to kFinestQuality.
    double quality = 75;
    static constexpr double kFinestQuality = 125;
    std::string speed;  ///< the encoder's own preset; empty: ours
    std::int64_t key_interval = 30;  ///< frames from one forced key frame to the next, at most
    std::vector<VideoRegion> regions;  ///< of every picture; where they overlap the first counts; see takes_regions()
    bool full_range = false;         ///< BT.709 always; BT.709 primaries, sRGB transfer
};

struct VideoPacket {
    std::int64_t frame = 0;  ///< number of the picture in presentation order, from 0
    bool key = false;        ///< nothing after it in decoding order needs anything before it
    Bytes bytes;
};

/// Turns 4:2:0 pictures into packets through libavcodec. No packet after a key frame, in decoding order,
/// shows a picture before it: groups are closed. Thread counts are fixed here where they or their order change
/// the output; it is the same from run to run and for any number of processors with the same libraries.
class VideoEncoder {
public:
    /// Fails for unknown codecs (naming those available), presets and sizes.
    static Result<VideoEncoder> open(const VideoEncoderSettings& settings);
    VideoEncoder(VideoEncoder&&) noexcept;
    VideoEncoder& operator=(VideoEncoder&&) noexcept;
    ~VideoEncoder();

    /// Codec headers that are not in the packets.
    const Bytes& codec_config() const;
    /// Feeds one picture of the coded size; gives the packets that are ready, in decoding order.
    Result<std::vector<VideoPacket>> encode(const YuvImage& picture, bool key);
    Result<std::vector<VideoPacket>> finish();

    /// mpeg4, h264, hevc, av1: those of them that this build of FFmpeg encodes.
    static std::vector<std::string> available();

    /// Whether the codec's encoder heeds VideoEncoderSettings::regions; the others ignore them.
    static bool takes_regions(const std::string& codec);

private:
    struct State;
    explicit VideoEncoder(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace mien::media
