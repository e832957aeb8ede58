#include "encoder/stream_encoder.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <future>
#include <string_view>

#include "core/parallel.hpp"

namespace mien::encoder {
namespace {

using protocol::MotionKind;
using protocol::Rung;
using protocol::Track;
using protocol::TrackKind;

constexpr double kNoticeable = 0.15;  // of the asked rate; short clips miss by a few percent

std::uint32_t average_bits(const std::vector<protocol::Group>& groups, double seconds) {
    std::uint64_t bytes = 0;
    for (const auto& group : groups)
        for (const auto& object : group.objects) bytes += object.bytes.size();
    return seconds > 0 ? std::uint32_t(std::min(4e9, double(bytes) * 8 / seconds)) : 0;
}

class StreamBuilder {
public:
    StreamBuilder(const Clip& clip, const StreamOptions& options) {
        out_.header.name = options.name.empty() ? clip.name : options.name;
        out_.header.frame_rate = clip.frame_rate;
        out_.header.frames = std::uint64_t(clip.frame_count());
        out_.header.unit = clip.unit;
        seconds_ = double(clip.frame_count()) / clip.frame_rate.value();
    }

    /// The rung gets the next free slot, and its groups with it.
    void add(Track& track, Rung rung, std::vector<protocol::Group> groups) {
        rung.slot = next_slot_++;
        rung.bits_per_second = average_bits(groups, seconds_);
        for (auto& group : groups) {
            group.slot = rung.slot;
            out_.groups.push_back(std::move(group));
        }
        track.rungs.push_back(std::move(rung));
    }
    /// A track of one rung.
    void add(Track&& track, Rung rung, std::vector<protocol::Group> groups) {
        add(track, std::move(rung), std::move(groups));
        out_.header.tracks.push_back(std::move(track));
    }

    EncodedStream finish() {
        std::stable_sort(out_.groups.begin(), out_.groups.end(), [](const auto& a, const auto& b) {
            return std::pair(a.group, a.slot) < std::pair(b.group, b.slot);
        });
        return std::move(out_);
    }

