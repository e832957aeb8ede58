#include "tools/stream_clip.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <limits>

#include "decoder/av_sound.hpp"
#include "decoder/av_texture.hpp"

namespace mien::tools {
namespace {

using protocol::MotionKind;
using protocol::TrackKind;

/// What the header of a damaged stream may make us repeat: about a gigabyte, about two hours.
constexpr std::int64_t kMostHeldNumbers = std::int64_t(1) << 28, kMostHeldFrames = std::int64_t(1) << 18;

/// The texture of a stream, decoded group by group as it is read. With `losses`, frames that cannot be decoded repeat the one
/// that was read before.
class StreamTexture final : public TextureSource {
public:
    StreamTexture(StoredStream stream, const protocol::Track& track, const protocol::Rung& rung, decoder::TextureDecoder decoder,
                  std::int64_t most_frames, std::shared_ptr<Losses> losses)
        : stream_(std::move(stream)), size_(protocol::texture_size(track, rung)), slot_(rung.slot), decoder_(std::move(decoder)), losses_(std::move(losses)) {
        for (const auto& entry : stream_.reader().index())
            if (entry.slot == slot_) groups_.push_back(entry);
        // A stream that has been cut gives its whole groups: nobody knows whose pictures the rest of another are.
        for (const auto& entry : groups_)
            if (!stream_.reader().is_cut(entry)) frames_ = std::max(frames_, end_of(entry));
        if (stream_.reader().complete()) frames_ = std::int64_t(stream_.header().frames);
        pictures_end_ = frames_;
        if (losses_ && frames_ > 0) frames_ = most_frames;
    }
    int width() const override { return int(size_.width); }
    int height() const override { return int(size_.height); }
    std::int64_t frames() const override { return frames_; }
    /// Frames from here on show the last picture: the file holds no more.
    std::int64_t pictures_end() const { return std::min(frames_, pictures_end_); }

    /// Finds the picture that stands for those that are lost at the start. An error when none of them can be decoded.
    Result<void> find_first() {
        Error why{ErrorCode::missing, "its groups are not in the file"};
        for (auto group = groups_.begin(); group != groups_.end(); ++group) {
            const auto loaded = load(group->first_time);
            if (loaded.ok()) return shown_ = pictures_.front(), Result<void>();
            if (group == groups_.begin()) why = loaded.error();
        }
        return why;
    }

    Result<Image> read(std::int64_t frame) override {
        frame = std::min(frame, pictures_end_ - 1);
        if (!holds(frame) && !(frame >= lost_.first && frame < lost_.end)) {
            const auto loaded = load(frame);
            if (!loaded.ok() && !losses_) return loaded.error();
            if (!loaded.ok()) lose(frame, loaded.error().message);
        }
        if (holds(frame)) shown_ = pictures_[std::size_t(frame - first_)];
        return shown_;
    }

private:
    static std::int64_t end_of(const protocol::IndexEntry& group) { return group.first_time + std::int64_t(group.objects); }
    bool holds(std::int64_t frame) const { return frame >= first_ && frame < first_ + std::int64_t(pictures_.size()); }
    std::vector<protocol::IndexEntry>::const_iterator behind(std::int64_t frame) const {
        return std::upper_bound(groups_.begin(), groups_.end(), frame, [](std::int64_t f, const auto& entry) { return f < entry.first_time; });
    }

    /// Decodes the group that holds `frame`.
    Result<void> load(std::int64_t frame) {
        const auto after = behind(frame);
        pictures_.clear();
        if (after == groups_.begin()) return Error{ErrorCode::missing, "no texture group holds frame " + std::to_string(frame)};
        const protocol::IndexEntry& entry = *(after - 1);
        MIEN_TRY(group, stream_.reader().read_group(entry));
        first_ = group.first_time;
        decoder_.begin_group(first_);
        for (const auto& object : group.objects) {
            MIEN_TRY(ready, decoder_.push(object));
            keep(ready);
        }
        MIEN_TRY(rest, decoder_.end_group(end_of(entry) - first_));
        keep(rest);
        if (!holds(frame)) return Error{ErrorCode::missing, "the texture has no frame " + std::to_string(frame)};
        return {};
    }

