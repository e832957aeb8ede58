#include <fmt/chrono.h>
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <nlohmann/json.hpp>

#include "bench/detail_views.hpp"
#include "bench/geometry_codec.hpp"
#include "bench/inputs.hpp"
#include "bench/motion_run.hpp"
#include "bench/picture_row.hpp"
#include "bench/report_tables.hpp"
#include "bench/short_clip.hpp"
#include "bench/suite.hpp"
#include "bench/synthesis_run.hpp"
#include "bench/timing.hpp"
#include "decoder/av_texture.hpp"
#include "encoder/texture_encoder.hpp"
#include "io/clip_folder.hpp"
#include "io/image_file.hpp"
#include "io/output_guard.hpp"
#include "tools/console.hpp"
#include "tools/stored_stream.hpp"

namespace {

using namespace mien;

struct Arguments {
    std::vector<std::string> clips, made;
    std::string json, csv, html, markdown, model, sheet;
    double high_pass = 4;
    bench::SuiteOptions suite;
    std::int64_t frames = 0;
    bool smoke = false, quiet = false, list = false, no_geometry = false, no_timing = false, no_texture = false, no_views = false, synthesis = false, speed = false;
    std::int64_t known = 1200;
    std::string preset = "live";
    std::string ict, take, write, picture_row;
    std::int64_t picture_frame = 0;
    std::int64_t first = 600, count = 600, vertices = 11248;
};

int complain(const std::string& text) {
    tools::end_progress();
    fmt::print(stderr, "mien-bench: error: {}\n", text);
    return tools::kFailed;
}

int list_codecs() {
    const bench::GeometryCodecs codecs = bench::geometry_codecs();
    for (const auto& codec : codecs.codecs) fmt::print("{:<20} {:<22} {}\n", codec->name, codec->library, codec->what);
    for (const auto& [name, why] : codecs.absent) fmt::print("{:<20} {:<22} {}\n", name, "absent", why);
    for (const std::string& name : encoder::texture_codecs()) fmt::print("{:<20} {:<22} texture\n", name, "FFmpeg");
    return tools::kDone;
}

int write_ict(const Arguments& arguments) {
    const auto clip = bench::ict_clip(arguments.ict, arguments.take, arguments.first, arguments.count, arguments.vertices);
    if (!clip.ok()) return complain(clip.error().message);
    const auto written = io::write_clip(arguments.write, *clip);
    return written.ok() ? tools::kDone : complain(written.error().message);
}

void print_table(const bench::Table& table) {
    if (table.empty()) return;
    std::vector<std::size_t> widths;
    for (const std::string& column : table.columns) widths.push_back(column.size());
    for (const auto& row : table.rows)
        for (std::size_t i = 0; i < row.cells.size(); ++i) widths[i] = std::max(widths[i], row.cells[i].size());
    fmt::print("\n{}\n", table.title);
    const auto line = [&](const std::vector<std::string>& cells) {
        for (std::size_t i = 0; i < cells.size(); ++i)
            i == 0 ? fmt::print("{:<{}}", cells[i], widths[i]) : fmt::print("  {:>{}}", cells[i], widths[i]);
        fmt::print("\n");
    };
    line(table.columns);
    for (const auto& row : table.rows) line(row.cells);
}

/// A trained model's layers drawn beside the scans of the clip.
int views_of_model(const Arguments& arguments) {
    const Progress progress = tools::progress_bar(arguments.quiet);
    const auto draw = [&]() -> Result<bench::DetailViews> {
        MIEN_TRY(stored, tools::StoredStream::open(arguments.model));
        MIEN_TRY(face, stored.model());
        for (const protocol::Layer& layer : stored.reader().manifest().layers) {
            if (layer.kind != protocol::LayerKind::static_albedo || layer.blobs.empty() || !stored.blob(layer.blobs.front())) continue;
            MIEN_TRY(picture, decoder::decode_picture(*stored.blob(layer.blobs.front())));
            face.static_albedo = std::move(picture);
        }
        MIEN_TRY(loaded, io::load_clip(arguments.clips.front(), {.frame_rate = {}, .unit = {}, .progress = progress}));
        MIEN_TRY(pair, analysis::ModelOnClip::create(face, loaded.clip, arguments.high_pass));
        return bench::view_detail(face, pair, loaded.clip.markers->frames, arguments.suite.view_pictures, progress);
    };
    const auto views = draw();
    if (!views.ok()) return complain(views.error().message);
    tools::end_progress();
    if (!arguments.sheet.empty()) io::write_image(arguments.sheet, views->sheet);
    bench::Table table;
    table.title = fmt::format("{} drawn with {}: {} frames from three cameras, against the scans drawn alike", arguments.clips.front(), arguments.model, views->frames.size());
    table.columns = {"layers", "PSNR-Y dB", "SSIM", "worst dB"};
    nlohmann::ordered_json json;
    for (const auto& row : views->rows) {
        table.rows.push_back({{row.name, fmt::format("{:.2f}", row.score.psnr_y()), fmt::format("{:.4f}", row.score.ssim()), fmt::format("{:.2f}", row.score.worst_psnr_y())}, false});
        json[row.name] = {{"psnr_y_db", row.score.psnr_y()}, {"ssim", row.score.ssim()}, {"worst_psnr_y_db", row.score.worst_psnr_y()}};
    }
    if (!arguments.quiet) print_table(table);
    if (!arguments.json.empty()) bench::write_file(arguments.json, json.dump(2) + "\n");
    return tools::kDone;
}

/// What a frame of a trained model costs on one core.
int time_model(const Arguments& arguments) {
    const auto measure = [&]() -> Result<bench::SynthesisTimes> {
        MIEN_TRY(stored, tools::StoredStream::open(arguments.model));
        MIEN_TRY(face, stored.model());
        return bench::time_synthesis(face, 10 * arguments.suite.timing_rounds, tools::progress_bar(arguments.quiet));
    };
    const auto times = measure();
    if (!times.ok()) return complain(times.error().message);
    tools::end_progress();
    bench::Table table;
    table.title = fmt::format("{}: maps of {} and {} texels across, one core, median ms a frame", arguments.model, times->medium_side, times->fine_side);
    table.columns = {"layer", "MB read", "only read", "evaluated", "of reading", "plain twin", "of evaluated", "differ by"};
    nlohmann::ordered_json json = {{"load_s", times->load},
                                   {"vertices", times->vertices},
                                   {"markers", times->markers},
                                   {"components", times->components},
                                   {"compose_s", times->compose},
                                   {"base_shape_ms", 1e3 * times->base_shape},
                                   {"deformation_ms", 1e3 * times->deformation}};
    for (const auto& row : times->rows) {
        table.rows.push_back({{row.name, fmt::format("{:.1f}", double(row.bytes) / 1e6), fmt::format("{:.2f}", 1e3 * row.read), fmt::format("{:.2f}", 1e3 * row.fast),
                               fmt::format("{:.2f}x", row.ratio), fmt::format("{:.2f}", 1e3 * row.plain), fmt::format("{:.2f}x", row.plain_ratio),
                               fmt::format("{:.1e}", row.difference)}, false});
        json["layers"][row.name] = {{"bytes", row.bytes},        {"values", row.values},           {"read_ms", 1e3 * row.read},
                                    {"evaluated_ms", 1e3 * row.fast}, {"ratio", row.ratio},        {"plain_ms", 1e3 * row.plain},
                                    {"plain_ratio", row.plain_ratio}, {"difference", row.difference}};
    }
    if (!arguments.quiet) {
        print_table(table);
        fmt::print("\nload {:.2f} s, of {} vertices and {} markers; composed with a motion basis in {:.3f} s; base shape from {} coefficients {:.3f} ms, d1 and d2 {:.3f} ms\n",
                   times->load, times->vertices, times->markers, times->compose, times->components, 1e3 * times->base_shape, 1e3 * times->deformation);
    }
    if (!arguments.json.empty()) bench::write_file(arguments.json, json.dump(2) + "\n");
    return tools::kDone;
}

/// What training on a clip takes, and coding it when the basis is known.
int time_codec(const Arguments& arguments) {
    const Progress progress = tools::progress_bar(arguments.quiet);
    const auto measure = [&]() -> Result<bench::MotionTimes> {
        MIEN_TRY(loaded, io::load_clip(arguments.clips.front(), {.frame_rate = {}, .unit = {}, .progress = progress}));
        const Clip clip = arguments.frames > 0 ? bench::first_frames(loaded.clip, arguments.frames) : std::move(loaded.clip);
        MIEN_TRY(kind, bench::motion_kind(clip, arguments.suite.motion));
        if (!kind) return Error{ErrorCode::missing, "clip '" + clip.name + "' has no motion"};
        encoder::MotionOptions options;
        options.kind = *kind;
        options.preset = arguments.preset == "live" ? encoder::MotionPreset::live : encoder::MotionPreset::file;
        options.rms = !arguments.suite.rms.empty() ? arguments.suite.rms.front() : *kind == protocol::MotionKind::weights ? 0.005 : 0.1;
        options.group_frames = 0;
        return bench::time_motion(clip, options, arguments.known, arguments.suite.timing_rounds, progress);
    };
    const auto times = measure();
    if (!times.ok()) return complain(times.error().message);
    tools::end_progress();
    const double per_second = double(times->known_frames) / times->known;
    if (!arguments.quiet)
        fmt::print("training on {} frames of {} points: {:.2f} s with {} threads; {} components, RMS {:.4f}\n"
                   "known basis, one thread: {:.0f} frames/s over {} frames, {:.3f} ms the median frame; {} bytes, RMS {:.4f}\n"
                   "reading: {:.1f} ns a binary decision, {} decisions in {} bytes\n",
                   times->frames, times->points, times->training, times->threads, times->components, times->rms, per_second, times->known_frames,
                   1e3 * times->known_median, times->known_bytes, times->known_rms, 1e9 * times->decision, times->decisions, times->frame_bytes);
    if (!arguments.quiet && times->coder_decisions > 0)
        fmt::print("the entropy coder alone: {:.1f} ns a binary decision, {} decisions\n", 1e9 * times->coder, times->coder_decisions);
    if (!arguments.json.empty()) {
        const nlohmann::ordered_json json = {{"frames", times->frames},
                                             {"points", times->points},
                                             {"components", times->components},
                                             {"threads", times->threads},
                                             {"training_s", times->training},
                                             {"rms", times->rms},
                                             {"known_frames", times->known_frames},
                                             {"known_frames_per_s", per_second},
                                             {"known_median_ms", 1e3 * times->known_median},
                                             {"known_bytes", times->known_bytes},
                                             {"known_rms", times->known_rms},
                                             {"decisions", times->decisions},
                                             {"frame_bytes", times->frame_bytes},
                                             {"decision_ns", 1e9 * times->decision},
                                             {"coder_decisions", times->coder_decisions},
                                             {"coder_decision_ns", 1e9 * times->coder}};
        bench::write_file(arguments.json, json.dump(2) + "\n");
    }
    return tools::kDone;
}

int write_picture_row(const Arguments& arguments) {
    const Progress progress = tools::progress_bar(arguments.quiet);
    auto loaded = io::load_clip(arguments.clips.front(), {.frame_rate = {}, .unit = {}, .progress = progress});
    if (!loaded.ok()) return complain(loaded.error().message);
    const Clip clip = arguments.frames > 0 ? bench::first_frames(loaded->clip, arguments.frames) : std::move(loaded->clip);
    std::vector<std::string> codecs;
    for (const std::string& codec : encoder::texture_codecs())
        if (bench::chosen(arguments.suite.texture_codecs, codec)) codecs.push_back(codec);
    const auto row = bench::picture_row(clip, codecs, arguments.suite.texture_kbps.front(), arguments.picture_frame, progress);
    if (!row.ok()) return complain(row.error().message);
    io::write_image(arguments.picture_row, *row, 85);
    tools::end_progress();
    return tools::kDone;
}

std::string command_line(int argc, char** argv) {
    std::string line = "mien-bench";
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        line += word.find_first_of(" *?'\"$&;|<>()") == std::string::npos ? " " + word : " '" + word + "'";
    }
    return line;
}

