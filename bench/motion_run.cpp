#include "bench/motion_run.hpp"

#include <time.h>

#include <algorithm>

#include "bench/timing.hpp"
#include "coding/motion_basis.hpp"
#include "coding/motion_frames.hpp"
#include "coding/motion_values.hpp"
#include "core/parallel.hpp"
#include "decoder/motion_decoder.hpp"
#include "encoder/live_motion.hpp"
#include "encoder/reference_points.hpp"

namespace mien::bench {
namespace {

using protocol::MotionKind;

double clock_seconds(clockid_t id) {
    timespec now{};
    clock_gettime(id, &now);
    return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

/// Of one clock, while `work` runs.
double elapsed(clockid_t id, auto&& work) {
    const double start = clock_seconds(id);
    work();
    return clock_seconds(id) - start;
}

/// Reads decisions and counts them.
class CountingDecoder {
public:
    static constexpr bool kDecodes = true;
    explicit CountingDecoder(ByteView bytes) : decoder_(bytes) {}
    void code(int& bit, coding::Probability set) {
        decoder_.code(bit, set);
        ++count_;
    }
    void enter(bool) {}
    void fail() { decoder_.fail(); }
    bool failed() const { return decoder_.failed(); }
    std::int64_t count() const { return count_; }

private:
    coding::RangeDecoder decoder_;
    std::int64_t count_ = 0;
};

std::int64_t frames_of(const Clip& clip, MotionKind kind) {
    return kind == MotionKind::vertices ? clip.vertices->frames : kind == MotionKind::markers ? clip.markers->frames : clip.weights->frames;
}

encoder::MotionFrame frame_of(const Clip& clip, MotionKind kind, std::int64_t f) {
    encoder::MotionFrame frame;
    if (kind == MotionKind::weights) {
        frame.values = Eigen::Map<const Eigen::VectorXf>(clip.weights->frame(f), clip.weights->count);
        return frame;
    }
    const PointSequence& points = kind == MotionKind::vertices ? *clip.vertices : *clip.markers;
    frame.values = Eigen::Map<const Eigen::VectorXf>(points.frame(f).data(), 3 * points.points);
    return frame;
}

/// A coded clip as a take that others are coded with.
Result<encoder::TrainingTake> take_of(const encoder::EncodedMotion& motion, std::span<const Triangle> triangles, std::int64_t frames, std::int64_t group_frames) {
    encoder::TrainingTake take;
    take.info = motion.info;
    take.group_frames = group_frames;
    MIEN_TRY(basis, coding::read_motion_basis(take.shape(), motion.basis, triangles));
    MIEN_TRY(decoder, decoder::MotionDecoder::create(motion.info, motion.basis, triangles));
    take.samples = Eigen::MatrixXd::Zero(Eigen::Index(basis.channels(take.shape())), Eigen::Index(frames));
    for (const protocol::Group& group : motion.groups) {
        decoder.begin_group();
        std::int64_t frame = group.first_time;
        for (const protocol::Object& object : group.objects) {
            MIEN_TRY(motions, decoder.decode(object, frame));
            for (const model::Motion& m : motions) {
                int row = 0;
                if (take.info.has_pose)
                    for (const double v : coding::pose_steps(basis, m.pose)) take.samples(row, m.frame) = v - basis.side_mean[std::size_t(row)], ++row;
                if (take.info.has_gaze)
                    for (const double v : coding::gaze_steps(basis, m.gaze)) take.samples(row, m.frame) = v - basis.side_mean[std::size_t(row)], ++row;
                take.samples.col(m.frame).tail(m.coefficients.size()) = m.coefficients.cast<double>() / coding::MotionBasis::kFraction;
            }
            frame += object.frames;
        }
    }
    take.basis = std::move(basis);
    return take;
}

void time_decisions(MotionTimes& out, const encoder::EncodedMotion& motion, const encoder::TrainingTake& take, int rounds) {
    coding::MotionFrames frames(take.basis, take.shape());
    std::vector<double> seconds;
    for (int round = 0; round < rounds; ++round) {
        out.decisions = 0;
        out.frame_bytes = 0;
        seconds.push_back(elapsed(CLOCK_THREAD_CPUTIME_ID, [&] {
            for (const protocol::Group& group : motion.groups) {
                frames.begin_group();
                for (const protocol::Object& object : group.objects) {
                    CountingDecoder coder(object.bytes);
                    std::vector<std::uint8_t> presence;
                    if (take.info.has_presence) frames.code_presence(coder, object.frames, presence);
                    frames.decode(coder, object.frames);
                    out.decisions += coder.count();
                    out.frame_bytes += object.bytes.size();
                }
            }
        }));
    }
    if (out.decisions > 0) out.decision = quantile(seconds, 0.5) / double(out.decisions);
}

/// The integers of a group of the transform scheme, in the order in which they are coded, with the contexts of each.
struct CodedNumbers {
    std::vector<coding::IntegerModel::Contexts> contexts;
    std::vector<std::int32_t> values;
    Bytes bytes;   ///< the same again, coded without anything between them

    void record(coding::MotionFrames& frames, const protocol::Group& group, bool presence) {
        frames.begin_group();
        for (const protocol::Object& object : group.objects) {
            coding::MeteredDecoder coder(object.bytes);
            std::vector<std::uint8_t> present;
            if (presence) frames.code_presence(coder, object.frames, present);
            frames.begin_object(object.frames);
            for (int c = 0; c < frames.layout().total() && !coder.failed(); ++c) {
                int split = 0;
                frames.code_channel(coder, c, object.frames, split, [](const coding::MotionFrames::Block&) {},
                                    [&](int, const coding::IntegerModel::Contexts& now, auto&) { return contexts.push_back(now), 0; });
                const auto numbers = frames.numbers(c, object.frames);
                values.insert(values.end(), numbers.begin(), numbers.end());
            }
        }
    }
    void encode(coding::IntegerModel model) {
        coding::RangeEncoder coder;
        for (std::size_t i = 0; i < values.size(); ++i) model.code(coder, values[i], contexts[i]);
        bytes = coder.finish();
    }
};

void time_coder(MotionTimes& out, const encoder::EncodedMotion& motion, const encoder::TrainingTake& take, int rounds) {
    coding::MotionFrames frames(take.basis, take.shape());
    std::vector<CodedNumbers> groups(motion.groups.size());
    for (std::size_t g = 0; g < groups.size(); ++g) groups[g].record(frames, motion.groups[g], take.info.has_presence);
    frames.begin_group();
    const coding::IntegerModel start = frames.model();
    for (CodedNumbers& group : groups) group.encode(start);

    std::vector<double> seconds;
    for (int round = 0; round < rounds; ++round) {
        double sum = 0;
        out.coder_decisions = 0;
        for (const CodedNumbers& group : groups) {
            coding::IntegerModel model = start;
            CountingDecoder coder(group.bytes);
            std::int32_t value = 0, sink = 0;
            sum += elapsed(CLOCK_THREAD_CPUTIME_ID, [&] {
                for (const auto& contexts : group.contexts) {
                    model.code(coder, value, contexts);
                    sink ^= value;
                }
            });
            for (const std::int32_t v : group.values) sink ^= v;
            if (sink != 0 || coder.failed()) return;   // not the numbers that were written: no figure
            out.coder_decisions += coder.count();
        }
        seconds.push_back(sum);
    }
    if (out.coder_decisions > 0) out.coder = quantile(seconds, 0.5) / double(out.coder_decisions);
}

Result<void> time_known(MotionTimes& out, const Clip& clip, const encoder::MotionOptions& options, const encoder::TrainingTake& take,
                        std::span<const Triangle> triangles, const Progress& progress) {
    encoder::LiveMotion live(take, options.reference ? *options.reference : Points(0, 3), {}, triangles, options.mirror);
    std::vector<double> seconds;
    for (std::int64_t f = 0; f < out.known_frames; ++f) {
        if (progress) progress("coding frames with a known basis", std::size_t(f), std::size_t(out.known_frames));
        if (f % take.group_frames == 0) live.begin_group();
        const encoder::MotionFrame frame = frame_of(clip, options.kind, f);
        std::optional<Error> error;
        seconds.push_back(elapsed(CLOCK_THREAD_CPUTIME_ID, [&] {
            if (const auto object = live.encode(frame); !object.ok()) error = object.error();
        }));
        if (error) return *error;
        out.known += seconds.back();
    }
    out.known_median = quantile(seconds, 0.5);
    out.known_rms = live.figures().rms;
    out.known_bytes = live.figures().bytes;
    return {};
}

}  // namespace

Result<MotionTimes> time_motion(const Clip& clip, const encoder::MotionOptions& asked, std::int64_t known, int rounds, const Progress& progress) {
    encoder::MotionOptions options = asked;
    const bool vertices = options.kind == MotionKind::vertices;
    const std::span<const Triangle> triangles = vertices && clip.neutral ? std::span<const Triangle>(clip.neutral->triangles) : std::span<const Triangle>();
    if (vertices && clip.neutral && options.mirror.empty()) options.mirror = clip.neutral->mirror;
    if (!options.reference && options.kind != MotionKind::weights) options.reference = encoder::reference_points(clip, options.kind);
    if (options.group_frames <= 0) options.group_frames = std::max<std::int64_t>(1, std::llround(clip.frame_rate.value()));

    MotionTimes out;
    out.frames = frames_of(clip, options.kind);
    out.known_frames = std::min(known, out.frames);
    out.threads = thread_count();
    std::optional<Result<encoder::EncodedMotion>> encoded;
    out.training = elapsed(CLOCK_MONOTONIC, [&] { encoded = encoder::encode_motion(clip, options, progress); });
    if (!encoded->ok()) return encoded->error();
    const encoder::EncodedMotion& motion = **encoded;
    MIEN_TRY(take, take_of(motion, triangles, out.frames, options.group_frames));
    out.points = motion.info.count;
    out.components = take.basis.size();
    out.rms = motion.rms;

    set_thread_count(1);
    time_decisions(out, motion, take, rounds);
    if (take.basis.scheme == coding::MotionScheme::transform) time_coder(out, motion, take, rounds);
    const auto done = time_known(out, clip, options, take, triangles, progress);
    set_thread_count(0);
    if (!done.ok()) return done.error();
    return out;
}

}  // namespace mien::bench
