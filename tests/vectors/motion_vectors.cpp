#include "motion_vectors.hpp"

#include <cstring>

#include "encoder/stream_encoder.hpp"
#include "tests/motion/motion_clips.hpp"
#include "tests/vectors/mirrored_sheet.hpp"
#include "tools/stored_stream.hpp"

namespace mien::vectors {
namespace {

/// Points that jump aside for some frames, so that there is something to correct.
Clip jumping(Clip clip) {
    PointSequence& points = clip.vertices ? *clip.vertices : *clip.markers;
    for (std::int64_t f = 3; f < 11; ++f) points.frame(f).row(5) += Eigen::RowVector3f(2, 0, -1.5f);
    for (std::int64_t f = 8; f < 14; ++f) points.frame(f).row(20) += Eigen::RowVector3f(0, f < 11 ? 2.f : -2.f, 0);
    return clip;
}

void append(Bytes& bytes, const void* data, std::size_t size) {
    const auto* begin = static_cast<const std::byte*>(data);
    bytes.insert(bytes.end(), begin, begin + size);
}

}  // namespace

const std::vector<MotionVector>& motion_vectors() {
    static const std::vector<MotionVector> all{
        {"motion_vertices.mien", "vertices across a mesh, three rungs, corrections, head pose, two groups; `file`"},
        {"motion_markers.mien", "markers that come and go, two rungs, corrections; `live`"},
        {"motion_weights.mien", "weights with gaze; `file`, one group"},
        {"motion_1998.mien", "markers in the scheme of 1998"},
        {"motion_mirrored.mien", "vertices across a mirrored mesh; `file`"},
        {"motion_chances.mien", "markers with parents and stored chances; `live`"},
    };
    return all;
}

Result<Bytes> make_motion_vector(const MotionVector& vector) {
    Clip clip;
    encoder::StreamOptions options;
    options.texture.reset();
    options.sound.reset();
    options.group_seconds = 0.4;
    if (vector.file == "motion_vertices.mien") {
        clip = jumping(motion_test::vertex_clip(6, 20, 3, true));
        options.motion = {.rms = 0.2, .peak = 0.6, .rungs = 3};
    } else if (vector.file == "motion_markers.mien") {
        clip = jumping(motion_test::marker_clip(20, 4, true, 0.02));
        options.motion = {.kind = protocol::MotionKind::markers, .preset = encoder::MotionPreset::live, .rms = 0.3, .peak = 0.8, .rungs = 2};
    } else if (vector.file == "motion_weights.mien") {
        clip = motion_test::weight_clip(24, 5);
        for (int f = 0; f < 24; ++f) clip.gaze.push_back({{0.1f, 0.2f}, {0.01f * float(f), 0.f}});
        options.motion = {.kind = protocol::MotionKind::weights, .rms = 0.01};
        options.group_seconds.reset();
    } else if (vector.file == "motion_mirrored.mien") {
        clip.neutral = mirrored_sheet(4, 6);
        clip.vertices = motion_test::bumps(clip.neutral->positions, 24, 7);
        options.motion = {.rms = 0.05};
        options.group_seconds.reset();
    } else if (vector.file == "motion_chances.mien") {
        clip = motion_test::marker_clip(320, 8, false, 0);
        options.group_seconds = 0.2;
        options.motion = {.kind = protocol::MotionKind::markers, .preset = encoder::MotionPreset::live, .rms = 0.03};
    } else {
        clip = motion_test::marker_clip(16, 6, true, 0.03);
        options.motion = {.kind = protocol::MotionKind::markers, .preset = encoder::MotionPreset::guenter98, .rms = 0.3};
    }
    clip.frame_rate = {25, 1};
    MIEN_TRY(stream, encoder::encode_stream(clip, options));
    Bytes bytes;
    protocol::StreamFileWriter writer([&](ByteView part) { append(bytes, part.data(), part.size()); }, stream.header, stream.blobs);
    for (const protocol::Group& group : stream.groups) writer.add(group);
    writer.finish();
    return bytes;
}

Result<std::string> motion_digest(Bytes file) {
    MIEN_TRY(stream, tools::StoredStream::from_bytes(std::make_shared<Bytes>(std::move(file))));
    MIEN_TRY(model, stream.model());
    MIEN_TRY(decoder, stream.motion_decoder(model));
    Bytes all;
    MIEN_CHECK(stream.visit_motion(decoder, [&](const model::Motion& motion) -> Result<void> {
        const std::uint64_t state = decoder.state_hash();
        append(all, &state, sizeof state);
        append(all, motion.coefficients.data(), sizeof(float) * std::size_t(motion.coefficients.size()));
        for (const model::Correction& correction : motion.corrections) {
            append(all, &correction.at, sizeof correction.at);
            append(all, &correction.offset, sizeof correction.offset);
        }
        append(all, motion.presence.data(), motion.presence.size());
        return {};
    }));
    return sha256(all).hex();
}

}  // namespace mien::vectors
