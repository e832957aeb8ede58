#include "media/pcm.hpp"

namespace mien::media {
namespace {

template <class T>
void append(const AVFrame& frame, bool planar, double scale, double offset, std::vector<float>& samples) {
    const int channels = channels_of(frame);
    const std::size_t before = samples.size();
    samples.resize(before + std::size_t(frame.nb_samples) * channels);
    float* out = samples.data() + before;
    for (int c = 0; c < channels; ++c) {
        const T* in = reinterpret_cast<const T*>(frame.extended_data[planar ? c : 0]) + (planar ? 0 : c);
        const int step = planar ? 1 : channels;
        for (int i = 0; i < frame.nb_samples; ++i)
            out[std::size_t(i) * channels + c] = float(in[std::size_t(i) * step] * scale + offset);
    }
}

}  // namespace

bool append_samples(const AVFrame& frame, std::vector<float>& samples) {
    const auto format = AVSampleFormat(frame.format);
    const bool planar = av_sample_fmt_is_planar(format);
    switch (av_get_packed_sample_fmt(format)) {
        case AV_SAMPLE_FMT_U8:
            append<std::uint8_t>(frame, planar, 1.0 / 128, -1, samples);
            return true;
        case AV_SAMPLE_FMT_S16:
            append<std::int16_t>(frame, planar, 1.0 / 32768, 0, samples);
            return true;
        case AV_SAMPLE_FMT_S32:
            append<std::int32_t>(frame, planar, 1.0 / 2147483648.0, 0, samples);
            return true;
        case AV_SAMPLE_FMT_FLT:
            append<float>(frame, planar, 1, 0, samples);
            return true;
        case AV_SAMPLE_FMT_DBL:
            append<double>(frame, planar, 1, 0, samples);
            return true;
        default:
            return false;
    }
}

}  // namespace mien::media