/// What went wrong in rows of these clips, for people. Returns how many.
int tell_failures(const bench::Report& report) {
    int failures = 0;
    const auto tell = [&](const std::string& what, const std::string& why) {
        if (why.empty()) return;
        ++failures;
        tools::end_progress();
        fmt::print(stderr, "mien-bench: {}: {}\n", what, why);
    };
    for (const auto& row : report.geometry) tell(row.clip + ", " + row.codec, row.failed);
    for (const auto& row : report.texture)
        tell(fmt::format("{}, {} {} at {} kbit/s", row.clip, row.series, row.codec, row.asked_kbps), row.failed);
    return failures;
}

void write_pages(const Arguments& arguments, const bench::Report& report) {
    if (!arguments.csv.empty()) bench::write_file(arguments.csv, bench::to_csv(report));
    if (!arguments.html.empty()) bench::write_file(arguments.html, bench::to_html(report));
    if (!arguments.markdown.empty()) bench::write_file(arguments.markdown, bench::to_markdown(report));
    if (arguments.quiet) return;
    print_table(bench::headline_table(report));
    for (const auto& clip : report.clips)
        for (const auto& tables : {bench::geometry_tables(report, clip), bench::timing_tables(report, clip),
                                   bench::texture_tables(report, clip), bench::view_tables(report, clip)})
            for (const auto& table : tables)
                if (!table.details) print_table(table);
    for (const auto& [name, why] : report.absent) fmt::print("absent: {} ({})\n", name, why);
}