    /// Notes that `frame` and what follows it to the next group is lost. What was shown last stays; at the start what find_first() has found.
    void lose(std::int64_t frame, std::string why) {
        const auto after = behind(frame);
        lost_ = {protocol::TrackKind::texture, frame, std::min(pictures_end(), after == groups_.end() ? frames_ : after->first_time), why};
        if (!losses_->empty() && losses_->back().track == lost_.track && losses_->back().end == frame) losses_->back().end = lost_.end;
        else losses_->push_back(lost_);
    }

    void keep(const std::vector<decoder::TextureFrame>& frames) {
        for (const auto& frame : frames) pictures_.push_back(decoder::to_rgb(frame.picture));
    }

    StoredStream stream_;
    protocol::Rung::Size size_;
    std::uint8_t slot_;
    decoder::TextureDecoder decoder_;
    std::vector<protocol::IndexEntry> groups_;
    std::int64_t frames_ = 0, pictures_end_ = 0;   // frames; of them those that the file has pictures of
    std::vector<Image> pictures_;   // of one group
    std::int64_t first_ = 0;
    std::shared_ptr<Losses> losses_;
    Loss lost_{protocol::TrackKind::texture, 0, 0, {}};   // the latest
    Image shown_;
};

/// A static texture as a source of one frame.
class StillTexture final : public TextureSource {
public:
    explicit StillTexture(Image picture) : picture_(std::move(picture)) {}
    int width() const override { return picture_.width; }
    int height() const override { return picture_.height; }
    std::int64_t frames() const override { return 1; }
    Result<Image> read(std::int64_t) override { return picture_; }

private:
    Image picture_;
};

/// Writes decoded motion into the sequences of a clip. With `losses`, frames that are missing repeat the one before.
class MotionRecorder {
public:
    MotionRecorder(Clip& clip, const protocol::MotionInfo& info, const model::FaceModel& model, const model::LinearMotion& basis, Losses* losses)
        : clip_(clip), info_(info), basis_(basis), losses_(losses) {
        const auto N = std::int64_t(info.count);
        switch (info.kind) {
            case MotionKind::vertices: clip.vertices.emplace(0, N); break;
            case MotionKind::markers: clip.markers.emplace(0, N); break;
            case MotionKind::weights: clip.weights.emplace(0, N); break;
        }
        if (const Points* markers = model::driving_markers(model)) reference_ = *markers;
        else if (info.kind != MotionKind::weights) reference_ = model::neutral_points(model);
    }

    /// Frames come in order; memory grows with what is really there, not with what a header announces.
    Result<void> record(const model::Motion& motion) {
        const std::int64_t f = clip_.frame_count();
        if (motion.frame < f || (motion.frame > f && !losses_))
            return Error{ErrorCode::damaged, "motion frame " + std::to_string(f) + " is missing: the stream goes on with frame " + std::to_string(motion.frame)};
        if (f == 0) last_ = motion;   // stands in for what is lost before it
        MIEN_CHECK(hold_until(motion.frame));
        append(motion);
        last_ = motion;
        return {};
    }

    /// Why the frames that are missing next are.
    void blame(const Error& why) { why_ = why.message; }

    /// Repeats the last frame up to frame `end`.
    Result<void> hold_until(std::int64_t end) {
        const std::int64_t f = clip_.frame_count();
        if (f >= end) return {};
        held_ += end - f;
        if (held_ > kMostHeldFrames || held_ * std::int64_t(info_.count) * 3 > kMostHeldNumbers)
            return Error{ErrorCode::limit_exceeded, fmt::format("{} frames of the motion are lost, too many to fill", held_)};
        losses_->push_back({protocol::TrackKind::motion, f, end, why_});
        for (std::int64_t frame = f; frame < end; ++frame) append(last_);
        return {};
    }

private:
    void append(const model::Motion& motion) {
        const Eigen::VectorXf x = model::motion_vector(basis_, motion);
        if (info_.has_gaze) clip_.gaze.push_back(motion.gaze);
        if (info_.kind == MotionKind::weights) {
            clip_.weights->values.insert(clip_.weights->values.end(), x.data(), x.data() + x.size());
            ++clip_.weights->frames;
            if (info_.has_pose) clip_.head_pose.push_back(motion.pose);
            return;
        }
        PointSequence& points = info_.kind == MotionKind::vertices ? *clip_.vertices : *clip_.markers;
        Points moved = reference_ + ConstPointsMap(x.data(), x.size() / 3, 3);
        if (info_.has_pose) apply_pose(motion.pose, moved);
        for (std::size_t i = 0; i < motion.presence.size(); ++i)
            if (!motion.presence[i]) moved.row(Eigen::Index(i)).setConstant(std::numeric_limits<float>::quiet_NaN());
        points.xyz.insert(points.xyz.end(), moved.data(), moved.data() + moved.size());
        ++points.frames;
    }

