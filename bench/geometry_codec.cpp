#include "bench/geometry_codec.hpp"

#include <cmath>

namespace mien::bench {

GeometryInput::GeometryInput(const Clip& clip_, protocol::MotionKind kind_) : clip(clip_), kind(kind_) {
    frames = clip.frame_count();
    if (kind == protocol::MotionKind::weights) {
        points = clip.weights->count;
        dimension = 1;
        held = clip.weights->values;
        return;
    }
    const PointSequence& sequence = kind == protocol::MotionKind::vertices ? *clip.vertices : *clip.markers;
    points = sequence.points;
    held = sequence.xyz;
    if (kind == protocol::MotionKind::vertices && clip.neutral) triangles = clip.neutral->triangles;
    for (std::int64_t i = 0; i < numbers(); ++i) {
        float last = 0;
        for (std::int64_t f = 0; f < frames; ++f)
            if (const float value = held[std::size_t(f * numbers() + i)]; !std::isnan(value)) {
                last = value;
                break;
            }
        for (std::int64_t f = 0; f < frames; ++f) {
            float& value = held[std::size_t(f * numbers() + i)];
            if (std::isnan(value)) value = last;
            last = value;
        }
    }
}

const float* GeometryInput::truth(std::int64_t frame) const {
    switch (kind) {
        case protocol::MotionKind::vertices:
            return clip.vertices->frame(frame).data();
        case protocol::MotionKind::markers:
            return clip.markers->frame(frame).data();
        case protocol::MotionKind::weights:
            return clip.weights->frame(frame);
    }
    return nullptr;
}

double GeometryInput::step(double rms) const {
    return rms * std::sqrt(12.0 / dimension);
}

std::uint64_t GeometryStream::bytes() const {
    std::uint64_t sum = 0;
    for (const auto& [what, size] : parts) sum += size;
    return sum;
}

std::string GeometryCodec::refuses(const GeometryInput&) const {
    return {};
}

GeometryCodecs geometry_codecs() {
    GeometryCodecs list;
    add_mien(list);
    add_raw(list);
    add_compressed_deltas(list);
    add_meshoptimizer(list);
    add_draco(list);
    return list;
}

}  // namespace mien::bench