int run(const Arguments& arguments, const std::string& command) {
    const Progress progress = tools::progress_bar(arguments.quiet);
    bench::Report report;
    if (!arguments.json.empty()) {
        auto old = bench::read_json(arguments.json);
        if (old.ok()) report = std::move(*old);
        else if (old.error().code != ErrorCode::missing && !arguments.suite.force) return complain(old.error().message);
    }
    bench::drop_other_builds(report);
    report.version = bench::own_library();
    report.date = fmt::format("{:%Y-%m-%d %H:%M} UTC", fmt::gmtime(std::time(nullptr)));
    if (std::find(report.commands.begin(), report.commands.end(), command) == report.commands.end())
        report.commands.push_back(command);
    if (progress) progress("measuring the machine", 0, 0);
    report.machine = bench::measure_machine(arguments.smoke);
    const auto save = [&] {
        if (!arguments.json.empty()) bench::write_file(arguments.json, bench::to_json(report));
    };
    save();

    const auto measure = [&](const Clip& clip) {
        return bench::run_clip(arguments.frames > 0 ? bench::first_frames(clip, arguments.frames) : clip, arguments.suite, report,
                               save, progress);
    };
    for (const std::string& path : arguments.clips) {
        auto loaded = io::load_clip(path, {.frame_rate = {}, .unit = {}, .progress = progress});
        if (!loaded.ok()) return complain(loaded.error().message);
        if (const auto done = measure(loaded->clip); !done.ok()) return complain(done.error().message);
    }
    if (arguments.clips.empty())
        if (const auto done = measure(bench::sheet_clip()); !done.ok()) return complain(done.error().message);
    tools::end_progress();
    save();
    write_pages(arguments, report);
    return tell_failures(report) ? tools::kFailed : tools::kDone;
}

