#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>

#include "bench/geometry_codec.hpp"
#include "bench/report.hpp"
#include "encoder/stream_encoder.hpp"
#include "protocol/stream_file.hpp"
#include "tools/byte_split.hpp"
#include "tools/stored_stream.hpp"

namespace mien::bench {
namespace {

using protocol::MotionKind;

/// Order-0 entropy of a run of integers, bits altogether.
double entropy(const std::vector<long>& values) {
    std::map<long, double> counts;
    for (long v : values) counts[v] += 1;
    double bits = 0;
    for (const auto& [value, count] : counts) bits -= count * std::log2(count / double(values.size()));
    return bits;
}

class MienStream final : public GeometryStream {
public:
    MienStream(tools::StoredStream stream, model::FaceModel model, const tools::ByteSplit& split)
        : stream_(std::move(stream)), model_(std::move(model)), info_(std::get<protocol::MotionInfo>(track().info)) {
        parts = {{"shape", split.shape},
                 {"basis", split.basis},
                 {"probabilities", split.probabilities},
                 {"coefficients", split.coefficients},
                 {"pose", split.pose}};
        apart = {{"connectivity", split.connectivity}, {"framing", split.framing}};
        for (const auto& entry : stream_.reader().index()) {
            if (entry.slot != track().rungs.front().slot) continue;
            auto group = stream_.reader().read_group(entry);
            assert(group.ok());
            for (const auto& object : group->objects) frames_together = std::max<std::int64_t>(frames_together, object.frames);
            groups_.push_back(std::move(*group));
        }
    }

    Result<void> start() override {
        MIEN_TRY(decoder, stream_.motion_decoder(model_));
        decoder_ = std::move(decoder);
        const model::LinearMotion& basis = decoder_->basis();
        still_ = basis.mean;
        if (info_.kind != MotionKind::weights) {
            const Points* markers = model::driving_markers(model_);
            const Points& reference = markers ? *markers : model::neutral_points(model_);
            still_ += Eigen::Map<const Eigen::VectorXf>(reference.data(), reference.size());
        }
        group_ = object_ = 0;
        ready_.clear();
        next_ = 0;
        return {};
    }

    Result<void> decode(std::int64_t frame, std::span<float> out) override {
        if (next_ == ready_.size()) MIEN_CHECK(decode_object());
        const model::Motion& motion = ready_[next_++];
        if (motion.frame != frame) return Error{ErrorCode::damaged, "a motion frame is missing"};
        model::motion_vector(decoder_->basis(), motion, still_, Eigen::Map<Eigen::VectorXf>(out.data(), still_.size()));
        if (info_.has_pose && info_.kind != MotionKind::weights)
            apply_pose(motion.pose, PointsMap(out.data(), still_.size() / 3, 3));
        return {};
    }

    /// What the 1998 paper prints instead of bytes: the order-0 entropies of its numbers, coefficients (the first 45 after
    /// order-1 prediction) and basis vectors; in whole bytes.
    Result<std::uint64_t> entropy_bytes() {
        MIEN_CHECK(start());
        std::vector<model::Motion> motions;
        while (group_ < groups_.size()) {
            MIEN_CHECK(decode_object());
            std::move(ready_.begin(), ready_.end(), std::back_inserter(motions));
        }
        double bits = 0;
        std::vector<long> numbers;
        for (Eigen::Index c = 0; c < decoder_->basis().size(); ++c) {
            numbers.clear();
            for (std::size_t f = 0; f < motions.size(); ++f) {
                const bool alone = c >= 45 || f == 0;
                numbers.push_back(std::lround((motions[f].coefficients[c] - (alone ? 0 : motions[f - 1].coefficients[c])) / 16));
            }
            bits += entropy(numbers);
            const Eigen::VectorXf column = decoder_->basis().components.col(c);
            float unit = 1e30f;
            for (float v : column)
                if (v != 0) unit = std::min(unit, std::abs(v));
            numbers.clear();
            for (float v : column) numbers.push_back(std::lround(v / unit));
            bits += entropy(numbers);
        }
        return std::uint64_t(std::ceil(bits / 8));
    }

private:
    const protocol::Track& track() const { return *stream_.track(protocol::TrackKind::motion); }

