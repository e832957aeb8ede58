#include "samples/stage.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/environment_error.hpp"
#include "core/parallel.hpp"
#include "io/clip_folder.hpp"
#include "io/sound_file.hpp"
#include "samples/ict_actor.hpp"
#include "samples/performance_training.hpp"
#include "samples/procedural_actor.hpp"
#include "samples/skin.hpp"
#include "samples/speech.hpp"
#include "samples/stage_scans.hpp"
#include "samples/stage_texture.hpp"

namespace mien::samples {
namespace {

namespace fs = std::filesystem;

constexpr float kFarthestIdentity = 10;
constexpr std::int64_t kMaxFrames = 200'000;  // two hours at 25 Hz

/// Vertices and clean markers of every frame, head pose applied.
void act(const Performance& performance, const Actor& actor, Clip& clip, const Progress& progress) {
    const std::int64_t F = performance.frames(), M = std::int64_t(clip.marker_sites.size());
    clip.vertices.emplace(F, actor.neutral().vertex_count());
    if (M > 0) clip.markers.emplace(F, M);
    constexpr std::int64_t kAtOnce = 32;
    for (std::int64_t first = 0; first < F; first += kAtOnce) {
        const std::int64_t count = std::min(kAtOnce, F - first);
        parallel_for(count, [&](std::int64_t i) {
            const Instant& instant = performance.instants[std::size_t(first + i)];
            Points points = actor.deform(instant);
            apply_pose(instant.head, points);
            clip.vertices->frame(first + i) = points;
            for (std::int64_t m = 0; m < M; ++m)
                clip.markers->frame(first + i).row(m) = clip.marker_sites[std::size_t(m)].position(points).transpose();
        });
        if (progress) progress("acting", first + count, F);
    }
}

}  // namespace

Result<void> check_options(const StageOptions& options) {
    const auto wrong = [](std::string why) { return Error{ErrorCode::invalid, std::move(why)}; };
    if (int(options.say.has_value()) + int(options.weights.has_value()) + int(options.expressions) + int(options.session.has_value()) > 1)
        return wrong("--say, --weights, --expressions and --session exclude one another");
    if (options.say && options.sound) return wrong("--sound goes with --weights or --expressions: speech brings its own");
    if (!options.identity.empty() && !options.actor.starts_with("ict:")) return wrong("--identity is for --actor ict:DIR");
    // Weights are standard deviations of real heads. Farther out there are none, and at last no number that a renderer can draw.
    for (const float weight : options.identity)
        if (!(std::abs(weight) <= kFarthestIdentity)) return wrong(fmt::format("--identity takes weights from -{0} to {0}: standard deviations of real heads", kFarthestIdentity));
    if (options.seconds && !(*options.seconds > 0 && *options.seconds <= 7200)) return wrong("--seconds must be above 0 and at most 7200");
    if (options.fps && !(options.fps->value() >= 1 && options.fps->value() <= 240)) return wrong("--fps must be from 1 to 240");
    if (options.markers < 0 || options.markers > 20'000) return wrong("--markers must be from 0 to 20000");
    if (!(options.noise >= 0 && options.noise <= 100)) return wrong("--noise must be from 0 to 100 mm");
    if (!(options.missing >= 0 && options.missing <= 0.9)) return wrong("--missing must be from 0 to 0.9");
    if (options.session && *options.session != "training" && *options.session != "asymmetric-smile" && *options.session != "raised-brow")
        return wrong(fmt::format("there is no session '{}'; use training, asymmetric-smile or raised-brow", *options.session));
    if (options.session && (options.seconds || options.fps || options.frames)) return wrong("--seconds, --fps and --frames are not for --session: use --take-frames");
    if (options.take_frames < 2 || options.take_frames > 1000) return wrong("--take-frames must be from 2 to 1000");
    if (options.range_frames < 0 || options.range_frames > 10'000) return wrong("--range-frames must be from 0 to 10000");
    if (options.scan_size < 32 || options.scan_size > 4096) return wrong("--scan-size must be from 32 to 4096");
    if (!(options.scan_noise >= 0 && options.scan_noise <= 100)) return wrong("--scan-noise must be from 0 to 100 mm");
    if (!(options.scan_holes >= 0 && options.scan_holes <= 0.9)) return wrong("--scan-holes must be from 0 to 0.9");
    if (options.texture_size != 0 && (options.texture_size < 16 || options.texture_size > 8192))
        return wrong("--texture-size must be 0 or from 16 to 8192");
    return {};
}

Result<Performance> make_performance(const StageOptions& options) {
    MIEN_CHECK(check_options(options));
    if (options.session)
        return *options.session == "training"           ? perform_training(options.take_frames, options.range_frames, options.seed).performance
               : *options.session == "asymmetric-smile" ? perform_unseen(kAsymmetricSmile, options.take_frames)
                                                        : perform_unseen(kRaisedBrow, options.take_frames);
    const Rational rate = options.fps.value_or(Rational{30, 1});
    const double seconds = options.seconds.value_or(0);
    const auto part = [&](Performance whole) -> Result<Performance> {
        return options.frames ? cut(std::move(whole), *options.frames) : Result<Performance>(std::move(whole));
    };
    if (options.weights) {
        // Of a take, its own frames.
        MIEN_TRY(whole, perform_take(*options.weights, options.sound));
        MIEN_TRY(take, part(std::move(whole)));
        Performance performance = options.fps ? resample(take, *options.fps) : std::move(take);
        if (options.seconds) performance = fit_length(std::move(performance), seconds);
        return performance;
    }
    if (options.expressions || (!options.say && !can_speak())) {
        Performance performance = perform_expressions(rate, seconds, options.seed);
        if (options.sound) {
            MIEN_TRY(sound, io::read_sound(*options.sound));
            performance.sound = std::move(sound);
        }
        return part(std::move(performance));
    }
    MIEN_TRY(utterance, speak(options.say.value_or(kDefaultText), options.voice));
    return part(perform_speech(utterance, rate, seconds, options.seed));
}

Result<std::unique_ptr<Actor>> make_actor(const StageOptions& options) {
    if (options.actor == "procedural") return make_procedural_actor(options.seed);
    if (!options.actor.starts_with("ict:"))
        return Error{ErrorCode::invalid, fmt::format("there is no actor '{}'; use procedural or ict:DIR", options.actor)};
    MIEN_TRY(actor, make_ict_actor(options.actor.substr(4),
                                   options.identity.empty() ? ict_identity(options.seed) : options.identity));
    return std::unique_ptr<Actor>(std::move(actor));
}

Result<void> stage(const StageOptions& options, const fs::path& output, const Progress& progress) {
    MIEN_CHECK(check_options(options));
    // Said before the work, not after it.
    std::error_code error;
    if (!options.force && fs::exists(output, error) && !(fs::is_directory(output, error) && fs::is_empty(output, error)))
        throw EnvironmentError(fmt::format("{} is there already: choose another folder, or replace it with -y", output.string()));
    if (progress) progress("preparing", 0, 0);
    MIEN_TRY(performance, make_performance(options));
    if (performance.frames() > kMaxFrames)
        return Error{ErrorCode::limit_exceeded, fmt::format("{} frames are more than the stage makes at once; use --seconds or --frames", performance.frames())};
    MIEN_TRY(made, make_actor(options));
    const std::shared_ptr<const Actor> actor = std::move(made);
    std::optional<Skin> skin;

    Clip clip;
    clip.name = output.filename().string();
    clip.frame_rate = performance.frame_rate;
    clip.neutral = actor->neutral();
    clip.rigid = actor->rigid_vertices();
    clip.marker_sites = place_markers(*actor, options.markers, options.seed);
    act(performance, *actor, clip, progress);
    if (clip.markers) add_faults(*clip.markers, {options.noise, options.missing}, clip.frame_rate, options.seed);
    clip.weights.emplace(performance.frames(), kArkitCount);
    clip.weights->names.assign(kArkitNames.begin(), kArkitNames.end());
    for (std::int64_t f = 0; f < performance.frames(); ++f) {
        const Instant& instant = performance.instants[std::size_t(f)];
        std::copy(instant.weights.begin(), instant.weights.end(), clip.weights->frame(f));
        clip.head_pose.push_back(instant.head);
        clip.gaze.push_back(instant.gaze);
    }
    if (const auto* ict = dynamic_cast<const IctActor*>(actor.get())) clip.blendshapes = ict->blendshapes();
    clip.sound = performance.sound;

    const fs::path parent = fs::absolute(output).parent_path();
    fs::create_directories(parent, error);
    if (error) throw EnvironmentError(fmt::format("cannot make the folder {}: {}", parent.string(), error.message()));
    if (options.texture_size > 0) {
        if (progress) progress("painting the skin", 0, 0);
        skin.emplace(*actor, options.texture_size, options.seed);
        clip.mask = skin->mask();
        clip.texture = std::make_shared<StageTexture>(*actor, *skin, performance.instants);
    }
    if (options.session == "training") clip.takes = perform_training(options.take_frames, options.range_frames, options.seed).takes;
    if (options.scans) {
        if (progress) progress("preparing the scanner", 0, 0);
        const ScannerOptions scanner{.medium_size = options.scan_size, .fine_size = 2 * options.scan_size, .albedo = true, .noise = options.scan_noise,
                                     .holes = options.scan_holes, .seed = options.seed};
        clip.scans = std::make_shared<StageScans>(actor, performance.instants, scanner);
    }
    return io::write_clip(output, clip, {.overwrite = options.force, .texture_video = true, .progress = progress});
}

}  // namespace mien::samples