/// What the JSON of this run begins with; empty: it is read, not written.
std::string json_begin(const Arguments& arguments) {
    if (arguments.synthesis) return R"({"load_s":)";
    if (arguments.speed) return R"({"frames":)";
    if (!arguments.model.empty()) return R"({"base":)";
    return arguments.clips.empty() && !arguments.smoke ? std::string() : std::string(bench::kJsonBegin);
}

/// A word of --codecs or --texture-codecs that no codec begins with, said; empty: there is none.
std::string unknown_codec(const Arguments& arguments) {
    const bench::GeometryCodecs codecs = bench::geometry_codecs();
    std::vector<std::string> motion;
    for (const auto& codec : codecs.codecs) motion.push_back(codec->name);
    for (const auto& [name, why] : codecs.absent) motion.push_back(name);
    const auto unknown = [](const std::vector<std::string>& asked, const std::vector<std::string>& names, const char* option) -> std::string {
        for (const std::string& word : asked)
            if (std::none_of(names.begin(), names.end(), [&](const std::string& name) { return name.starts_with(word); }))
                return fmt::format("{}: this build has no codec '{}'; --list shows those there are", option, word);
        return {};
    };
    const std::string of_motion = unknown(arguments.suite.codecs, motion, "--codecs");
    return of_motion.empty() ? unknown(arguments.suite.texture_codecs, encoder::texture_codecs(), "--texture-codecs") : of_motion;
}

