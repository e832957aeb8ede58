#ifdef MIEN_BENCH_DRACO
#include <draco/animation/keyframe_animation_decoder.h>
#include <draco/animation/keyframe_animation_encoder.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "bench/draco.hpp"

// The whole clip as one keyframe animation: a channel is the path of some numbers over all frames.
namespace mien::bench {
namespace {

/// Numbers of one channel: a point each, or as many points as a Draco attribute can hold, which shares entropy tables.
constexpr std::array<std::int64_t, 2> kChannelNumbers{3, 126};

class DracoAnimationStream final : public GeometryStream {
public:
    DracoAnimationStream(const GeometryInput& input, std::int64_t channel_numbers, Bytes bytes)
        : numbers_(input.numbers()), channel_numbers_(channel_numbers), bytes_(std::move(bytes)) {
        parts = {{"animation", bytes_.size()}};
        frames_together = input.frames;
    }
    Result<void> start() override {
        animation_.reset();
        return {};
    }
    Result<void> decode(std::int64_t frame, std::span<float> out) override {
        if (!animation_) {
            animation_ = std::make_unique<draco::KeyframeAnimation>();
            draco::DecoderBuffer buffer;
            buffer.Init(reinterpret_cast<const char*>(bytes_.data()), bytes_.size());
            draco::KeyframeAnimationDecoder decoder;
            const draco::Status status = decoder.Decode(draco::DecoderOptions(), &buffer, animation_.get());
            if (!status.ok())
                return Error{ErrorCode::damaged, "Draco does not decode what it wrote: " + status.error_msg_string()};
        }
        for (std::int64_t first = 0, channel = 1; first < numbers_; first += channel_numbers_, ++channel)
            animation_->keyframes(std::int32_t(channel))
                ->GetMappedValue(draco::PointIndex(std::uint32_t(frame)), out.data() + first);
        return {};
    }

private:
    std::int64_t numbers_, channel_numbers_;
    Bytes bytes_;
    std::unique_ptr<draco::KeyframeAnimation> animation_;
};

class DracoAnimationCodec final : public GeometryCodec {
public:
    DracoAnimationCodec() {
        name = "draco-animation";
        what = "Draco's keyframe animation of the whole clip, level 10";
        library = draco_library();
        mode = Mode::file;
    }
    Result<std::unique_ptr<GeometryStream>> encode(const GeometryInput& input, double rms) const override {
        std::unique_ptr<GeometryStream> best;
        for (const std::int64_t numbers : kChannelNumbers) {
            MIEN_TRY(bytes, encode_channels(input, input.step(rms), numbers));
            auto stream = std::make_unique<DracoAnimationStream>(input, numbers, std::move(bytes));
            if (!best || stream->bytes() < best->bytes()) best = std::move(stream);
        }
        return best;
    }

private:
    static Result<Bytes> encode_channels(const GeometryInput& input, double step, std::int64_t channel_numbers) {
        draco::KeyframeAnimation animation;
        std::vector<float> times(std::size_t(input.frames));
        for (std::size_t f = 0; f < times.size(); ++f) times[f] = float(f);
        animation.SetTimestamps(times);
        auto options = draco::EncoderOptions::CreateDefaultOptions();
        options.SetSpeed(0, 0);
        options.SetAttributeInt(0, "quantization_bits", 20);
        for (std::int64_t first = 0; first < input.numbers(); first += channel_numbers) {
            const std::int64_t count = std::min(channel_numbers, input.numbers() - first);
            std::vector<float> path(std::size_t(input.frames * count));
            std::vector<float> low(std::size_t(count), std::numeric_limits<float>::infinity());
            float extent = 0;
            for (std::int64_t f = 0; f < input.frames; ++f)
                for (std::int64_t i = 0; i < count; ++i) {
                    const float value = input.frame(f)[first + i];
                    path[std::size_t(f * count + i)] = value;
                    low[std::size_t(i)] = std::min(low[std::size_t(i)], value);
                }
            for (std::int64_t f = 0; f < input.frames; ++f)
                for (std::int64_t i = 0; i < count; ++i)
                    extent = std::max(extent, path[std::size_t(f * count + i)] - low[std::size_t(i)]);
            const int id = animation.AddKeyframes<float>(draco::DT_FLOAT32, std::uint32_t(count), path);
            if (id < 0) return Error{ErrorCode::unavailable, "Draco takes no such animation"};
            const int bits = std::clamp(int(std::ceil(std::log2(double(extent) / step + 1))), 1, 30);
            options.SetAttributeInt(id, "quantization_bits", bits);
            options.SetAttributeVector(id, "quantization_origin", int(count), low.data());
            options.SetAttributeFloat(id, "quantization_range", float(step * (std::exp2(bits) - 1)));
        }
        draco::KeyframeAnimationEncoder encoder;
        draco::EncoderBuffer buffer;
        const draco::Status status = encoder.EncodeKeyframeAnimation(animation, options, &buffer);
        if (!status.ok()) return Error{ErrorCode::unavailable, "Draco could not encode: " + status.error_msg_string()};
        const auto* bytes = reinterpret_cast<const std::byte*>(buffer.data());
        return Bytes(bytes, bytes + buffer.size());
    }
};

}  // namespace

std::unique_ptr<GeometryCodec> draco_animation_codec() {
    return std::make_unique<DracoAnimationCodec>();
}

}  // namespace mien::bench
#endif
