#include <fmt/core.h>

#include <algorithm>
#include <filesystem>

#include "analysis/training_report.hpp"
#include "core/environment_error.hpp"
#include "core/parallel.hpp"
#include "encoder/detail_encoder.hpp"
#include "encoder/mesh_blobs.hpp"
#include "encoder/still_picture.hpp"
#include "io/clip_folder.hpp"
#include "io/file.hpp"
#include "io/image_file.hpp"
#include "tools/byte_split.hpp"
#include "tools/commands.hpp"
#include "tools/console.hpp"
#include "tools/options.hpp"

namespace mien::tools {
namespace {

namespace fs = std::filesystem;

struct Request {
    std::string clip, output, order = "biquadratic", axes = "telling", report;
    std::vector<std::string> on;
    std::vector<double> ridge, coding_errors;
    double reach = 30, high_pass = 4, most_kilobytes = 0;
    std::int64_t every = 1;
    int threads = 0;
    bool paper = false, overwrite = false, quiet = false;
};

analysis::TrainingOptions training_options(const Request& request, const Clip& clip) {
    analysis::TrainingOptions options;
    options.order = request.order == "linear" ? model::PolynomialOrder::linear : request.order == "bicubic" ? model::PolynomialOrder::bicubic : model::PolynomialOrder::biquadratic;
    options.axes.choice = request.axes == "telling" ? analysis::AxisChoice::telling : analysis::AxisChoice::principal;
    if (clip.vertices) options.fixed = clip.rigid;
    options.reach_mm = request.reach;
    options.high_pass_mm = request.high_pass;
    options.rivals = !request.report.empty();
    if (request.paper) {
        options.axes.smoothing = analysis::AxisSmoothing::paper;
        options.bounded = false;
        options.axes.choice = analysis::AxisChoice::principal;
        options.fine_over = analysis::FineOver::model;
        options.ridge = analysis::Ridge{1e-6, 1e-6, 1e-6, false};
        options.medium_rounds = options.rounds = 0;
    }
    if (!request.ridge.empty()) {
        if (!options.ridge) options.ridge.emplace();
        options.ridge->linear = request.ridge[0];
        options.ridge->quadratic = request.ridge[std::min<std::size_t>(1, request.ridge.size() - 1)];
        options.ridge->cubic = request.ridge[std::min<std::size_t>(2, request.ridge.size() - 1)];
    }
    return options;
}

/// Measures the training clip and those of --on, and writes the page, the figures and the error maps.
Result<void> write_report(const Request& request, const analysis::TrainedModel& trained, const Clip& training, const Progress& progress) {
    const fs::path folder = request.report;
    std::vector<analysis::ClipEvaluation> clips;
    const auto measure = [&](const Clip& clip) -> Result<void> {
        MIEN_TRY(evaluation, analysis::evaluate_clip(trained, clip, request.every, progress));
        clips.push_back({clip.name, std::move(evaluation)});
        return {};
    };
    MIEN_CHECK(measure(training));
    for (const std::string& path : request.on) {
        MIEN_TRY(loaded, io::load_clip(path));
        const Clip& clip = loaded.clip;
        if (!clip.scans || !clip.markers || clip.markers->points != std::int64_t(trained.model.sites.size()))
            return Error{ErrorCode::mismatch, fmt::format("{} cannot be measured: it needs scans and the model's {} markers", path, trained.model.sites.size())};
        MIEN_CHECK(measure(clip));
    }
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) throw EnvironmentError(fmt::format("cannot make the folder {}: {}", folder.string(), error.message()));
    std::string page = report_markdown(trained, clips);
    const auto picture = [&](const analysis::ClipEvaluation& clip, const char* name, const model::DomainMap& domain, const std::vector<analysis::LayerErrors>& layer) {
        if (layer.empty()) return;
        double most = 0;  // so that the worst of the fitted ways still shows where it is worst
        std::string names;
        for (const analysis::LayerErrors& way : layer) {
            if (way.name != "base") most = std::max(most, way.errors.percentile(0.99));
            names += (names.empty() ? "" : ", ") + way.name;
        }
        const std::string file = fmt::format("{}-{}.png", clip.name, name);
        io::write_image(folder / file, error_picture(domain, layer, most));
        page += fmt::format("\n![{0}]({0})\n\n{1}, {2}: mean error of {3}, left to right; white is {4:.3g} and more.\n", file, clip.name, name, names, most);
    };
    for (const analysis::ClipEvaluation& clip : clips) {
        picture(clip, "medium", trained.model.medium_domain, clip.evaluation.medium);
        picture(clip, "fine", trained.model.fine_domain, clip.evaluation.fine);
        picture(clip, "albedo", trained.model.fine_domain, clip.evaluation.albedo);
    }
    io::write_file(folder / "report.md", page);
    io::write_file(folder / "report.json", report_json(trained, clips));
    return {};
}

Result<int> train(const Request& request) {
    if (!request.on.empty() && request.report.empty()) return misused("--on measures for a report; say where with --report DIR");
    const fs::path output = request.output;
    MIEN_CHECK(may_write(output, request.overwrite, {request.clip}));
    set_thread_count(request.threads);
    const Progress progress = progress_bar(request.quiet);
    io::LoadOptions load;
    load.progress = progress;
    MIEN_TRY(loaded, io::load_clip(request.clip, load));
    for (const std::string& text : loaded.warnings) warn(text);
    const Clip& clip = loaded.clip;
    // Before the long work: is there a place to write to?
    io::OutputFile file(output, request.overwrite);
    encoder::DetailOptions coding;
    analysis::TrainingOptions options = training_options(request, clip);
    options.progress = progress;
    if (clip.neutral) {
        MIEN_TRY(neutral, encoder::mesh_as_stored(*clip.neutral, coding.mesh_step));
        options.neutral = std::move(neutral);
    }
    MIEN_TRY(trained, analysis::train(clip, options));
    if (!request.report.empty()) MIEN_CHECK(write_report(request, trained, clip, progress));
    if (request.coding_errors.empty()) {
        coding = encoder::detail_options(trained.fine_stored);
    } else {
        coding.medium = request.coding_errors[0];
        coding.fine = request.coding_errors[1];
        coding.albedo = request.coding_errors[2];
    }
    coding.progress = progress;
    coding.most_bytes = std::size_t(request.most_kilobytes * 1000);
    coding.name = output.stem().string();
    std::optional<Image> picture;
    if (clip.texture) {
        MIEN_TRY(still, encoder::still_picture(clip, progress));
        picture = std::move(still);
        coding.picture = &*picture;
    }
    MIEN_TRY(coded, encoder::encode_detail(trained.model, trained.moments, clip.name, coding));
    const Bytes bytes = encoder::model_file(coded.manifest, coded.blobs, coding.name);
    file.write(ByteView(bytes));
    file.commit_to_disk();
    end_progress();
    if (!request.quiet) {
        fmt::print("{}: {} from {} frames\n", request.output, human_bytes(bytes.size()), trained.frames);
        MIEN_TRY(stream, StoredStream::from_bytes(std::make_shared<Bytes>(bytes)));
        MIEN_TRY(layers, split_model(stream));
        for (const LayerBytes& layer : layers) {
            const auto map = std::find_if(coded.layers.begin(), coded.layers.end(), [&](const auto& each) { return each.name == layer.name; });
            const std::string added = map == coded.layers.end() ? "" : fmt::format(", coding added {:.2g} {} RMS", map->error, map->name == "albedo" ? "of linear albedo" : "mm");
            fmt::print("  {:<14} {:>9}{}\n", layer.name, human_bytes(layer.bytes), added);
        }
    }
    return kDone;
}

}  // namespace