    EncodedStream& out() { return out_; }

private:
    EncodedStream out_;
    double seconds_ = 0;
    std::uint8_t next_slot_ = 0;
};

/// The texture, encoded beside the motion: either keeps one core busy for much of its time. With one thread, after it.
class TextureTask {
public:
    TextureTask(const Clip& clip, TextureOptions options, const Progress& progress)
        : result_(std::async(thread_count() > 1 ? std::launch::async : std::launch::deferred, [this, &clip, options, &progress] {
              return encode_texture(clip, options, [&](std::string_view what, std::int64_t done, std::int64_t of) {
                  if (abandoned_) throw Abandoned();
                  if (alone_ && progress) progress(what, done, of);   // one bar, and that of the motion first
              });
          })) {}
    /// Left before finish(), it ends at its next frame.
    ~TextureTask() { abandoned_ = true; }
    Result<EncodedTexture> finish() {
        alone_ = true;
        return result_.get();
    }

private:
    struct Abandoned {};
    std::atomic<bool> alone_ = false, abandoned_ = false;
    std::future<Result<EncodedTexture>> result_;   // the last member: its thread uses the others
};

}  // namespace

std::int64_t group_frames(Rational frame_rate, double seconds) {
    return std::max<std::int64_t>(1, std::llround(seconds * frame_rate.value()));
}

Result<EncodedStream> encode_stream(const Clip& clip, const StreamOptions& options, const Progress& progress) {
    const std::int64_t frames = clip.frame_count();
    if (frames == 0) return Error{ErrorCode::missing, "the clip has no frame to encode"};
    const std::int64_t per_group = options.group_seconds ? group_frames(clip.frame_rate, *options.group_seconds) : 0;
    // A texture of one frame is static, whatever its codec would cost.
    const bool video = options.texture && clip.texture && clip.texture->frames() > 1;
    if (video && clip.texture->frames() < frames)
        return Error{ErrorCode::mismatch, "the texture has " + std::to_string(clip.texture->frames()) + " frames but the motion has " + std::to_string(frames)};

    StreamBuilder stream(clip, options);
    ModelOptions model_options;
    model_options.kind = options.motion.kind;
    model_options.albedo = video ? Albedo::video : options.texture ? Albedo::picture : Albedo::none;
    if (options.motion.kind == MotionKind::vertices && options.motion.rms) model_options.step = shape_step(*options.motion.rms);
    else if (options.motion.kind == MotionKind::vertices && options.motion.peak) model_options.step = shape_step(*options.motion.peak / 5);
    if (progress) progress("face model", 0, 0);
    const Points* driving = options.model ? model::driving_markers(options.model->model) : nullptr;
    if (options.model && !options.motion.training && (options.motion.kind != MotionKind::markers || !driving))
        return Error{ErrorCode::mismatch, "a trained model is driven by markers, so it goes with marker motion alone"};
    if (driving && options.motion.kind == MotionKind::markers && clip.markers && driving->rows() != clip.markers->points)
        return Error{ErrorCode::mismatch, "the model has " + std::to_string(driving->rows()) + " markers, but the clip has " + std::to_string(clip.markers->points)};
    MIEN_TRY(model, options.model ? Result<EncodedModel>(*options.model) : encode_model(clip, model_options));
    EncodedStream& out = stream.out();
    out.header.model = model.manifest;
    out.header.group_frames = std::uint32_t(per_group);
    out.blobs = std::move(model.blobs);

    MotionOptions motion_options = options.motion;
    motion_options.group_frames = per_group;
    switch (options.motion.kind) {
        case MotionKind::vertices:
            motion_options.reference = model.model.neutral.positions;
            motion_options.mirror = model.model.neutral.mirror;
            break;
        case MotionKind::markers:
            motion_options.reference = *model::driving_markers(model.model);
            break;
        case MotionKind::weights: break;
    }
    std::optional<TextureTask> texture_task;
    if (video) {
        TextureOptions texture_options = *options.texture;
        texture_options.group_frames = per_group;
        texture_task.emplace(clip, texture_options, progress);
    }
    MIEN_TRY(motion, encode_motion(clip, motion_options, progress));
    out.motion_rms = motion.rms;
    out.motion_peak = motion.peak;
    const Hash basis = sha256(motion.basis);
    out.blobs.push_back({basis, protocol::BlobKind::motion_basis, std::move(motion.basis)});
    Track motion_track{TrackKind::motion, "motion", clip.frame_rate.inverse(), motion.info, {}};
    Rung motion_rung;
    motion_rung.codec = "motion";
    motion_rung.basis = basis;
    stream.add(motion_track, std::move(motion_rung), std::move(motion.groups));
    for (encoder::MotionRefinement& refinement : motion.refinements) {
        const Hash finer = sha256(refinement.basis);
        out.blobs.push_back({finer, protocol::BlobKind::motion_basis, std::move(refinement.basis)});
        Rung rung;
        rung.codec = "motion";
        rung.basis = finer;
        rung.refines = motion_track.rungs.back().slot;
        rung.priority = std::uint8_t(2 + motion_track.rungs.size());   // dropped before texture and sound
        stream.add(motion_track, std::move(rung), std::move(refinement.groups));
    }
    out.header.tracks.push_back(std::move(motion_track));

    if (texture_task) {
        MIEN_TRY(texture, texture_task->finish());
        Track track{TrackKind::texture, "texture", clip.frame_rate.inverse(), texture.info, {}};
        for (EncodedTextureRung& encoded : texture.rungs) {
            if (encoded.asked_kbps && std::abs(encoded.kbps / *encoded.asked_kbps - 1) > kNoticeable)
                out.warnings.push_back(fmt::format("the texture takes {:.0f} kbit/s where {:.4g} were asked: {} came no nearer with pictures of {} x {} texels",
                                                   encoded.kbps, *encoded.asked_kbps, texture.codec, encoded.width, encoded.height));
            Rung rung;
            rung.codec = texture.codec;
            rung.codec_config = std::move(encoded.codec_config);
            rung.priority = std::uint8_t(2 + track.rungs.size());  // the finest is dropped first
            if (encoded.width != int(texture.info.width)) rung.size = {std::uint32_t(encoded.width), std::uint32_t(encoded.height)};
            stream.add(track, std::move(rung), std::move(encoded.groups));
        }
        out.header.tracks.push_back(std::move(track));
    }
    if (options.sound && clip.sound) {
        SoundOptions sound_options = *options.sound;
        sound_options.group_frames = per_group;
        sound_options.frame_rate = clip.frame_rate;
        sound_options.frames = frames;
        if (progress) progress("sound", 0, 0);
        MIEN_TRY(sound, encode_sound(*clip.sound, sound_options));
        Rung rung;
        rung.codec = sound.codec;
        rung.codec_config = std::move(sound.codec_config);
        rung.priority = 1;
        stream.add({TrackKind::sound, "sound", sound.time_base, sound.info, {}}, std::move(rung), std::move(sound.groups));
    }
    return stream.finish();
}

}  // namespace mien::encoder
