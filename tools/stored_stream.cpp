#include "tools/stored_stream.hpp"

#include <algorithm>
#include <limits>

#include "decoder/av_sound.hpp"
#include "decoder/av_texture.hpp"
#include "decoder/model_decoder.hpp"
#include "net/stored_stream.hpp"

namespace mien::tools {
namespace {

using protocol::MotionKind;
using protocol::TrackKind;

/// The texture of a stream, decoded group by group as it is read.
class StreamTexture final : public TextureSource {
public:
    StreamTexture(StoredStream stream, const protocol::Track& track, decoder::TextureDecoder decoder)
        : stream_(std::move(stream)), info_(std::get<protocol::TextureInfo>(track.info)), slot_(track.rungs.front().slot), decoder_(std::move(decoder)) {
        for (const auto& entry : stream_.reader().index())
            if (entry.slot == slot_) groups_.push_back(entry);
        // A stream that has been cut gives its whole groups: nobody knows whose pictures the rest of another are.
        for (std::size_t g = 0; g < groups_.size() && std::int64_t(groups_[g].objects) == end_of(g) - groups_[g].first_time; ++g) frames_ = end_of(g);
        if (stream_.reader().complete()) frames_ = std::int64_t(stream_.header().frames);
    }
    int width() const override { return int(info_.width); }
    int height() const override { return int(info_.height); }
    std::int64_t frames() const override { return frames_; }

    Result<Image> read(std::int64_t frame) override {
        if (frame < first_ || frame >= first_ + std::int64_t(pictures_.size())) MIEN_CHECK(load(frame));
        return pictures_[std::size_t(frame - first_)];
    }

private:
    Result<void> load(std::int64_t frame) {
        const auto after = std::upper_bound(groups_.begin(), groups_.end(), frame, [](std::int64_t f, const auto& entry) { return f < entry.first_time; });
        if (after == groups_.begin()) return Error{ErrorCode::missing, "no texture group holds frame " + std::to_string(frame)};
        const auto at = std::size_t(after - groups_.begin()) - 1;
        MIEN_TRY(group, stream_.reader().read_group(groups_[at]));
        pictures_.clear();
        first_ = group.first_time;
        decoder_.begin_group(first_);
        for (const auto& object : group.objects) {
            MIEN_TRY(ready, decoder_.push(object));
            keep(ready);
        }
        MIEN_TRY(rest, decoder_.end_group(end_of(at) - first_));
        keep(rest);
        if (frame >= first_ + std::int64_t(pictures_.size()))
            return Error{ErrorCode::missing, "the texture has no frame " + std::to_string(frame)};
        return {};
    }
    /// The frame behind a group: where the next one starts, at most a group's length later.
    std::int64_t end_of(std::size_t g) const {
        const auto frames = std::int64_t(stream_.header().frames), length = std::int64_t(stream_.header().group_frames);
        const std::int64_t next = g + 1 < groups_.size() ? groups_[g + 1].first_time : frames;
        return length > 0 && stream_.header().frames > 0 && g + 1 == groups_.size() ? std::min(next, groups_[g].first_time + length) : next;
    }
    void keep(const std::vector<decoder::TextureFrame>& frames) {
        for (const auto& frame : frames) pictures_.push_back(decoder::to_rgb(frame.picture));
    }

    StoredStream stream_;
    protocol::TextureInfo info_;
    std::uint8_t slot_;
    decoder::TextureDecoder decoder_;
    std::vector<protocol::IndexEntry> groups_;
    std::int64_t frames_ = 0;
    std::vector<Image> pictures_;   // of one group
    std::int64_t first_ = 0;
};

/// Leaves the first `frames` frames of what moves.
void shorten(Clip& clip, std::int64_t frames) {
    for (auto* points : {&clip.vertices, &clip.markers})
        if (*points && (*points)->frames > frames) {
            (*points)->frames = frames;
            (*points)->xyz.resize(std::size_t(frames * (*points)->points * 3));
        }
    if (clip.weights && clip.weights->frames > frames) {
        clip.weights->frames = frames;
        clip.weights->values.resize(std::size_t(frames * clip.weights->count));
    }
    clip.head_pose.resize(std::min(clip.head_pose.size(), std::size_t(frames)));
    clip.gaze.resize(std::min(clip.gaze.size(), std::size_t(frames)));
}

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

/// Writes decoded motion into the sequences of a clip.
class MotionRecorder {
public:
    MotionRecorder(Clip& clip, const protocol::MotionInfo& info, const model::FaceModel& model, const model::LinearMotion& basis)
        : clip_(clip), info_(info), basis_(basis) {
        const auto N = std::int64_t(info.count);
        switch (info.kind) {
            case MotionKind::vertices: clip.vertices.emplace(0, N); break;
            case MotionKind::markers: clip.markers.emplace(0, N); break;
            case MotionKind::weights: clip.weights.emplace(0, N); break;
        }
        if (const auto* blend = std::get_if<model::BlendBase>(&model.base)) reference_ = blend->markers;
        else if (info.kind != MotionKind::weights) reference_ = model::neutral_points(model);
    }

