#include <fmt/core.h>

#include <filesystem>

#include "core/parallel.hpp"
#include "io/clip_folder.hpp"
#include "tools/commands.hpp"
#include "tools/console.hpp"
#include "tools/options.hpp"
#include "tools/stored_stream.hpp"
#include "tools/stream_clip.hpp"

namespace mien::tools {
namespace {

using protocol::TrackKind;

struct Request {
    std::string file, output;
    int threads = 0;
    bool overwrite = false, no_texture = false, no_sound = false, quiet = false;
    Rungs rungs;
};

/// Where each track of a stream that has been cut ends.
void tell_ends(const Request& request, const StoredStream& stream, const Clip& clip) {
    const auto say = [&](const std::string& what) { warn(fmt::format("'{}' {}", request.file, what)); };
    if (const auto frames = std::int64_t(stream.header().frames); clip.frame_count() < frames)
        say(fmt::format("holds {} of its {} frames", clip.frame_count(), frames));
    if (stream.track(TrackKind::texture) && !clip.texture && !request.no_texture) say("holds nothing whole of its texture, so the clip has none");
    const protocol::Track* sound = stream.track(TrackKind::sound);
    if (!sound || request.no_sound) return;
    const auto& info = std::get<protocol::SoundInfo>(sound->info);
    if (!clip.sound) return say("holds nothing of its sound, so the clip has none");
    if (const auto samples = std::int64_t(info.samples); clip.sound->length() < samples)
        say(fmt::format("holds {} of its {} of sound", human_time(double(clip.sound->length()) / info.sample_rate), human_time(double(samples) / info.sample_rate)));
}

Result<int> decode(const Request& request) {
    namespace fs = std::filesystem;
    std::error_code ignored;
    // Before the long work.
    if (fs::is_directory(request.output, ignored) && !fs::is_empty(request.output, ignored) && !request.overwrite)
        return fail("'" + request.output + "' is not empty; name another folder, or overwrite what is in it with -y");
    set_thread_count(request.threads);
    MIEN_TRY(stream, StoredStream::open(request.file));
    if (!stream.reader().complete()) warn("'" + request.file + "': " + stream.reader().complaint());
    const Progress progress = progress_bar(request.quiet);
    const auto losses = std::make_shared<Losses>();
    MIEN_TRY(clip, decode_stream(stream, progress, request.no_texture ? Keep::bare : Keep::textured, losses, request.rungs));
    if (request.no_sound) clip.sound.reset();
    io::WriteOptions options;
    options.overwrite = request.overwrite;
    options.progress = progress;
    MIEN_CHECK(io::write_clip(request.output, clip, options));
    end_progress();
    if (!stream.reader().complete()) tell_ends(request, stream, clip);
    if (!request.quiet) fmt::print("{}: {} frames\n", request.output, clip.frame_count());
    int code = kDone;
    for (const Loss& loss : *losses) {
        const std::string what = fmt::format("'{}': {}", request.file, describe(loss, stream.header()));
        if (loss.kind == Loss::Kind::cut) warn(what);   // as all that is missing of a file that has been cut
        else code = fail(what);
    }
    return code;
}

}  // namespace

void add_decode(CLI::App& mien, int& code) {
    auto request = std::make_shared<Request>();
    CLI::App* command = mien.add_subcommand("decode", "Decode a stream file back into a clip folder");
    command->add_option("file", request->file, "Stream file")->required();
    command->add_option("-o,--output", request->output, "Clip folder to write")->required();
    command->add_flag("-y,--overwrite", request->overwrite, "Overwrite what is in the folder");
    command->add_option("--rung", request->rungs.motion, "Highest rung of motion to use, 0 the coarsest (default: all)")->check(CLI::Range(0, 63));
    command->add_option("--texture-rung", request->rungs.texture, "Rung of texture to use, 0 the coarsest (default: the finest)")->check(CLI::Range(0, 63));
    command->add_flag("--no-texture", request->no_texture, "Leave the texture out");
    command->add_flag("--no-sound", request->no_sound, "Leave the sound out");
    add_threads(*command, request->threads);
    command->add_flag("-q,--quiet", request->quiet, "No progress, no summary");
    command->callback([request, &code] { code = guarded([&] { return decode(*request); }); });
}

}  // namespace mien::tools
