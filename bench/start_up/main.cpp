#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "bench/start_up/slow_line.hpp"
#include "core/environment_error.hpp"
#include "core/picture_measures.hpp"
#include "net/server.hpp"
#include "player/face_view.hpp"
#include "player/headless.hpp"
#include "player/playback.hpp"
#include "render/context.hpp"
#include "render/target.hpp"

/// How soon a stream that drives a detail model shows its first picture over a slow line, and what it shows then: the player's own parts, without a window.
namespace {

using namespace mien;
using player::steady_seconds;

struct Request {
    std::string file;
    std::vector<double> kbps{250, 500, 2000}, budgets{0, 300};
    int pictures = 8, width = 640, height = 720;
    double most_seconds = 120;
};

player::SessionOptions session_options(std::uint64_t start_bytes, bool refine) {
    player::SessionOptions options;
    options.sound = true;
    options.wait = 600;
    options.source.start_bytes = start_bytes;
    options.source.refine = refine;
    return options;
}

std::string url_of(std::uint16_t port, const std::string& file) {
    return fmt::format("mien://127.0.0.1:{}/{}", port, std::filesystem::path(file).stem().string());
}

struct StartUp {
    double first = 0;                ///< seconds from connecting to the first finished picture
    std::uint64_t bytes = 0;         ///< received until then
    double whole = 0;                ///< seconds until a picture of the whole model
    std::uint32_t stalls = 0;
    double longest = 0;              ///< seconds that one picture took, the first left out
    std::int64_t frames = 0;
};

/// Plays in real time until the whole model is drawn, as the window does.
Result<StartUp> play(const Request& request, const std::string& url, bool refine) {
    render::OffscreenContext context;
    render::Target target(request.width, request.height, render::live_smoothing());
    const double begun = steady_seconds();
    MIEN_TRY(session, player::open_session(url, session_options(refine ? 0 : net::kWholeModel, refine)));
    player::FaceView face(*session.stream);
    player::Playback playback(std::move(session), nullptr, true);
    const player::Session& playing = playback.session();
    const auto whole = [&] {
        const net::SourceStatistics source = playing.source->statistics();
        return source.model_bytes == source.model_size;
    };
    StartUp out;
    double last_change = 0;   // when maps were last drawn that had come
    for (;;) {
        const double now = steady_seconds();
        if (!playing.unrefined().empty()) return Error{ErrorCode::damaged, playing.unrefined()};
        if (playing.refiner && !face.refining())
            if (auto pictures = playing.refiner->take()) face.refine(std::move(pictures));
        const bool changes = face.refining();
        const auto frame = playback.tick(now);
        if (frame) face.show(*frame);
        if (frame || (changes && face.has_frame())) {
            face.draw(face.framing(float(request.width) / float(request.height), render::View::front).camera(), {}, target);
            target.wait();
            const double drawn = steady_seconds();
            if (out.frames == 0) out.first = drawn - begun, out.bytes = playing.source->statistics().bytes;
            else out.longest = std::max(out.longest, drawn - now);
            out.frames += frame.has_value();
            if (changes) last_change = drawn - begun;
        } else {
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
        }
        const double passed = steady_seconds() - begun;
        // Nothing more comes when the whole model is here and the refiner has had the time to say so.
        const bool settled = whole() && !face.refining() && passed > last_change + 2 && out.frames > 60;
        if (!settled && passed < request.most_seconds) continue;
        out.whole = refine ? last_change : out.first;
        out.stalls = playback.stalls();
        return out;
    }
}

using Pictures = std::map<std::pair<std::int64_t, int>, Image>;   // by frame and view

struct Drawn {
    Pictures pictures;
    std::map<std::pair<std::int64_t, int>, std::vector<std::uint8_t>> face;   ///< pixels that it covers
    std::uint64_t model_bytes = 0;
};

Result<Drawn> draw(const Request& request, const std::string& url, std::uint64_t start_bytes) {
    render::OffscreenContext context;
    render::Target target(request.width, request.height, render::Smoothing::none);
    MIEN_TRY(session, player::open_session(url, [&] {
                 auto options = session_options(start_bytes, false);
                 options.source.rate = 0;
                 return options;
             }()));
    player::FaceView face(*session.stream);
    render::Look silhouette;
    silhouette.lit = silhouette.texture = silhouette.shadows = silhouette.backdrop = false;
    Drawn out;
    out.model_bytes = session.source->statistics().model_bytes;
    session.decode->start();
    const std::int64_t frames = session.stream->frames;
    for (int i = 0; i < request.pictures; ++i) {
        const std::int64_t wanted = (2 * i + 1) * frames / (2 * request.pictures);
        std::optional<player::PlayFrame> frame;
        do frame = session.decode->wait_pop({});
        while (frame && frame->frame < wanted);
        if (!frame) return Error{ErrorCode::truncated, "the stream ends early"};
        face.show(*frame);
        for (int v = 0; v < 3; ++v) {
            const render::Camera camera = face.framing(float(request.width) / float(request.height), render::View(v)).camera();
            face.draw(camera, silhouette, target);
            const Image covered = target.read();
            auto& counted = out.face[{wanted, v}];
            for (std::size_t p = 0; p < covered.pixels.size(); p += 3) counted.push_back(covered.pixels[p] + covered.pixels[p + 1] + covered.pixels[p + 2] > 0);
            face.draw(camera, {}, target);
            out.pictures[{wanted, v}] = target.read();
        }
    }
    return out;
}

struct Likeness {
    double all = 0, worst = 0;   ///< dB
};

Likeness compare(const Drawn& whole, const Drawn& part) {
    double error = 0, pixels = 0, worst = 0;
    for (const auto& [key, truth] : whole.pictures) {
        const auto& counted = whole.face.at(key);
        const double count = double(std::count(counted.begin(), counted.end(), 1));
        const double mean = 255.0 * 255.0 / std::pow(10.0, psnr_y(truth, part.pictures.at(key), counted) / 10);
        error += mean * count;
        pixels += count;
        worst = std::max(worst, mean);
    }
    const auto decibels = [](double mean) { return 10 * std::log10(255.0 * 255.0 / mean); };
    return {decibels(error / pixels), decibels(worst)};
}

Result<void> measure(const Request& request) {
    net::ServerOptions serving;
    serving.folder = std::filesystem::absolute(request.file).parent_path();
    serving.port = 0;
    net::Server server(serving);
    server.start();

    MIEN_TRY(whole, draw(request, url_of(server.port(), request.file), net::kWholeModel));
    fmt::print("{}\n\n| begins with | of the model, kB | PSNR-Y against the whole model, face's own pixels | worst picture |\n| --- | ---: | ---: | ---: |\n",
               std::filesystem::path(request.file).filename().string());
    for (const double budget : request.budgets) {
        MIEN_TRY(part, draw(request, url_of(server.port(), request.file), std::uint64_t(1000 * budget)));
        const Likeness likeness = compare(whole, part);
        fmt::print("| --model-kb {:g} | {:.1f} of {:.1f} | {:.2f} dB | {:.2f} dB |\n", budget, double(part.model_bytes) / 1e3, double(whole.model_bytes) / 1e3, likeness.all,
                   likeness.worst);
    }
    fmt::print("\n| line, kbit/s | whole model first: picture after | kB | refined: picture after | kB | whole model drawn after | stalls | longest picture |\n"
               "| ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n");
    for (const double kbps : request.kbps) {
        const SlowLine line(server.port(), 1000 * kbps);
        const std::string url = url_of(line.port(), request.file);
        MIEN_TRY(all, play(request, url, false));
        MIEN_TRY(refined, play(request, url, true));
        fmt::print("| {:g} | {:.1f} s | {:.0f} | {:.1f} s | {:.0f} | {:.1f} s | {}, {} | {:.0f}, {:.0f} ms |\n", kbps, all.first, double(all.bytes) / 1e3, refined.first,
                   double(refined.bytes) / 1e3, refined.whole, all.stalls, refined.stalls, 1000 * all.longest, 1000 * refined.longest);
        std::fflush(stdout);
    }
    return {};
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app("mien-start-up: time to the first picture over slow lines, with the whole model and with one that is refined while it plays, and what the first pictures are like.");
    Request request;
    app.add_option("file", request.file, "Stream file whose markers drive a detail model")->required()->check(CLI::ExistingFile);
    app.add_option("--kbps", request.kbps, "Rates of the line, kbit/s; 0 for none")->delimiter(',')->capture_default_str();
    app.add_option("--model-kb", request.budgets, "Parts of the model that are drawn beside the whole one, kB")->delimiter(',')->capture_default_str();
    app.add_option("--pictures", request.pictures, "Frames that are compared, each from three sides")->check(CLI::PositiveNumber)->capture_default_str();
    app.add_option("--seconds", request.most_seconds, "Longest time that one line is watched")->check(CLI::PositiveNumber)->capture_default_str();
    CLI11_PARSE(app, argc, argv);
    try {
        const auto done = measure(request);
        if (done.ok()) return 0;
        fmt::print(stderr, "mien-start-up: {}\n", done.error().message);
    } catch (const EnvironmentError& error) {
        fmt::print(stderr, "mien-start-up: {}\n", error.what());
    }
    return 1;
}