    /// Frames come in order without a gap; memory grows with what is really there, not with what a header announces.
    Result<void> record(const model::Motion& motion) {
        const std::int64_t f = clip_.frame_count();
        if (motion.frame != f)
            return Error{ErrorCode::damaged, "motion frame " + std::to_string(f) + " is missing: the stream goes on with frame " + std::to_string(motion.frame)};
        const Eigen::VectorXf x = model::motion_vector(basis_, motion);
        if (info_.has_gaze) clip_.gaze.push_back(motion.gaze);
        if (info_.kind == MotionKind::weights) {
            clip_.weights->values.insert(clip_.weights->values.end(), x.data(), x.data() + x.size());
            ++clip_.weights->frames;
            if (info_.has_pose) clip_.head_pose.push_back(motion.pose);
            return {};
        }
        PointSequence& points = info_.kind == MotionKind::vertices ? *clip_.vertices : *clip_.markers;
        Points moved = reference_ + ConstPointsMap(x.data(), x.size() / 3, 3);
        if (info_.has_pose) apply_pose(motion.pose, moved);
        for (std::size_t i = 0; i < motion.presence.size(); ++i)
            if (!motion.presence[i]) moved.row(Eigen::Index(i)).setConstant(std::numeric_limits<float>::quiet_NaN());
        points.xyz.insert(points.xyz.end(), moved.data(), moved.data() + moved.size());
        ++points.frames;
        return {};
    }

private:
    Clip& clip_;
    const protocol::MotionInfo& info_;
    const model::LinearMotion& basis_;
    Points reference_;
};

Result<void> decode_motion(const StoredStream& stream, const model::FaceModel& model, Clip& clip, const Progress& progress, std::size_t highest_rung) {
    const protocol::Track& track = *stream.track(TrackKind::motion);
    MIEN_TRY(decoder, stream.motion_decoder(model, highest_rung));
    const auto& info = std::get<protocol::MotionInfo>(track.info);
    const auto frames = std::int64_t(stream.header().frames);
    MotionRecorder recorder(clip, info, model, decoder.basis());
    return stream.visit_motion(decoder, [&](const model::Motion& motion) -> Result<void> {
        MIEN_CHECK(recorder.record(motion));
        if (progress) progress("decoding motion", motion.frame + 1, frames);
        return {};
    });
}

Result<Sound> decode_sound(const StoredStream& stream, const protocol::Track& track) {
    const auto& info = std::get<protocol::SoundInfo>(track.info);
    MIEN_TRY(decoder, decoder::SoundDecoder::create(track, track.rungs.front()));
    Sound sound;
    sound.sample_rate = int(info.sample_rate);
    sound.channels = info.channels;
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
    }));
    if (info.samples) sound.samples.resize(std::min<std::size_t>(sound.samples.size(), std::size_t(info.samples) * info.channels));
    return sound;
}

}  // namespace

Result<StoredStream> StoredStream::open(const std::filesystem::path& path) {
    MIEN_TRY(reader, net::open_stored_stream(path));
    auto stream = load(std::move(reader));
    if (!stream.ok()) return Error{stream.error().code, "'" + path.string() + "': " + stream.error().message};
    return stream;
}

Result<StoredStream> StoredStream::from_bytes(std::shared_ptr<const Bytes> bytes) {
    const auto read_at = [bytes](std::uint64_t offset, std::span<std::byte> into) -> Result<std::size_t> {
        if (offset >= bytes->size()) return std::size_t(0);
        const std::size_t size = std::min(into.size(), bytes->size() - std::size_t(offset));
        std::copy_n(bytes->begin() + std::ptrdiff_t(offset), size, into.begin());
        return size;
    };
    MIEN_TRY(reader, protocol::StreamFileReader::open(read_at, bytes->size()));
    return load(std::move(reader));
}

Result<StoredStream> StoredStream::load(protocol::StreamFileReader reader) {
    StoredStream stream;
    stream.reader_ = std::make_shared<protocol::StreamFileReader>(std::move(reader));
    for (const protocol::BlobInfo& info : stream.reader_->catalogue().blobs) {
        MIEN_TRY(bytes, stream.reader_->blob(info.hash));
        stream.blobs_.emplace(info.hash, std::move(bytes));
    }
    return stream;
}

const Bytes* StoredStream::blob(const Hash& hash) const {
    const auto found = blobs_.find(hash);
    return found == blobs_.end() ? nullptr : &found->second;
}

Result<model::FaceModel> StoredStream::model() const {
    return decoder::decode_model(header().model, [this](const Hash& hash) { return blob(hash); });
}

const protocol::Track* StoredStream::track(TrackKind kind) const {
    for (const protocol::Track& track : header().tracks)
        if (track.kind == kind) return &track;
    return nullptr;
}

