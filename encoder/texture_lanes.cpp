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

/// Mean weighted squared error of a run's luma, of the frames that it holds.
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

namespace {

constexpr double kNearRate = 0.1;     // relative; of the rate that a lane is asked for, what its quality is set by
constexpr int kRateTrials = 4;
constexpr std::int64_t kUsualRuns = kRateTrials + 3;   // for the progress bar
constexpr double kRateSlope = 0.04;   // ln(bits) per point of quality, until two trials tell
constexpr double kLeastShare = 1.0 / 8, kMostShare = 8;   // of the encoder's step

/// The search for one lane's step. At one quality throughout: what rate control does in a few seconds is mostly chance.
struct StepProbe {
    TextureLane lane;       ///< what is tried next
    TextureLane* wanted;
    TextureRun plain;       ///< of the quality, nothing shrunk
    double whole = 0;       ///< the encoder's step
    double best = 0;        ///< error times bits of the best step so far
    double share = 1, factor = 2;
    bool done = false;

    explicit StepProbe(TextureLane& of) : lane(of), wanted(&of) {
        lane.step = wanted->step = 0;
        lane.settings.kbps.reset();
    }
    /// From 1 by factors of two, as long as that is better.
    void judge(double cost) {
        const bool better = cost < best;
        if (better) {
            best = cost;
            wanted->step = lane.step;
        }
        if (share == 1) {
            factor = better ? 2 : 0.5;
        } else if (share == 2 && !better) {   // the way up leads nowhere
            share = 1;
            factor = 0.5;
        } else {
            done = !better;
        }
        share *= factor;
        done = done || share < kLeastShare || share > kMostShare;
        lane.step = share * whole;
    }
};

/// A quality at which bits come nearest to a rate, from trial to trial.
struct QualitySearch {
    double rate;
    double slope = kRateSlope;
    std::optional<double> quality = {}, log_bits = {};   ///< of the trial before

    bool near(double kbps) const { return std::abs(std::log(kbps / rate)) <= kNearRate; }
    double next(double tried, double kbps) {
        const double now = std::log(kbps);
        if (log_bits && tried != *quality && (now - *log_bits) / (tried - *quality) > 0) slope = (now - *log_bits) / (tried - *quality);
        quality = tried;
        log_bits = now;
        return std::clamp(tried + (std::log(rate) - now) / slope, 0.0, media::VideoEncoderSettings::kFinestQuality);
    }
};

}  // namespace

Result<void> choose_steps(TextureSource& source, TextureFill& fill, const std::vector<TextureLane*>& lanes, std::int64_t frames,
                          const Progress& progress) {
    std::vector<StepProbe> probes;
    for (TextureLane* lane : lanes)
        if (lane->shrink) probes.emplace_back(*lane);
    const auto kbps = [&](const StepProbe& probe, const TextureRun& run) { return run.kbps(probe.lane.settings.frame_rate, frames); };
    std::int64_t runs_done = 0;
    const auto report = [&](std::string_view, std::int64_t done, std::int64_t of) {
        if (progress) progress("texture, trials", std::min(runs_done, kUsualRuns - 1) * of + done, kUsualRuns * of);
    };
    const auto run_all = [&](const std::vector<StepProbe*>& open) {
        std::vector<TextureLane*> trials;
        for (StepProbe* probe : open) trials.push_back(&probe->lane);
        auto runs = encode_lanes(source, fill, trials, frames, report);
        ++runs_done;
        return runs;
    };

    std::vector<QualitySearch> searches;
    for (const StepProbe& probe : probes) searches.push_back({probe.wanted->settings.kbps.value_or(0)});
    std::vector<StepProbe*> open;
    for (StepProbe& probe : probes) open.push_back(&probe);
    for (int trial = 0; !open.empty() && trial < kRateTrials; ++trial) {
        MIEN_TRY(runs, run_all(open));
        std::vector<StepProbe*> missed;
        for (std::size_t i = 0; i < open.size(); ++i) {
            StepProbe& probe = *open[i];
            QualitySearch& search = searches[std::size_t(open[i] - probes.data())];
            probe.plain = std::move(runs[i]);
            if (!probe.wanted->settings.kbps || search.near(kbps(probe, probe.plain)) || trial + 1 == kRateTrials) continue;
            double& quality = probe.lane.settings.quality;
            const double next = search.next(quality, kbps(probe, probe.plain));
            if (next == quality) continue;   // the end of the scale
            quality = next;
            missed.push_back(&probe);
        }
        open = std::move(missed);
    }
    for (StepProbe& probe : probes) {
        const auto& asked = probe.wanted->settings.kbps;
        if (asked && probe.lane.settings.quality == media::VideoEncoderSettings::kFinestQuality && kbps(probe, probe.plain) < *asked)
            continue;   // bits are left over as it is
        MIEN_TRY(error, weighted_error(source, fill, probe.lane, probe.plain));
        probe.whole = probe.lane.step = std::sqrt(12 * error);
        probe.best = error * kbps(probe, probe.plain);
        open.push_back(&probe);
    }
    for (;;) {
        std::erase_if(open, [](const StepProbe* probe) { return probe->done; });
        if (open.empty()) return {};
        MIEN_TRY(runs, run_all(open));
        for (std::size_t i = 0; i < open.size(); ++i) {
            MIEN_TRY(error, weighted_error(source, fill, open[i]->lane, runs[i]));
            open[i]->judge(error * kbps(*open[i], runs[i]));
        }
    }
}

}  // namespace mien::encoder