    Clip& clip_;
    const protocol::MotionInfo& info_;
    const model::LinearMotion& basis_;
    Points reference_;
    Losses* losses_;
    model::Motion last_;
    std::int64_t held_ = 0;
    std::string why_ = "its groups are not in the file";
};

Result<void> decode_motion(const StoredStream& stream, const model::FaceModel& model, Clip& clip, const Progress& progress, Losses* losses,
                           std::size_t highest_rung) {
    const protocol::Track& track = *stream.track(TrackKind::motion);
    MIEN_TRY(decoder, stream.motion_decoder(model, highest_rung));
    const auto& info = std::get<protocol::MotionInfo>(track.info);
    const auto frames = std::int64_t(stream.header().frames);
    MotionRecorder recorder(clip, info, model, decoder.basis(), losses);
    StoredStream::Skip skip;
    if (losses)
        skip = [&](const protocol::IndexEntry& group, const Error& why) {
            if (group.slot == track.rungs.front().slot) return recorder.blame(why);
            const protocol::IndexEntry* next = stream.reader().find(group.slot, group.group + 1);
            losses->push_back({TrackKind::motion, group.first_time, next ? next->first_time : frames, why.message, Loss::Kind::coarser});
        };
    const auto visited = stream.visit_motion(decoder, [&](const model::Motion& motion) -> Result<void> {
        MIEN_CHECK(recorder.record(motion));
        if (progress) progress("decoding motion", motion.frame + 1, frames);
        return {};
    }, skip);
    MIEN_CHECK(visited);
    if (!losses || !stream.reader().complete()) return {};   // of a cut file nobody knows what the rest was
    if (clip.frame_count() == 0 && frames > 0) return Error{ErrorCode::damaged, "no group of the motion can be decoded"};
    return recorder.hold_until(frames);
}

Result<Sound> decode_sound(const StoredStream& stream, const protocol::Track& track, Losses* losses) {
    const auto& info = std::get<protocol::SoundInfo>(track.info);
    MIEN_TRY(decoder, decoder::SoundDecoder::create(track, track.rungs.front()));
    Sound sound;
    sound.sample_rate = int(info.sample_rate);
    sound.channels = info.channels;
    StoredStream::Skip skip;
    if (losses)
        skip = [&](const protocol::IndexEntry& group, const Error& why) {
            const protocol::IndexEntry* next = stream.reader().find(group.slot, group.group + 1);
            losses->push_back({TrackKind::sound, group.first_time, next ? next->first_time : std::int64_t(info.samples), why.message});
        };
    MIEN_CHECK(stream.visit_groups(track, [&](const protocol::Group& group) -> Result<void> {
        MIEN_TRY(block, decoder.decode(group));
        const std::size_t first = std::size_t(std::max<std::int64_t>(0, block.first_sample)) * info.channels;
        const std::size_t end = first + block.sound.samples.size();
        if (end > std::size_t(protocol::kMaxTicks)) return Error{ErrorCode::damaged, "a sound group lies beyond any time"};
        // Gaps are silent; a hostile first_sample may not ask for more than the stream's own length.
        const double limit = double(info.samples ? info.samples : std::uint64_t(1) << 40) * info.channels;
        if (double(end) > limit + 10.0 * info.sample_rate * info.channels) return Error{ErrorCode::damaged, "a sound group lies beyond the end of the sound"};
        if (sound.samples.size() < end) sound.samples.resize(end);
        std::copy(block.sound.samples.begin(), block.sound.samples.end(), sound.samples.begin() + std::ptrdiff_t(first));
        return {};
    }, skip));
    if (info.samples) sound.samples.resize(std::min<std::size_t>(sound.samples.size(), std::size_t(info.samples) * info.channels));
    return sound;
}

/// What the vertices wear: the track's pictures, or the one picture of the model.
Result<void> decode_texture(const StoredStream& stream, Clip& clip, const std::shared_ptr<Losses>& losses, std::size_t wanted_rung) {
    if (const protocol::Track* track = stream.track(TrackKind::texture)) {
        const protocol::Rung& rung = protocol::texture_rung(*track, wanted_rung);
        MIEN_TRY(decoder, decoder::TextureDecoder::create(*track, rung));
        const auto texture = std::make_shared<StreamTexture>(stream, *track, rung, std::move(decoder), clip.frame_count(), losses);
        if (texture->frames() == 0) return {};   // cut inside its first group
        if (losses) {
            if (const auto first = texture->find_first(); !first.ok())
                return losses->push_back({TrackKind::texture, 0, texture->frames(), first.error().message, Loss::Kind::whole}), Result<void>();
            if (const auto end = texture->pictures_end(); end < texture->frames())
                losses->push_back({TrackKind::texture, end, texture->frames(), "the file ends there", Loss::Kind::cut});
        }
        clip.texture = texture;
        return {};
    }
    for (const protocol::Layer& layer : stream.reader().manifest().layers) {
        if (layer.kind != protocol::LayerKind::static_albedo || layer.blobs.empty()) continue;
        const Bytes* bytes = stream.blob(layer.blobs.front());
        if (!bytes) return Error{ErrorCode::missing, "the stream lacks its texture"};
        MIEN_TRY(picture, decoder::decode_picture(*bytes));
        clip.texture = std::make_shared<StillTexture>(std::move(picture));
    }
    return {};
}

}  // namespace

std::string describe(const Loss& loss, const protocol::StreamHeader& header) {
    if (loss.track == TrackKind::sound) {
        double rate = 1;
        for (const protocol::Track& track : header.tracks)
            if (const auto* sound = std::get_if<protocol::SoundInfo>(&track.info)) rate = sound->sample_rate;
        return fmt::format("sound from {:.2f} to {:.2f} s is lost and silent: {}", double(loss.first) / rate, double(loss.end) / rate, loss.why);
    }
    if (loss.kind == Loss::Kind::whole) return "no picture of the texture can be decoded, so the clip has none: " + loss.why;
    if (loss.kind == Loss::Kind::coarser)
        return fmt::format("motion frames {} to {} lack a finer rung and are coarser: {}", loss.first, loss.end - 1, loss.why);
    return fmt::format("{} frames {} to {} are lost and repeat frame {}: {}", loss.track == TrackKind::motion ? "motion" : "texture", loss.first,
                       loss.end - 1, loss.first > 0 ? loss.first - 1 : loss.end, loss.why);
}

namespace {

/// A rung that was asked for by its number must be there; one that stands for the highest always is.
Result<void> check_rung(const char* kind, const protocol::Track* track, std::size_t asked, std::size_t highest) {
    if (!track || asked == highest || asked < track->rungs.size()) return {};
    return Error{ErrorCode::missing, track->rungs.size() == 1 ? fmt::format("there is no rung {} of {}: the stream has one alone, 0", asked, kind)
                                                              : fmt::format("there is no rung {} of {}: the stream has 0 to {}", asked, kind, track->rungs.size() - 1)};
}

}  // namespace

Result<Clip> decode_stream(const StoredStream& stream, const Progress& progress, Keep keep, std::shared_ptr<Losses> losses, Rungs rungs) {
    MIEN_TRY(model, stream.model());
    if (!stream.track(TrackKind::motion)) return Error{ErrorCode::missing, "the stream has no motion track"};
    MIEN_CHECK(check_rung("motion", stream.track(TrackKind::motion), rungs.motion, StoredStream::kAllRungs));
    MIEN_CHECK(check_rung("texture", stream.track(TrackKind::texture), rungs.texture, protocol::kFinestRung));
    Clip clip;
    clip.name = stream.header().name;
    clip.frame_rate = stream.header().frame_rate;
    clip.unit = stream.header().unit;
    if (model.neutral.vertex_count() > 0) clip.neutral = model.neutral;
    if (const auto* sites = model::driving_sites(model)) clip.marker_sites = *sites;
    if (const auto* shapes = std::get_if<model::BlendshapeBase>(&model.base)) clip.blendshapes = shapes->targets;
    MIEN_CHECK(decode_motion(stream, model, clip, progress, losses.get(), rungs.motion));

    if (keep == Keep::textured) MIEN_CHECK(decode_texture(stream, clip, losses, rungs.texture));
    if (const protocol::Track* track = stream.track(TrackKind::sound)) {
        MIEN_TRY(sound, decode_sound(stream, *track, losses.get()));
        if (!sound.samples.empty()) clip.sound = std::move(sound);   // cut or lost as a whole it is none
    }
    return clip;
}

}  // namespace mien::tools
