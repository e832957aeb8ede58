#include <fmt/core.h>

#include <charconv>
#include <cmath>
#include <filesystem>

#include "core/frame_rate.hpp"
#include "core/geometry.hpp"
#include "core/parallel.hpp"
#include "encoder/stream_encoder.hpp"
#include "io/clip_folder.hpp"
#include "io/file.hpp"
#include "protocol/stream_file.hpp"
#include "tools/commands.hpp"
#include "tools/console.hpp"
#include "tools/model_file.hpp"
#include "tools/options.hpp"
#include "tools/stored_stream.hpp"
#include "tools/training_take.hpp"

namespace mien::tools {
namespace {

constexpr double kStranger = 5;   // mm RMS: no expression is so far from rest in all frames

struct Request {
    std::string clip, output, name, fps, model, basis;
    std::string motion = "auto", preset = "file", group = "1", unit;
    std::optional<double> rms, peak, motion_kbps;
    std::string texture_codec = "h264", texture_speed;
    std::vector<std::string> texture_rungs;
    std::optional<double> texture_kbps, texture_quality;
    std::string sound_codec = "opus";
    double sound_kbps = 48;
    int rungs = 1;
    bool texture_asked = false, sound_asked = false, no_texture = false, no_sound = false, overwrite = false, quiet = false;
    int threads = 0;
};

/// Checks "1.5" or "whole".
std::string group_length(const std::string& text) {
    std::string seconds = text;
    return text == "whole" || number_from(0.001, 3600)(seconds).empty() ? "" : "must be a number of seconds up to 3600, or 'whole'";
}

/// "240" or "240@512".
std::optional<encoder::TextureRung> texture_rung(const std::string& text) {
    encoder::TextureRung rung;
    const std::size_t at = text.find('@');
    const auto whole = [](const std::string& digits, auto& number) {
        const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
        return error == std::errc() && end == digits.data() + digits.size() && number > 0;
    };
    if (!whole(text.substr(0, at), rung.kbps) || (at != std::string::npos && !whole(text.substr(at + 1), rung.width)))
        return std::nullopt;
    return rung;
}

Result<encoder::StreamOptions> stream_options(const Request& request, const Clip& clip, const std::optional<StoredTake>& take) {
    using protocol::MotionKind;
    encoder::StreamOptions options;
    options.name = request.name;
    // A trained model brings the whole face, its colour too: markers alone are sent, and a video of the skin only if asked for.
    MotionKind kind = take ? take->take.info.kind : !request.model.empty() ? MotionKind::markers : clip.vertices ? MotionKind::vertices : clip.markers ? MotionKind::markers : MotionKind::weights;
    if (request.motion == "vertices") kind = MotionKind::vertices;
    if (request.motion == "markers") kind = MotionKind::markers;
    if (request.motion == "weights") kind = MotionKind::weights;
    const bool there = kind == MotionKind::vertices ? clip.vertices.has_value() : kind == MotionKind::markers ? clip.markers.has_value() : clip.weights.has_value();
    const char* name = kind == MotionKind::vertices ? "vertices" : kind == MotionKind::markers ? "markers" : "weights";
    if (!there)
        return Error{ErrorCode::missing, fmt::format("the clip has no {}{}", name, request.motion == name ? "" : take ? ", which move the face of '" + request.basis + "'" : ", which move the face of '" + request.model + "'")};
    options.motion.kind = kind;
    options.motion.preset = request.preset == "live" ? encoder::MotionPreset::live
                            : request.preset == "guenter98" ? encoder::MotionPreset::guenter98
                                                            : encoder::MotionPreset::file;
    options.motion.rms = request.rms;
    // A tenth of a millimetre is what skin shows; weights run from 0 to 1 and half a percent moves skin by about as much.
    if (!request.rms && !request.peak && !request.motion_kbps) options.motion.rms = kind == MotionKind::weights ? 0.005 : 0.1;
    options.motion.peak = request.peak;
    options.motion.kbps = request.motion_kbps;
    options.motion.rungs = request.rungs;
    options.group_seconds.reset();
    if (request.group != "whole") options.group_seconds = std::stod(request.group);
    if (request.no_texture || ((!request.model.empty() || take) && !request.texture_asked)) {
        options.texture.reset();
    } else {
        options.texture->codec = request.texture_codec;
        options.texture->kbps = request.texture_kbps;
        options.texture->quality = request.texture_quality;
        options.texture->speed = request.texture_speed;
        for (const std::string& text : request.texture_rungs) options.texture->rungs.push_back(*texture_rung(text));
    }
    if (request.no_sound) {
        options.sound.reset();
    } else {
        options.sound->codec = request.sound_codec;
        options.sound->kbps = request.sound_kbps;
    }
    return options;
}

/// What was asked of tracks that there are not.
void warn_of_unused(const Request& request, const Clip& clip, const encoder::StreamOptions& options) {
    if (request.texture_asked && options.texture && !clip.texture) warn("the clip has no texture, so what was asked of it is not used");
    if (request.texture_asked && request.no_texture) warn("the texture is left out, so what was asked of it is not used");
    if (options.motion.kind == protocol::MotionKind::weights && clip.neutral && clip.blendshapes.empty() && !options.model)
        warn("the weights have no target shapes (blendshapes of clip.json), so they will not move the face");
    if (request.sound_asked && (request.no_sound || !clip.sound)) warn("there is no sound to encode, so what was asked of it is not used");
}

/// Markers that the model's do not resemble even at the clip's most restful: it would be found out only after long work.
void warn_of_strangers(const Clip& clip, const encoder::StreamOptions& options) {
    const Points* rest = model::driving_markers(options.model->model);
    if (options.motion.kind != protocol::MotionKind::markers || !rest || !clip.markers || rest->rows() != clip.markers->points) return;
    const std::int64_t shown = std::min<std::int64_t>(clip.markers->frames, 100);
    std::optional<double> least;
    for (std::int64_t i = 0; i < shown; ++i) {
        const Points at = clip.markers->frame(i * clip.markers->frames / shown);
        if (!at.allFinite()) continue;
        Points moved = *rest;
        apply_pose(fit_rigid(*rest, at), moved);
        const double rms = std::sqrt(double((moved - at).squaredNorm()) / double(at.rows()));
        least = std::min(least.value_or(rms), rms);
    }
    if (least && *least > kStranger)
        warn(fmt::format("the markers lie {:.1f} mm from those of the model, however the head is turned: is this the same actor, with the same markers in the same order and unit?", *least));
}

Result<int> encode(const Request& request) {
    namespace fs = std::filesystem;
    const fs::path output = request.output;
    MIEN_CHECK(may_write(output, request.overwrite, {request.clip, request.model, request.basis}));
    set_thread_count(request.threads);
    const Progress progress = progress_bar(request.quiet);

    io::LoadOptions load;
    load.progress = progress;
    if (!request.fps.empty()) {
        MIEN_TRY(fps, parse_frame_rate(request.fps));
        load.frame_rate = fps;
    }
    if (!request.unit.empty()) load.unit = request.unit == "m" ? Unit::m : request.unit == "cm" ? Unit::cm : Unit::mm;
    MIEN_TRY(loaded, io::load_clip(request.clip, load));
    for (const std::string& text : loaded.warnings) warn(text);
    const Clip& clip = loaded.clip;
    std::optional<StoredTake> take;
    if (!request.basis.empty()) {
        MIEN_TRY(stored, read_take(request.basis));
        take = std::move(stored);
    }
    MIEN_TRY(options, stream_options(request, clip, take));
    if (take) {
        options.motion.training = &take->take;
        options.model = take->model;
    }
    if (!request.model.empty()) {
        MIEN_TRY(model, read_model(request.model));
        if (take) MIEN_CHECK(same_reference(*take, model.model, request.model));
        options.model = std::move(model);
    }
    if (options.name.empty()) options.name = output.stem().string();

    warn_of_unused(request, clip, options);
    if (options.model) warn_of_strangers(clip, options);

    // Before the long work: is there a place to write to?
    io::OutputFile file(output, request.overwrite);
    MIEN_TRY(stream, encoder::encode_stream(clip, options, progress));
    protocol::StreamFileWriter writer([&](ByteView bytes) { file.write(bytes); }, stream.header, stream.blobs);
    for (const protocol::Group& group : stream.groups) writer.add(group);
    writer.finish();
    file.commit_to_disk();
    end_progress();
    for (const std::string& text : stream.warnings) warn(text);
    if (!request.quiet) {
        const double seconds = double(stream.header.frames) / stream.header.frame_rate.value();
        const char* unit = options.motion.kind == protocol::MotionKind::weights ? "" : " mm";
        fmt::print("{}: {}, {} frame{}, {}, {:.1f} kbit/s, motion error {:.4f}{} RMS, {:.3f}{} peak\n", request.output, human_bytes(writer.size()),
                   stream.header.frames, stream.header.frames == 1 ? "" : "s", human_time(seconds), double(writer.size()) * 8 / 1000 / std::max(seconds, 1e-9), stream.motion_rms, unit,
                   stream.motion_peak, unit);
    }
    return kDone;
}

}  // namespace

void add_encode(CLI::App& mien, int& code) {
    auto request = std::make_shared<Request>();
    CLI::App* command = mien.add_subcommand("encode", "Encode a clip into a stream file");
    command->add_option("clip", request->clip, "Clip folder, folder of numbered OBJs, or a single recording (docs/clip.md)")->required();
    command->add_option("-o,--output", request->output, "Stream file to write, usually NAME.mien")->required();
    command->add_flag("-y,--overwrite", request->overwrite, "Overwrite the output file");
    command->add_option("--name", request->name, "Name of the stream (default: the output's)");
    command->add_option("--fps", request->fps, "Frames per second, for clips that do not say: 30, 30000/1001")->check(frame_rate());
    command->add_option("--unit", request->unit, "Unit of lengths, for clips that do not say")->check(CLI::IsMember({"mm", "cm", "m"}));
    command->add_option("--motion", request->motion, "What is sent: vertices, markers or weights (default: the first the clip has)")
        ->check(CLI::IsMember({"auto", "vertices", "markers", "weights"}));
    command->add_option("--model", request->model, "Model file of mien train: only markers, pose and sound are sent; with --texture-* also a video")
        ->check(CLI::ExistingFile);
    command->add_option("--basis", request->basis, "Stream file of a training take: its motion basis and face model, instead of ones made from this clip (markers or weights)")
        ->check(CLI::ExistingFile);
    auto* rms = command->add_option("--rms", request->rms, "Motion error to meet, RMS, mm (default 0.1; weights: 0.005); may be given with --peak")->check(motion_error());
    auto* peak = command->add_option("--peak", request->peak, "Motion error to meet, largest of all points and frames, mm (default: 10 times the RMS error)")->check(motion_error());
    auto* rate = command->add_option("--motion-kbps", request->motion_kbps, "Bits for motion instead of an error, kbit/s: basis, probabilities and coefficients over the clip's length")->check(number_from(0.001, 1e6));
    rms->excludes(rate);
    peak->excludes(rate);
    command->add_option("--rungs", request->rungs, "Rungs of motion: the highest keeps the asked error, each lower one twice that of the next")
        ->check(CLI::Range(1, encoder::MotionOptions::kMaxRungs))
        ->capture_default_str();
    command->add_option("--preset", request->preset, "file: looks ahead inside groups; live: causal, one object a frame; guenter98: the 1998 baseline")
        ->check(CLI::IsMember({"file", "live", "guenter98"}))
        ->capture_default_str();
    command->add_option("--group", request->group, "Seconds per group, or 'whole'")->check(group_length, "", "")->capture_default_str();
    auto* texture_codec = command->add_option("--texture-codec", request->texture_codec, "mpeg4, h264, hevc or av1")->check(CLI::IsMember({"mpeg4", "h264", "hevc", "av1"}))->capture_default_str();
    auto* texture_rate = command->add_option("--texture-kbps", request->texture_kbps, "Texture bit rate, kbit/s")->check(number_from(1, 1e6));
    auto* texture_quality = command->add_option("--texture-quality", request->texture_quality, "Texture quality 0 .. 100 instead of a rate")->check(number_from(0, 100))->excludes(texture_rate);
    auto* texture_rungs = command->add_option("--texture-rungs", request->texture_rungs, "Several texture bit rates in one stream, kbit/s, the lowest first, each with its width in texels if it is not the clip's: 60@512,240,1000")
        ->delimiter(',')
        ->check([](const std::string& text) { return texture_rung(text) ? "" : "must be kbit/s, or kbit/s@texels"; }, "", "")
        ->excludes(texture_rate)
        ->excludes("--texture-quality");
    auto* texture_speed = command->add_option("--texture-speed", request->texture_speed, "The codec's own preset name");
    auto* sound_codec = command->add_option("--sound-codec", request->sound_codec, "opus or aac")->check(CLI::IsMember({"opus", "aac"}))->capture_default_str();
    auto* sound_rate = command->add_option("--sound-kbps", request->sound_kbps, "Sound bit rate, kbit/s")->check(number_from(1, 10000))->capture_default_str();
    command->add_flag("--no-texture", request->no_texture, "Leave the texture out");
    command->add_flag("--no-sound", request->no_sound, "Leave the sound out");
    add_threads(*command, request->threads, "; the result is the same for any number");
    command->add_flag("-q,--quiet", request->quiet, "No progress, no summary");
    command->callback([=, &code] {
        request->texture_asked = texture_codec->count() + texture_rate->count() + texture_quality->count() + texture_rungs->count() + texture_speed->count() > 0;
        request->sound_asked = sound_codec->count() + sound_rate->count() > 0;
        code = guarded([&] { return encode(*request); });
    });
}

}  // namespace mien::tools