/// Nothing that was asked for may cost a clip, a stream or another program's file.
Result<void> guard_files(const Arguments& arguments) {
    std::vector<std::filesystem::path> inputs(arguments.clips.begin(), arguments.clips.end());
    inputs.insert(inputs.end(), {arguments.model, arguments.ict, arguments.take});
    std::vector<io::PlannedOutput> outputs = {{"--csv", arguments.csv, {}, std::string(bench::kCsvBegin)},
                                              {"--html", arguments.html, {}, "<!DOCTYPEhtml>"},
                                              {"--markdown", arguments.markdown, {}, "##"},
                                              {"--sheet", arguments.sheet, {".png", ".jpg", ".jpeg"}},
                                              {"--picture-row", arguments.picture_row, {".png", ".jpg", ".jpeg"}}};
    if (const std::string begin = json_begin(arguments); begin.empty()) inputs.push_back(arguments.json);
    else outputs.push_back({"--json", arguments.json, {}, begin});
    auto guarded = io::guard_outputs(inputs, outputs, arguments.suite.force);
    if (!guarded.ok() && guarded.error().code == ErrorCode::unavailable)
        return Error{guarded.error().code, guarded.error().message + "; name another file, or use --force"};
    return guarded;
}

int only_write_pages(const Arguments& arguments) {
    auto report = bench::read_json(arguments.json);
    if (!report.ok()) return complain(report.error().message);
    report->commands.insert(report->commands.begin(), arguments.made.begin(), arguments.made.end());
    write_pages(arguments, *report);
    return tools::kDone;
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app("mien-bench: bitrate, quality and speed beside real codecs");
    app.footer(
        "Finished rows stay in the JSON file and are not run again; rows of our own codecs are when their sources have changed.\n"
        "Exit code: 0 done, 1 something failed (said on standard error, and in the report), 2 wrong command line.");
    Arguments a;
    app.add_option(
        "clips", a.clips,
        "Clip folders, or anything else that `mien check` takes; none: only writes the pages of the report that is there");
    app.add_option("--json", a.json, "Report as JSON; read first, so that a stopped run goes on");
    app.add_option("--csv", a.csv, "Report as CSV");
    app.add_option("--html", a.html, "Report as one HTML page");
    app.add_option("--markdown", a.markdown, "Tables as Markdown");
    app.add_option("--made", a.made, "A command that made a clip of the report, for the pages of one that is there; may be given again")->allow_extra_args(false);
    app.add_flag("--force", a.suite.force, "Run rows again that are there already, and replace files that are no reports of this program");
    app.add_flag("--smoke", a.smoke, "Little of everything in a minute: 12 frames, of a clip of its own when none is named");
    app.add_flag("--quiet,-q", a.quiet, "No progress, no tables");
    app.add_flag("--list", a.list, "Show the codecs of this build, and stop");
    app.add_option("--motion", a.suite.motion, "vertices, markers, weights or auto")->capture_default_str();
    app.add_option("--codecs", a.suite.codecs, "Motion codecs whose names begin so, comma-separated")->delimiter(',');
    app.add_option("--rms", a.suite.rms, "RMS errors to ask for, mm (weights: weight units), comma-separated")
        ->delimiter(',')
        ->check(CLI::PositiveNumber);
    app.add_option("--texture-codecs", a.suite.texture_codecs, "Of mpeg4, h264, hevc, av1, comma-separated")->delimiter(',');
    app.add_option("--texture-kbps", a.suite.texture_kbps, "Texture rates to ask for, comma-separated")
        ->delimiter(',')
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    app.add_option("--frames", a.frames, "Only the first frames of every clip")->check(CLI::PositiveNumber);
    app.add_option("--view-frames", a.suite.view_pictures, "Frames that are drawn, from three cameras each")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    app.add_option("--timing-rounds", a.suite.timing_rounds, "Passes over the clip for timing")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    auto* model = app.add_option("--model", a.model, "Instead: draw the layers of this model of mien train beside the scans of the clip")->check(CLI::ExistingFile)->group("A trained model");
    app.add_option("--sheet", a.sheet, "Picture of the frame that moves most, all layers side by side")->needs(model)->group("A trained model");
    app.add_flag("--synthesis", a.synthesis, "Without a clip: time a frame of the model on one core, beside reading its coefficients")->needs(model)->group("A trained model");
    app.add_option("--high-pass", a.high_pass, "As given to mien train, mm")->needs(model)->capture_default_str()->group("A trained model");
    auto* speed = app.add_flag("--motion-speed", a.speed,
                               "Instead: time training on the clip, coding frames with a known basis on one thread, and reading binary decisions")->group("Speed of the motion codec");
    app.add_option("--known", a.known, "Frames coded with the known basis")->needs(speed)->capture_default_str()->check(CLI::PositiveNumber)->group("Speed of the motion codec");
    app.add_option("--preset", a.preset, "Of the training: live or file")->needs(speed)->capture_default_str()->check(CLI::IsMember({"live", "file"}))->group("Speed of the motion codec");
    app.add_flag("--no-motion", a.no_geometry, "Leave out motion");
    app.add_flag("--no-timing", a.no_timing, "Leave out timing");
    app.add_flag("--no-texture", a.no_texture, "Leave out texture and views");
    app.add_flag("--no-views", a.no_views, "Leave out drawn views");
    auto* picture = app.add_option("--picture-row", a.picture_row,
                                   "Write one frame of the first clip, true and by each texture codec at the first texture rate, as a "
                                   ".png or .jpg, and stop");
    app.add_option("--picture-frame", a.picture_frame, "Its number")->needs(picture)->check(CLI::NonNegativeNumber);
    auto* write =
        app.add_option("--write", a.write, "Write the clip of --ict as a clip folder, and stop")->group("Making the ICT clip");
    auto* ict = app.add_option("--ict", a.ict, "ICT-FaceKit folder")->needs(write)->group("Making the ICT clip");
    auto* take = app.add_option("--take", a.take, "Live Link Face CSV that drives it")->needs(ict)->group("Making the ICT clip");
    write->needs(take);
    app.add_option("--first", a.first, "First row of the take")->capture_default_str()->group("Making the ICT clip");
    app.add_option("--count", a.count, "Rows of the take")
        ->capture_default_str()
        ->check(CLI::PositiveNumber)
        ->group("Making the ICT clip");
    app.add_option("--vertices", a.vertices, "Vertices from the first")
        ->capture_default_str()
        ->check(CLI::PositiveNumber)
        ->group("Making the ICT clip");
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? tools::kDone : tools::kMisused;
    }
    try {
        if (a.list) return list_codecs();
        const bool no_clip = a.clips.empty() && !a.smoke && !a.synthesis && a.write.empty();
        if (no_clip && (a.json.empty() || a.speed)) {
            fmt::print(stderr, "mien-bench: name a clip folder, a report to show (--json), or --smoke; --help says more\n");
            return tools::kMisused;
        }
        if (const std::string unknown = unknown_codec(a); !unknown.empty()) return complain(unknown), tools::kMisused;
        if (const auto guarded = guard_files(a); !guarded.ok())
            return complain(guarded.error().message), guarded.error().code == ErrorCode::invalid ? tools::kMisused : tools::kFailed;
        if (!a.write.empty()) return write_ict(a);
        if (a.synthesis) return time_model(a);
        if (no_clip) return only_write_pages(a);
        if (a.speed && !a.clips.empty()) return time_codec(a);
        if (!a.model.empty()) return views_of_model(a);

        if (!a.picture_row.empty()) {
            if (!a.clips.empty()) return write_picture_row(a);
            fmt::print(stderr, "mien-bench: --picture-row needs a clip folder\n");
            return tools::kMisused;
        }
        a.suite.geometry = !a.no_geometry;
        a.suite.timing = !a.no_timing;
        a.suite.texture = !a.no_texture;
        a.suite.views = !a.no_views;
        if (a.smoke) {
            if (a.frames == 0) a.frames = 12;
            if (a.suite.rms.empty()) a.suite.rms = {0.2, 0.1};
            if (app.count("--texture-kbps") == 0) a.suite.texture_kbps = {60, 200};
            a.suite.timing_rounds = 1;
            a.suite.view_pictures = 2;
        }
        return run(a, command_line(argc, argv));
    } catch (const std::bad_alloc&) {
        return complain("not enough memory; --frames makes a clip shorter");
    } catch (const std::exception& error) {  // EnvironmentError and what libraries throw
        return complain(error.what());
    }
}
