#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdlib>

#include "core/environment_error.hpp"
#include "net/blob_cache.hpp"
#include "net/stream_list.hpp"
#include "player/headless.hpp"
#include "player/options.hpp"
#include "player/window.hpp"

using namespace mien;

namespace {

std::string check_size(const std::string& text, player::Options& options) {
    int width = 0, height = 0;
    char rest = 0;
    if (std::sscanf(text.c_str(), "%dx%d%c", &width, &height, &rest) != 2 || width < 16 || height < 16 || width > 8192 ||
        height > 8192)
        return "a size is WxH, each 16 to 8192, as in 640x720";
    options.width = width;
    options.height = height;
    return {};
}

std::string check_frames(const std::string& text, player::Options& options) {
    long long first = 0, end = 0;
    char rest = 0;
    if (std::sscanf(text.c_str(), "%lld:%lld%c", &first, &end, &rest) != 2 || first < 0 || end <= first)
        return "frames are A:B with A < B; B is not shown";
    options.first_frame = first;
    options.end_frame = end;
    return {};
}

int list_streams(const std::string& server) {
    auto url = net::parse_url(server);
    if (!url.ok()) return fmt::print(stderr, "mien-play: {}\n", url.error().message), 1;
    auto streams = net::list_streams(*url);
    if (!streams.ok()) return fmt::print(stderr, "mien-play: {}\n", streams.error().message), 1;
    for (const auto& stream : *streams) fmt::print("{}{}\n", stream.name, stream.live ? "  live" : "");
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    const double process_start = player::steady_seconds();
    player::Options options;
    CLI::App app("Plays a face performance from a server or a file.");
    app.footer(
        "Keys: space pause, left/right 5 s, up/down 1 min, . , one frame, [ ] speed, backspace normal speed, m mute,\n"
        "f full screen, i statistics, s screenshot, w wireframe, 1 texture, 2 motion, 3 head pose, 4 gaze, 5 light,\n"
        "6 medium detail, 7 fine detail, 8 learnt colour,\n"
        "r reset the view, ? help, q quit. Mouse: left button orbits, right or middle pans, wheel zooms; drop a file to play it.");
    std::string view = "front", size, frames, fps, cache = "default";
    bool no_sound = false;
    double delay = 1000 * options.delay;
    app.add_option("input", options.input, "mien://HOST[:PORT]/NAME or a .mien file");
    app.add_flag("--headless", options.headless, "no window: write --output and/or --sheet");
    app.add_option("-o,--output", options.output, "headless: a .png or .mp4");
    app.add_option("--sheet", options.sheet, "headless: a contact sheet PNG, 8 moments from 3 sides");
    app.add_option("--compare", options.compare, "headless: clip folder with the truth, shown at the left");
    app.add_flag("--benchmark", options.benchmark, "headless: draw every frame as fast as it goes and print the figures");
    app.add_option("--stats-json", options.stats, "write figures of the run");
    app.add_option("--view", view, "front, left or right (the actor's own side)")->check(CLI::IsMember({"front", "left", "right"}));
    app.add_option("--size", size, "WxH of the picture or window")->check([&](const std::string& s) { return check_size(s, options); });
    app.add_option("--time", options.time, "start at this second")->check(CLI::NonNegativeNumber);
    app.add_option("--frames", frames, "A:B, headless: only these")->check([&](const std::string& s) { return check_frames(s, options); });
    app.add_option("--delay", delay, "milliseconds that frames of a live stream wait to be shown evenly; 0 shows them as they come")
        ->check(CLI::Range(0.0, 5000.0))->capture_default_str();
    app.add_option("--seconds", options.seconds, "headless: how much of a live stream (default 10)")->check(CLI::Range(0.05, 86400.0));
    app.add_option("--fps", fps, "frame rate of the .mp4, as 25 or 30000/1001");
    app.add_option("--cache", cache, "folder for blobs kept between runs, or none");
    app.add_option("--wait", options.wait, "seconds to wait for the stream")->check(CLI::PositiveNumber);
    app.add_flag("--loop", options.loop, "start again at the end");
    app.add_flag("--list", options.list, "list the streams of a server and stop");
    app.add_option("--motion-rung", options.motion_rung, "highest rung of motion to ask for, 0 the coarsest (default: all)")->check(CLI::Range(0, 63));
    auto* rung = app.add_option("--texture-rung", options.texture.rung, "rung of texture to ask for, 0 the coarsest (default: the finest)")->check(CLI::Range(0, 63));
    app.add_option("--texture-kbps", options.texture.kbps, "the finest rung of texture of at most this rate, kbit/s")->check(CLI::PositiveNumber)->excludes(rung);
    app.add_flag("--no-sound", no_sound, "silent");
    app.set_version_flag("--version", "mien-play " MIEN_VERSION);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : 2;
    }

    options.sound = !no_sound;
    options.delay = delay / 1000;
    options.view = *render::parse_view(view);
    const auto complain = [](std::string_view message) { return fmt::print(stderr, "mien-play: {}\n", message), 2; };
    if (!fps.empty()) {
        const auto rate = parse_rational(fps);
        if (!rate.ok()) return complain(rate.error().message);
        options.frame_rate = *rate;
    }
    if (cache == "default") {
        options.cache = net::DiskBlobCache::default_folder();
    } else if (cache != "none") {
        options.cache = cache;
    }
    if (options.list && options.input.empty()) return complain("--list needs a server, as mien://HOST");
    try {
        if (options.list) return list_streams(options.input);
        if (options.headless) {
            if (options.input.empty()) return complain("nothing to play: give a mien:// URL or a file");
            if (options.output.empty() && options.sheet.empty() && !options.benchmark)
                return complain("--headless needs --output, --sheet or --benchmark");
            if (options.benchmark && (!options.output.empty() || !options.sheet.empty() || !options.compare.empty()))
                return complain("--benchmark only measures: leave out --output, --sheet and --compare");
            const auto ending = options.output.extension();
            if (!options.output.empty() && ending != ".png" && ending != ".mp4")
                return complain("--output writes .png or .mp4");
            return player::run_headless(options, process_start);
        }
        for (const auto* path : {&options.output, &options.sheet, &options.compare})
            if (!path->empty()) return complain("--output, --sheet and --compare need --headless");
        if (options.benchmark || options.seconds) return complain("--benchmark and --seconds need --headless");
        return player::run_window(options, process_start);
    } catch (const EnvironmentError& error) {
        fmt::print(stderr, "mien-play: {}\n", error.what());
        return 1;
    }
}
