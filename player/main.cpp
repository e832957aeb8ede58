#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdlib>

#include "core/environment_error.hpp"
#include "core/frame_rate.hpp"
#include "core/interruption.hpp"
#include "net/blob_cache.hpp"
#include "net/stream_list.hpp"
#include "net/url.hpp"
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
    end_in_order([] { fmt::print(stderr, "mien-play: stopped by a signal; nothing unfinished is left\n"); });
    player::Options options;
    CLI::App app("Plays a face performance from a server or a file.");
    app.footer(
        "Keys: space or p pause, left/right 5 s, up/down 1 min, home start, . , one frame, [ ] speed, { } half and double speed,\n"
        "backspace normal speed, l loop, 9 0 volume, m mute, - + rung of texture, a rung that follows the line, f full screen,\n"
        "i statistics, s screenshot, w wireframe, 1 texture, 2 motion, 3 head pose, 4 gaze, 5 light, 6 medium detail,\n"
        "7 fine detail, 8 learnt colour, r reset the view, h, ? or F1 help, q quit.\n"
        "Mouse: left button orbits, right or middle pans, wheel zooms; drop a file to play it.");
    std::string view = "front", size, frames, fps, cache = "default", texture_rung;
    bool no_sound = false;
    double volume = 100;
    double delay = 1000 * options.delay;
    app.add_option("input", options.input, "mien://HOST[:PORT]/NAME or a .mien file");
    app.add_flag("--headless", options.headless, "no window: write --output and/or --sheet");
    app.add_option("-o,--output", options.output, "headless: a .png or .mp4");
    app.add_option("--sheet", options.sheet, "headless: a contact sheet PNG, 8 moments from 3 sides");
    app.add_option("--compare", options.compare, "headless: clip folder with the truth, shown at the left");
    app.add_flag("-y,--overwrite", options.overwrite, "replace --output and --sheet when they are there already");
    app.add_flag("--benchmark", options.benchmark, "headless: draw every frame as fast as it goes and print the figures");
    app.add_option("--stats-json", options.stats, "write figures of the run");
    app.add_option("--view", view, "front, left or right (the actor's own side)")->check(CLI::IsMember({"front", "left", "right"}));
    app.add_option("--size", size, "WxH of the picture or window")->check([&](const std::string& s) { return check_size(s, options); });
    app.add_option("--time,--start", "start at this moment: seconds, M:S or H:M:S")->check([&](const std::string& s) -> std::string {
        const auto time = player::parse_time(s);
        if (!time.ok()) return time.error().message;
        options.time = *time;
        return {};
    });
    app.add_option("--frames", frames, "A:B, headless: only these")->check([&](const std::string& s) { return check_frames(s, options); });
    app.add_option("--delay", delay, "milliseconds that frames of a live stream wait to be shown evenly; 0 shows them as they come")
        ->check(CLI::Range(0.0, 5000.0))->capture_default_str();
    app.add_option("--seconds", options.seconds, "headless: how much of a live stream (default 10)")->check(CLI::Range(0.05, 86400.0));
    app.add_option("--fps", fps, "frame rate of the .mp4, as 25 or 30000/1001");
    app.add_option("--cache", cache, "folder for blobs kept between runs, or none");
    auto* wait = app.add_option("--wait", options.wait, "seconds to wait for the server and the stream (default: a few tries)")->check(CLI::PositiveNumber);
    app.add_flag("--loop", options.loop, "start again at the end");
    app.add_flag("--pause", options.paused, "begin paused");
    app.add_option("--speed", options.speed, "speed to play at; the pitch of the sound goes with it")->check(CLI::Range(0.25, 4.0));
    app.add_option("--volume", volume, "percent")->check(CLI::Range(0.0, 100.0))->capture_default_str();
    app.add_flag("--mute", options.muted, "begin with the sound off");
    app.add_flag("--fullscreen,--fs", options.full_screen, "begin in full screen");
    app.add_flag("--list", options.list, "list the streams of a server and stop");
    app.add_option("--motion-rung", options.motion_rung, "highest rung of motion to ask for, 0 the coarsest (default: all)")->check(CLI::Range(0, 63));
    auto* rung = app.add_option("--texture-rung,--rung", texture_rung,
                                "rung of texture to ask for, 0 the coarsest, or auto: what the line takes (default: auto in a window, else the finest)")
                     ->check(CLI::Range(0, 63) | CLI::IsMember({"auto"}));
    app.add_option("--texture-kbps", options.texture.kbps, "the finest rung of texture of at most this rate, kbit/s")->check(CLI::PositiveNumber)->excludes(rung);
    app.add_option("--model-kb", options.model_kb,
                   "begin with so many kB of the face model, and what nothing plays without; in a window the rest comes meanwhile (default: headless: all of it, else 0)")
        ->check(CLI::NonNegativeNumber);
    app.add_flag("--no-sound", no_sound, "silent");
    app.set_version_flag("--version", "mien-play " MIEN_VERSION);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : 2;
    }

    options.sound = !no_sound;
    if (wait->count() > 0) options.attempts = -1;
    options.delay = delay / 1000;
    options.volume = volume / 100;
    options.texture.automatic = texture_rung == "auto" || (texture_rung.empty() && !options.texture.kbps && !options.headless);
    if (!texture_rung.empty() && !options.texture.automatic) options.texture.rung = std::stoul(texture_rung);
    options.view = *render::parse_view(view);
    const auto complain = [](std::string_view message) { return fmt::print(stderr, "mien-play: {}\n", message), 2; };
    if (!fps.empty()) {
        const auto rate = parse_frame_rate(fps);
        if (!rate.ok()) return complain("--fps " + rate.error().message);
        options.frame_rate = *rate;
    }
    if (cache == "default") {
        options.cache = net::DiskBlobCache::default_folder();
    } else if (cache != "none") {
        options.cache = cache;
    }
    if (options.model_kb && !options.input.empty() && !net::looks_like_url(options.input))
        return complain("--model-kb is for streams of a server: a file has its whole model at once");
    if (options.list && options.input.empty()) return complain("--list needs a server, as mien://HOST");
    if (const auto outputs = player::check_outputs(options); !outputs.ok())
        return complain(outputs.error().message), outputs.error().code == ErrorCode::invalid ? 2 : 1;
    try {
        if (options.list) return list_streams(options.input);
        if (options.headless) {
            if (options.paused || options.muted || options.full_screen || app.count("--speed") || app.count("--volume"))
                return complain("--pause, --speed, --volume, --mute and --fullscreen are for the window");
            if (texture_rung == "auto") return complain("--texture-rung auto is for the window: without one nothing is due");
            if (options.input.empty()) return complain("nothing to play: give a mien:// URL or a file");
            if (options.output.empty() && options.sheet.empty() && !options.benchmark)
                return complain("--headless needs --output, --sheet or --benchmark");
            if (options.benchmark && (!options.output.empty() || !options.sheet.empty() || !options.compare.empty()))
                return complain("--benchmark only measures: leave out --output, --sheet and --compare");
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
