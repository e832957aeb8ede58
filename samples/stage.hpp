#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/progress.hpp"
#include "core/result.hpp"
#include "samples/live_take.hpp"
#include "samples/markers.hpp"
#include "samples/performance.hpp"

namespace mien::samples {

/// What `mien stage` makes; every member is one of its options.
struct StageOptions {
    /// --actor: "procedural", or "ict:DIR" for the ICT-FaceKit head in folder DIR.
    std::string actor = "procedural";
    /// --identity: weights of the ICT head's identity modes from the first on; empty: those of the seed.
    std::vector<float> identity;
    /// --say: text to speak. Neither text, weights nor expressions given: kDefaultText, or the range of motion
    /// where the build cannot speak.
    std::optional<std::string> say;
    /// --voice: a voice or language of libespeak-ng.
    std::string voice = "en-gb";
    /// --weights: a Live Link Face CSV that drives the actor.
    std::optional<std::filesystem::path> weights;
    /// --sound: the sound of that take, or of an otherwise silent performance.
    std::optional<std::filesystem::path> sound;
    /// --expressions: a silent range of motion instead of speech.
    bool expressions = false;
    /// --session: "training" (six expressions from neutral to their extremes, then a range of motion), "asymmetric-smile" or
    /// "raised-brow" (which no training shows), instead of speech.
    std::optional<std::string> session;
    /// --take-frames: of each expression of a session.
    int take_frames = 20;
    /// --range-frames: of the range of motion that ends a training session; 0 for none.
    int range_frames = 30;
    /// --seconds: repeats, pads or cuts the performance to so many seconds.
    std::optional<double> seconds;
    /// --frames A:B: frames A to B - 1 alone, of a take its own.
    std::optional<FrameRange> frames;
    /// --fps: frames per second, exact ("30000/1001"); default 30, or the take's own.
    std::optional<Rational> fps;
    /// --markers: how many; 0 for none.
    int markers = kMarkerCount;
    /// --noise: standard deviation of marker noise in each coordinate, mm.
    double noise = 0;
    /// --missing: share of marker samples that are lost, 0 .. 0.9.
    double missing = 0;
    /// --texture-size: side of the texture video in texels; 0 for no texture.
    int texture_size = 1024;
    /// --scans: also write what a scanner sees of every frame: position maps and albedo.
    bool scans = false;
    /// --scan-size: side of the medium maps in texels; the fine ones have twice as many.
    int scan_size = 512;
    /// --scan-noise: standard deviation of every scanned coordinate, mm.
    double scan_noise = 0;
    /// --scan-holes: share of texels that a scan misses, 0 .. 0.9.
    double scan_holes = 0;
    /// --seed: of everything that is drawn by lot.
    std::uint64_t seed = 0;
    /// Replace a clip that is there already.
    bool force = false;
};

/// Options that make no sense are an error, by name. The functions below begin with it.
Result<void> check_options(const StageOptions& options);

/// The performance the options ask for.
Result<Performance> make_performance(const StageOptions& options);
/// The actor the options ask for.
Result<std::unique_ptr<Actor>> make_actor(const StageOptions& options);

/// Makes a sample performance with known truth and writes it as a clip folder (docs/clip.md): neutral mesh, vertices with the
/// head's motion, markers with noise and gaps and their exact sites, the ARKit weights (with their targets for the ICT head;
/// the procedural head is not linear), rigid vertices, head pose, gaze, texture video and sound. Errors: options that make no
/// sense, by name; those of the files. Throws EnvironmentError where the folder cannot be written, or has something in it
/// and `force` is not set.
Result<void> stage(const StageOptions& options, const std::filesystem::path& output, const Progress& progress = {});

}  // namespace mien::samples