Result<decoder::MotionDecoder> StoredStream::motion_decoder(const model::FaceModel& model, std::size_t highest) const {
    const protocol::Track* track = this->track(TrackKind::motion);
    if (!track) return Error{ErrorCode::missing, "the stream has no motion track"};
    const auto& info = std::get<protocol::MotionInfo>(track->info);
    if (!decoder::fits(model, info)) return Error{ErrorCode::mismatch, "the motion track does not fit the stream's face model"};
    std::vector<ByteView> bases;
    for (const protocol::Rung* rung : protocol::rung_ladder(*track)) {
        if (bases.size() > highest) break;
        const Bytes* bytes = rung->basis ? blob(*rung->basis) : nullptr;
        if (!bytes) return Error{ErrorCode::missing, "the stream lacks a motion basis"};
        bases.push_back(*bytes);
    }
    return decoder::MotionDecoder::create(info, bases, model.neutral.triangles, model.neutral.mirror);
}

Result<void> StoredStream::visit_groups(const protocol::Track& track,
                                        const std::function<Result<void>(const protocol::Group&)>& visit) const {
    for (const auto& entry : reader().index()) {
        if (entry.slot != track.rungs.front().slot) continue;
        MIEN_TRY(group, reader().read_group(entry));
        MIEN_CHECK(visit(group));
    }
    return {};
}

Result<void> StoredStream::visit_motion(decoder::MotionDecoder& decoder,
                                        const std::function<Result<void>(const model::Motion&)>& visit) const {
    const protocol::Track* track = this->track(TrackKind::motion);
    if (!track) return Error{ErrorCode::missing, "the stream has no motion track"};
    const auto ladder = protocol::rung_ladder(*track);
    return visit_groups(*track, [&](const protocol::Group& group) -> Result<void> {
        decoder.begin_group();
        std::vector<protocol::Group> finer;
        for (std::size_t r = 1; r < decoder.rungs(); ++r)
            for (const auto& entry : reader().index())
                if (entry.slot == ladder[r]->slot && entry.group == group.group) {
                    MIEN_TRY(refinement, reader().read_group(entry));
                    finer.push_back(std::move(refinement));
                }
        std::int64_t frame = group.first_time;
        for (std::size_t i = 0; i < group.objects.size(); ++i) {
            std::vector<const protocol::Object*> refinements;
            for (const auto& refinement : finer) refinements.push_back(i < refinement.objects.size() ? &refinement.objects[i] : nullptr);
            MIEN_TRY(motions, decoder.decode(group.objects[i], frame, refinements));
            if (decoder.refined() != decoder.rungs() && reader().complete())
                return Error{ErrorCode::damaged, "motion: a finer rung of frame " + std::to_string(frame) + " is damaged or missing"};
            for (const model::Motion& motion : motions) MIEN_CHECK(visit(motion));
            frame += group.objects[i].frames;
        }
        return {};
    });
}

Result<Clip> decode_stream(const StoredStream& stream, const Progress& progress, Keep keep, std::size_t highest_rung) {
    MIEN_TRY(model, stream.model());
    if (!stream.track(TrackKind::motion)) return Error{ErrorCode::missing, "the stream has no motion track"};
    Clip clip;
    clip.name = stream.header().name;
    clip.frame_rate = stream.header().frame_rate;
    clip.unit = stream.header().unit;
    if (model.neutral.vertex_count() > 0) clip.neutral = model.neutral;
    if (const auto* blend = std::get_if<model::BlendBase>(&model.base)) clip.marker_sites = blend->sites;
    if (const auto* shapes = std::get_if<model::BlendshapeBase>(&model.base)) clip.blendshapes = shapes->targets;
    MIEN_CHECK(decode_motion(stream, model, clip, progress, highest_rung));

    if (const protocol::Track* track = stream.track(TrackKind::texture)) {
        MIEN_TRY(texture, decoder::TextureDecoder::create(*track, track->rungs.front()));
        clip.texture = std::make_shared<StreamTexture>(stream, *track, std::move(texture));
        if (clip.texture->frames() == 0) clip.texture = nullptr;  // cut inside its first group
        else if (keep == Keep::textured) shorten(clip, clip.texture->frames());
    } else {
        for (const protocol::Layer& layer : stream.reader().manifest().layers) {
            if (layer.kind != protocol::LayerKind::static_albedo || layer.blobs.empty()) continue;
            const Bytes* bytes = stream.blob(layer.blobs.front());
            if (!bytes) return Error{ErrorCode::missing, "the stream lacks its texture"};
            MIEN_TRY(picture, decoder::decode_picture(*bytes));
            clip.texture = std::make_shared<StillTexture>(std::move(picture));
        }
    }
    if (const protocol::Track* track = stream.track(TrackKind::sound)) {
        MIEN_TRY(sound, decode_sound(stream, *track));
        clip.sound = std::move(sound);
    }
    return clip;
}

}  // namespace mien::tools
