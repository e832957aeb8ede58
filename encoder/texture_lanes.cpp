#include "encoder/texture_lanes.hpp"

#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"
#include "encoder/texture_scale.hpp"
#include "media/video_decoder.hpp"

namespace mien::encoder {
namespace {

Image as_rgb(Image picture) {
    if (picture.channels == 3) return picture;
    Image rgb(picture.width, picture.height, 3);
    for (std::size_t i = 0; i < std::size_t(rgb.width) * rgb.height; ++i)
        for (int c = 0; c < 3; ++c)
            rgb.pixels[3 * i + c] = picture.pixels[i * picture.channels + (picture.channels < 3 ? 0 : c)];
    return rgb;
}

/// A frame of the source, its gaps filled.
Result<Image> filled_frame(TextureSource& source, TextureFill& fill, std::int64_t frame) {
    MIEN_TRY(read, source.read(frame));
    if (read.width != source.width() || read.height != source.height())
        return Error{ErrorCode::mismatch,
                     "texture frame " + std::to_string(frame) + " is " + std::to_string(read.width) + " x " +
                         std::to_string(read.height) + ", the first one " + std::to_string(source.width()) + " x " +
                         std::to_string(source.height())};
    Image picture = as_rgb(std::move(read));
    fill.apply(picture);
    return picture;
}

/// One picture as the lanes of one size take it.
struct SizedPicture {
    int width, height;  ///< texels
    media::YuvImage yuv;

    explicit SizedPicture(const TextureLane& lane)
        : width(lane.width), height(lane.height),
          yuv(lane.settings.width, lane.settings.height, media::Chroma::quarter, YuvView::Matrix::bt709, lane.settings.full_range) {}
    void take(const Image& picture) {
        const bool whole = picture.width == width && picture.height == height;
        media::to_yuv(whole ? picture : scaled_down(picture, width, height), yuv);
    }
};

/// An encoder at work on one lane.
class LaneRun {
public:
    static Result<LaneRun> open(const TextureLane& lane) {
        MIEN_TRY(encoder, media::VideoEncoder::open(lane.settings));
        return LaneRun(std::move(encoder), lane);
    }
    void encode(const media::YuvImage& picture, std::int64_t frame) {
        const bool key = frame % lane_->settings.key_interval == 0;
        if (lane_->shrink && lane_->step > 0) {
            media::YuvImage seen = picture;
            lane_->shrink->apply(seen, lane_->step, key || !before_ ? nullptr : &*before_);
            keep(encoder_.encode(seen, key));
            before_ = std::move(seen);
        } else {
            keep(encoder_.encode(picture, key));
        }
    }
    Result<TextureRun> finish() {
        keep(encoder_.finish());
        if (failed_) return *failed_;
        return std::move(run_);
    }
    const std::optional<Error>& failed() const { return failed_; }

private:
    LaneRun(media::VideoEncoder encoder, const TextureLane& lane) : encoder_(std::move(encoder)), lane_(&lane) {
        run_.codec_config = encoder_.codec_config();
    }
    void keep(Result<std::vector<media::VideoPacket>> packets) {
        if (!packets.ok()) failed_ = packets.error();
        else std::move(packets->begin(), packets->end(), std::back_inserter(run_.packets));
    }

    media::VideoEncoder encoder_;
    const TextureLane* lane_;
    std::optional<media::YuvImage> before_;   ///< what the encoder saw last, of a lane that shrinks
    TextureRun run_;
    std::optional<Error> failed_;
};

}  // namespace

double TextureRun::kbps(Rational frame_rate, std::int64_t frames) const {
    double bits = 8.0 * double(codec_config.size());
    for (const media::VideoPacket& packet : packets) bits += 8.0 * double(packet.bytes.size());
    return bits / 1000 * frame_rate.value() / double(frames);
}

Result<std::vector<TextureRun>> encode_lanes(TextureSource& source, TextureFill& fill, const std::vector<TextureLane*>& lanes,
                                             std::int64_t frames, const Progress& progress) {
    std::vector<LaneRun> runs;
    std::vector<SizedPicture> sizes;
    std::vector<std::size_t> size_of;
    for (const TextureLane* lane : lanes) {
        MIEN_TRY(run, LaneRun::open(*lane));
        runs.push_back(std::move(run));
        const auto same = std::find_if(sizes.begin(), sizes.end(), [&](const SizedPicture& size) {
            return size.width == lane->width && size.height == lane->height;
        });
        size_of.push_back(std::size_t(same - sizes.begin()));
        if (same == sizes.end()) sizes.emplace_back(*lane);
    }
    for (std::int64_t f = 0; f < frames; ++f) {
        if (progress) progress("texture", f, frames);
        MIEN_TRY(picture, filled_frame(source, fill, f));
        for (SizedPicture& size : sizes) size.take(picture);
        parallel_for(std::int64_t(runs.size()), [&](std::int64_t i) { runs[std::size_t(i)].encode(sizes[size_of[std::size_t(i)]].yuv, f); });
        for (const LaneRun& run : runs)
            if (run.failed()) return *run.failed();
    }
    std::vector<TextureRun> done;
    for (LaneRun& run : runs) {
        MIEN_TRY(finished, run.finish());
        done.push_back(std::move(finished));
    }
    if (progress) progress("texture", frames, frames);
    return done;
}

Result<double> weighted_error(TextureSource& source, TextureFill& fill, const TextureLane& lane, const TextureRun& run) {
    MIEN_TRY(decoder, media::VideoDecoder::open({lane.settings.codec, run.codec_config, lane.settings.width, lane.settings.height,
                                                 YuvView::Matrix::bt709, lane.settings.full_range, 0}));
    double sum = 0, weight = 0;
    SizedPicture truth(lane);
    std::int64_t frame = 0;
    const auto compare = [&](const std::vector<media::VideoPicture>& pictures) -> Result<void> {
        for (const media::VideoPicture& decoded : pictures) {
            MIEN_TRY(filled, filled_frame(source, fill, frame++));
            truth.take(filled);
            for (int y = 0; y < lane.height; ++y)
                for (int x = 0; x < lane.width; ++x) {
                    const double received = decoded.picture.planes[0][y * decoded.picture.strides[0] + x];
                    const double difference = truth.yuv.planes[0][std::size_t(y) * truth.yuv.width + x] - received;
                    const double w = lane.weights[std::size_t(y) * lane.width + x];
                    sum += w * difference * difference;
                    weight += w;
                }
        }
        return {};
    };
    for (const media::VideoPacket& packet : run.packets) {
        MIEN_TRY(pictures, decoder.decode(packet.bytes));
        MIEN_CHECK(compare(pictures));
    }
    MIEN_TRY(pictures, decoder.drain());
    MIEN_CHECK(compare(pictures));
    return weight > 0 ? sum / weight : 0;
}

}  // namespace mien::encoder