void add_train(CLI::App& mien, int& code) {
    auto request = std::make_shared<Request>();
    CLI::App* command = mien.add_subcommand("train", "Learn a face's wrinkles, pores and skin colour from scans and markers");
    command->add_option("clip", request->clip, "Clip folder with markers, marker_sites, positions_medium, positions_fine and (optional) albedo")->required();
    command->add_option("-o,--output", request->output, "Model file to write, usually ACTOR.model")->required();
    command->add_flag("-y,--overwrite", request->overwrite, "Overwrite the output file");
    command->add_option("--order", request->order, "Polynomials: linear, biquadratic or bicubic")->check(CLI::IsMember({"linear", "biquadratic", "bicubic"}))->capture_default_str();
    CLI::Option* axes = command->add_option("--axes", request->axes, "Along which two axes deformation counts at a marker: principal (those it moves along most) or telling (those that the layers around it follow best)")
        ->check(CLI::IsMember({"principal", "telling"}))->capture_default_str();
    command->add_option("--ridge", request->ridge, "Strengths for linear, quadratic and cubic terms, per frame (default: found by leaving out parts of takes)")
        ->delimiter(',')->expected(1, 3)->check(not_negative());
    command->add_flag("--paper", request->paper, "Every step as Ma et al. 2008 have it")->excludes(axes);
    command->add_option("--reach", request->reach, "Skin farther from every marker than this has no detail, mm")->check(above_zero())->capture_default_str();
    command->add_option("--high-pass", request->high_pass, "Width of what the medium layer is left to carry, mm")->check(above_zero())->capture_default_str();
    command->add_option("--kbytes", request->most_kilobytes, "Largest size of the model file, kB: its error grows until it fits")->check(above_zero());
    command->add_option("--coding-error", request->coding_errors, "RMS that storing may add to the medium layer (mm), the fine one (mm) and albedo (linear, 0 to 1) (default: 0.02, a tenth of the fit's own error but at most 0.002, 0.00055; within 200 kB of medium and fine layer and 800 kB of all)")
        ->delimiter(',')->expected(3)->check(above_zero());
    command->add_option("--report", request->report, "Folder for figures, tables and error maps; also fits and measures other orders and two rivals");
    command->add_option("--on", request->on, "Clips with scans that were not trained on, for the report")->check(CLI::ExistingPath);
    command->add_option("--every", request->every, "Measure only every N-th frame")->check(above_zero())->capture_default_str();
    add_threads(*command, request->threads);
    command->add_flag("-q,--quiet", request->quiet, "No progress, no summary");
    command->callback([request, &code] { code = guarded([&] { return train(*request); }); });
}

}  // namespace mien::tools
