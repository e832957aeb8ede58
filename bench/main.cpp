#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "bench/inputs.hpp"
#include "bench/motion_bench.hpp"
#include "core/environment_error.hpp"
#include "io/clip_folder.hpp"

namespace {

using namespace mien;

struct Arguments {
    std::string clip, ict, take, write, motion = "auto", presets = "file,live,guenter98";
    double rms = 0.1;
    std::int64_t group = -1, first = 600, count = 600, vertices = 11248;
    bool json = false, draco = true;
};

Result<Clip> load(const Arguments& arguments) {
    if (!arguments.ict.empty())
        return bench::ict_clip(arguments.ict, arguments.take, arguments.first, arguments.count, arguments.vertices);
    MIEN_TRY(loaded, io::load_clip(arguments.clip));
    return std::move(loaded.clip);
}

int run(const Arguments& arguments) {
    auto loaded = load(arguments);
    if (!loaded) {
        fmt::print(stderr, "mien-bench: {}\n", loaded.error().message);
        return 1;
    }
    const Clip& clip = *loaded;
    if (!arguments.write.empty()) {
        const auto written = io::write_clip(arguments.write, clip);
        if (!written) fmt::print(stderr, "mien-bench: {}\n", written.error().message);
        return written ? 0 : 1;
    }
    encoder::MotionOptions options;
    options.kind = arguments.motion == "vertices" || (arguments.motion == "auto" && clip.vertices) ? protocol::MotionKind::vertices
                   : arguments.motion == "markers" || (arguments.motion == "auto" && clip.markers)
                       ? protocol::MotionKind::markers
                       : protocol::MotionKind::weights;
    options.rms = arguments.rms;
    options.group_frames = arguments.group >= 0 ? arguments.group : std::int64_t(std::lround(clip.frame_rate.value()));

    nlohmann::json report = nlohmann::json::array();
    if (!arguments.json)
        fmt::print("{:<12} {:>4} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>8} {:>8} {:>9} {:>12}\n", "codec", "k", "kbit/s", "basis",
                   "probab.", "coeff.", "pose", "entropy", "rms", "peak", "encode s", "decode us/f");
    for (const auto& [name, preset] : {std::pair{"file", encoder::MotionPreset::file}, std::pair{"live", encoder::MotionPreset::live},
                                       std::pair{"guenter98", encoder::MotionPreset::guenter98}}) {
        if (arguments.presets.find(name) == std::string::npos) continue;
        options.preset = preset;
        const auto row = bench::bench_motion(clip, options, name);
        if (!row) {
            fmt::print(stderr, "mien-bench: {}: {}\n", name, row.error().message);
            return 1;
        }
        const double decode = row->decode_seconds / double(clip.frame_count());
        if (!arguments.json)
            fmt::print("{:<12} {:>4} {:>9.3f} {:>9.3f} {:>9.3f} {:>9.3f} {:>9.3f} {:>9.3f} {:>8.5f} {:>8.4f} {:>9.1f} {:>12.1f}\n",
                       row->codec, row->components, row->kbps, row->basis, row->probabilities, row->coefficients, row->pose,
                       row->entropy_kbps, row->rms, row->peak, row->encode_seconds, decode * 1e6);
        report.push_back({{"codec", row->codec}, {"components", row->components}, {"kbps", row->kbps}, {"basis_kbps", row->basis},
                          {"probabilities_kbps", row->probabilities}, {"coefficients_kbps", row->coefficients},
                          {"pose_kbps", row->pose}, {"entropy_kbps", row->entropy_kbps}, {"rms", row->rms}, {"peak", row->peak},
                          {"encode_seconds", row->encode_seconds}, {"decode_seconds_per_frame", decode}});
    }
    if (arguments.draco && clip.vertices && clip.neutral) {
        const auto draco = bench::bench_draco(clip, arguments.rms, 20);
        const double kbps = draco.bytes_per_frame * 8 * clip.frame_rate.value() / 1000;
        if (!arguments.json)
            fmt::print("{:<12} {:>4} {:>9.1f} {:>76} {:>12.1f}   ({} bits per coordinate)\n", "draco", "", kbps, "",
                       draco.seconds_per_frame * 1e6, draco.quantisation_bits);
        report.push_back({{"codec", "draco"}, {"kbps", kbps}, {"decode_seconds_per_frame", draco.seconds_per_frame},
                          {"quantisation_bits", draco.quantisation_bits}});
    }
    if (arguments.json) fmt::print("{}\n", report.dump(1));
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app("mien-bench: bitrate, error and speed of the motion codec beside its baselines");
    Arguments arguments;
    app.add_option("clip", arguments.clip, "a clip folder");
    app.add_option("--ict", arguments.ict, "ICT-FaceKit folder: makes a vertex clip instead");
    app.add_option("--take", arguments.take, "with --ict: Live Link Face CSV that drives it");
    app.add_option("--first", arguments.first, "with --ict: first row of the take");
    app.add_option("--count", arguments.count, "with --ict: rows of the take");
    app.add_option("--vertices", arguments.vertices, "with --ict: vertices from the first");
    app.add_option("--write", arguments.write, "write the clip as a clip folder, and stop");
    app.add_option("--motion", arguments.motion, "vertices, markers or weights");
    app.add_option("--rms", arguments.rms, "error to meet, mm or weight units");
    app.add_option("--group", arguments.group, "frames of a group, 0: the whole clip (default 1 s)");
    app.add_option("--presets", arguments.presets, "of file, live, guenter98");
    app.add_flag("--json", arguments.json);
    app.add_flag("!--no-draco", arguments.draco);
    CLI11_PARSE(app, argc, argv);
    if (arguments.clip.empty() == arguments.ict.empty()) {
        fmt::print(stderr, "mien-bench: name a clip folder, or --ict with --take\n");
        return 1;
    }
    try {
        return run(arguments);
    } catch (const EnvironmentError& error) {
        fmt::print(stderr, "mien-bench: {}\n", error.what());
        return 1;
    }
}
