#include <fmt/core.h>

#include "core/frame_rate.hpp"
#include "core/parallel.hpp"
#include "samples/stage.hpp"
#include "tools/commands.hpp"
#include "tools/console.hpp"
#include "tools/options.hpp"

namespace mien::tools {
namespace {

struct Request {
    samples::StageOptions options;
    std::string output, say, weights, sound, frames, fps, session;
    int threads = 0;
    bool quiet = false;
};

/// "A:B", both non-negative and A < B.
std::optional<samples::FrameRange> parse_frames(const std::string& text) {
    const auto colon = text.find(':');
    if (colon == text.npos) return std::nullopt;
    try {
        std::size_t used_a = 0, used_b = 0;
        const std::string a = text.substr(0, colon), b = text.substr(colon + 1);
        samples::FrameRange range;
        range.first = std::stoll(a, &used_a);
        range.end = std::stoll(b, &used_b);
        if (used_a != a.size() || used_b != b.size() || range.first < 0 || range.end <= range.first) return std::nullopt;
        return range;
    } catch (const std::exception&) {
        return std::nullopt;
    }
}

Result<int> stage(Request& request) {
    samples::StageOptions& options = request.options;
    if (!request.say.empty()) options.say = request.say;
    if (!request.weights.empty()) options.weights = request.weights;
    if (!request.session.empty()) options.session = request.session;
    if (!request.sound.empty()) options.sound = request.sound;
    if (!request.frames.empty()) options.frames = parse_frames(request.frames);
    if (!request.fps.empty()) {
        MIEN_TRY(fps, parse_frame_rate(request.fps));
        options.fps = fps;
    }
    if (const auto sense = samples::check_options(options); !sense) return misused(sense.error().message);
    set_thread_count(request.threads);
    MIEN_CHECK(samples::stage(options, request.output, progress_bar(request.quiet)));
    end_progress();
    if (!request.quiet && options.scans) fmt::print("{}: a clip folder; learn a face from it with: mien train {} -o NAME.model\n", request.output, request.output);
    else if (!request.quiet) fmt::print("{}: a clip folder; encode it with: mien encode {} -o NAME.mien\n", request.output, request.output);
    return kDone;
}

}  // namespace

void add_stage(CLI::App& mien, int& code) {
    auto request = std::make_shared<Request>();
    samples::StageOptions& options = request->options;
    CLI::App* command = mien.add_subcommand("stage", "Make a sample performance with known truth, as a clip folder");
    command->add_option("-o,--output", request->output, "Clip folder to write")->required();
    command->add_flag("-y,--overwrite", options.force, "Replace a clip that is there already");
    command->add_flag("-f,--force", options.force)->group("");   // the same, not shown: the name it had
    command->add_option("--actor", options.actor, "procedural, or ict:DIR for the ICT-FaceKit head in folder DIR")->capture_default_str();
    command->add_option("--identity", options.identity, "Weights of the ICT head's identity modes, from the first on: standard deviations, -10 to 10")->delimiter(',');
    auto* say = command->add_option("--say", request->say, "Text to speak");
    command->add_option("--voice", options.voice, "Voice or language of libespeak-ng")->capture_default_str();
    auto* weights = command->add_option("--weights", request->weights, "Live Link Face CSV that drives the actor")->check(CLI::ExistingFile)->excludes(say);
    command->add_option("--sound", request->sound, "Sound of that take (WAV, FLAC)")->check(CLI::ExistingFile)->excludes(say);
    command->add_flag("--expressions", options.expressions, "A silent range of motion instead of speech")->excludes(say)->excludes(weights);
    command->add_option("--session", request->session, "A silent session for mien train instead of speech: training, asymmetric-smile or raised-brow")->excludes(say)->excludes(weights);
    command->add_option("--take-frames", options.take_frames, "Frames of each expression of a session")->capture_default_str();
    command->add_option("--range-frames", options.range_frames, "Frames of the range of motion that ends a training session; 0 for none")->capture_default_str();
    command->add_option("--seconds", options.seconds, "Repeat, pad or cut the performance to so many seconds")->check(above_zero());
    command->add_option("--frames", request->frames, "A:B, only these frames (B not included); of --weights, the take's own")
        ->check([](const std::string& text) { return parse_frames(text) ? "" : "must be A:B with 0 <= A < B"; }, "", "");
    command->add_option("--fps", request->fps, "Frames per second: 24, 25, 30, 60, 30000/1001 (default 30, or the take's own)")->check(frame_rate());
    command->add_option("--markers", options.markers, "Surface markers; 0 for none")->check(CLI::Range(0, 20000))->capture_default_str();
    command->add_option("--noise", options.noise, "Standard deviation of marker noise, mm")->check(not_negative());
    command->add_option("--missing", options.missing, "Share of marker samples that are lost")->check(number_from(0, 0.9));
    command->add_option("--texture-size", options.texture_size, "Side of the texture, texels; 0 for none")->check(CLI::Range(0, 8192))->capture_default_str();
    command->add_flag("--scans", options.scans, "Also write position maps and albedo of every frame, for mien train");
    command->add_option("--scan-size", options.scan_size, "Side of the medium position maps, texels; fine maps and albedo have twice as many")->capture_default_str();
    command->add_option("--scan-noise", options.scan_noise, "Standard deviation of scanned positions, mm")->check(not_negative());
    command->add_option("--scan-holes", options.scan_holes, "Share of texels that a scan misses")->check(number_from(0, 0.9));
    command->add_option("--seed", options.seed, "Seed of everything that is drawn by lot")->capture_default_str();
    add_threads(*command, request->threads, "; the result is the same for any number");
    command->add_flag("-q,--quiet", request->quiet, "No progress, no summary");
    command->callback([request, &code] { code = guarded([&] { return stage(*request); }); });
}

}  // namespace mien::tools
