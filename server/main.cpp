#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>

#include "core/environment_error.hpp"
#include "net/server.hpp"
#include "net/url.hpp"

namespace {

constexpr int kFailed = 1, kMisused = 2, kNothingToServe = 3;

int serve(mien::net::ServerOptions options, bool quiet) {
    if (!quiet) options.log = [](const std::string& line) { fmt::print(stderr, "{}\n", line); };
    mien::net::Server server(options);
    for (const std::string& complaint : server.unreadable()) fmt::print(stderr, "mien-serve: not served: {}\n", complaint);
    for (const std::string& remark : server.incomplete()) fmt::print(stderr, "mien-serve: served as far as it goes: {}\n", remark);
    const auto streams = server.streams();
    if (streams.empty() && !options.publish) {
        fmt::print(stderr, "mien-serve: {} holds no stream that can be served; make one with: mien encode CLIP -o {}/NAME.mien\n",
                   options.folder.string(), options.folder.string());
        return kNothingToServe;
    }
    if (!quiet)
        for (const std::string& name : streams)
            fmt::print(stderr, "serving {}\n", mien::net::to_string({options.bind, server.port(), name}));
    // Scripts wait for this line, so it comes last and at once.
    fmt::print("listening on {}\n", mien::net::to_string({options.bind, server.port(), {}}));
    std::fflush(stdout);
    server.run_until_signal();
    if (!quiet) {
        const auto done = server.statistics();
        fmt::print(stderr, "stopped after {} viewers and {:.1f} MB\n", done.accepted, double(done.bytes_sent) / 1e6);
    }
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{"Serves every stream (*.mien) of a folder to players, by name: mien-play mien://HOST:PORT/NAME"};
    mien::net::ServerOptions options;
    std::string folder;
    bool quiet = false;
    app.add_option("folder", folder, "Folder with *.mien files; new files are served as they appear. May be empty with --publish")->required();
    app.add_option("--port", options.port, "TCP port; 0 picks a free one")->capture_default_str()->check(CLI::Range(0, 65535));
    app.add_option("--bind", options.bind, "Address to listen on; 0.0.0.0 or :: serves the whole network")->capture_default_str();
    app.add_option("--max-viewers", options.max_viewers, "Viewers at one time")->capture_default_str()->check(CLI::Range(1, 1000000));
    app.add_flag("--publish", options.publish, "Take live streams (mien live) from programs on this machine");
    app.add_option("--ahead", options.ahead, "Seconds that are sent before they are due")->capture_default_str()->check(CLI::Range(0.0, 3600.0));
    app.set_version_flag("--version", "mien-serve " MIEN_VERSION);
    app.add_flag("--quiet", quiet, "Say nothing but the line 'listening on ...' and what goes wrong");
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : kMisused;
    }
    options.folder = folder;
    try {
        return serve(std::move(options), quiet);
    } catch (const mien::EnvironmentError& e) {
        fmt::print(stderr, "mien-serve: {}\n", e.what());
    } catch (const std::exception& e) {
        fmt::print(stderr, "mien-serve: it stopped by a mistake of its own: {}\n", e.what());
    }
    return kFailed;
}