    Result<void> decode_object() {
        if (group_ == groups_.size()) return Error{ErrorCode::truncated, "the motion ends too early"};
        const protocol::Group& group = groups_[group_];
        if (object_ == 0) {
            decoder_->begin_group();
            frame_ = group.first_time;
        }
        const protocol::Object& object = group.objects[object_];
        MIEN_TRY(motions, decoder_->decode(object, frame_));
        frame_ += object.frames;
        ready_ = std::move(motions);
        next_ = 0;
        if (++object_ == group.objects.size()) ++group_, object_ = 0;
        return {};
    }

    tools::StoredStream stream_;
    model::FaceModel model_;
    const protocol::MotionInfo& info_;
    std::vector<protocol::Group> groups_;
    std::optional<decoder::MotionDecoder> decoder_;
    Eigen::VectorXf still_;  // mean and reference together
    std::size_t group_ = 0, object_ = 0, next_ = 0;
    std::int64_t frame_ = 0;
    std::vector<model::Motion> ready_;
};

/// The same bytes as `mien encode --no-texture --no-sound` writes.
Result<Bytes> stream_file(const Clip& clip, const encoder::StreamOptions& options) {
    MIEN_TRY(encoded, encoder::encode_stream(clip, options));
    Bytes file;
    protocol::StreamFileWriter writer([&](ByteView bytes) { file.insert(file.end(), bytes.begin(), bytes.end()); },
                                      encoded.header, encoded.blobs);
    for (const protocol::Group& group : encoded.groups) writer.add(group);
    writer.finish();
    return file;
}

class MienCodec final : public GeometryCodec {
public:
    MienCodec(std::string name_, std::string what_, encoder::MotionPreset preset, std::optional<double> group_seconds)
        : preset_(preset), group_seconds_(group_seconds) {
        name = std::move(name_);
        what = std::move(what_);
        library = own_library();
        mode = preset == encoder::MotionPreset::live ? Mode::live : Mode::file;
        ours = preset != encoder::MotionPreset::guenter98;
    }

    Result<std::unique_ptr<GeometryStream>> encode(const GeometryInput& input, double rms) const override {
        encoder::StreamOptions options;
        options.motion.kind = input.kind;
        options.motion.preset = preset_;
        options.motion.rms = rms;
        options.texture.reset();
        options.sound.reset();
        options.group_seconds = group_seconds_;
        MIEN_TRY(file, stream_file(input.clip, options));
        MIEN_TRY(stream, tools::StoredStream::from_bytes(std::make_shared<const Bytes>(std::move(file))));
        MIEN_TRY(split, tools::split_bytes(stream));
        MIEN_TRY(model, stream.model());
        auto out = std::make_unique<MienStream>(std::move(stream), std::move(model), split);
        if (preset_ == encoder::MotionPreset::guenter98) {
            MIEN_TRY(ideal, out->entropy_bytes());
            const std::uint64_t stored = split.basis + split.probabilities + split.coefficients;
            out->apart.insert(out->apart.begin(),
                              {ideal < stored ? "static codes" : "entropies", ideal < stored ? stored : ideal});
            if (ideal < stored) out->parts = {{"shape", split.shape}, {"entropies", ideal}, {"pose", split.pose}};
        }
        return std::unique_ptr<GeometryStream>(std::move(out));
    }

private:
    encoder::MotionPreset preset_;
    std::optional<double> group_seconds_;
};

}  // namespace

void add_mien(GeometryCodecs& list) {
    using encoder::MotionPreset;
    const auto add = [&](const char* name, const char* what, MotionPreset preset, std::optional<double> seconds) {
        list.codecs.push_back(std::make_unique<MienCodec>(name, what, preset, seconds));
    };
    add("mien-file", "look-ahead inside groups of 1 s", MotionPreset::file, 1.0);
    add("mien-whole", "look-ahead, one group for the whole clip", MotionPreset::file, {});
    add("mien-live", "causal, a packet a frame, groups of 1 s", MotionPreset::live, 1.0);
    add("guenter98", "the scheme of Guenter et al. 1998, one group; static codes or order-0 entropies, whichever is smaller",
        MotionPreset::guenter98, {});
}

}  // namespace mien::bench
