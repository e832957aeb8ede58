#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "analysis/model_evaluation.hpp"
#include "core/parallel.hpp"
#include "io/clip_folder.hpp"
#include "tools/commands.hpp"
#include "tools/console.hpp"
#include "tools/model_file.hpp"
#include "tools/options.hpp"

namespace mien::tools {
namespace {

using nlohmann::ordered_json;

struct Request {
    std::string model, clip;
    std::int64_t every = 1;
    double high_pass = 4;
    int threads = 0;
    bool json = false;
};

ordered_json to_json(const analysis::ErrorSummary& errors) {
    return {{"mean", errors.mean()}, {"p99", errors.percentile(0.99)}, {"max", errors.maximum()}};
}

Result<int> evaluate(const Request& request) {
    set_thread_count(request.threads);
    const Progress progress = progress_bar(request.json);
    MIEN_TRY(model, read_model(request.model));
    MIEN_TRY(loaded, io::load_clip(request.clip, {.frame_rate = {}, .unit = {}, .progress = progress}));
    MIEN_TRY(pair, analysis::ModelOnClip::create(model.model, loaded.clip, request.high_pass));
    MIEN_TRY(measured, analysis::evaluate_model(pair, loaded.clip.markers->frames, request.every, progress));
    end_progress();
    if (request.json) {
        ordered_json out{{"frames", measured.frames}, {"layers", ordered_json::object()}};
        for (const auto& layer : measured.layers)
            out["layers"][layer.name] = {{"unit", layer.name == "albedo" ? "linear" : "mm"}, {"none", to_json(layer.none)}, {"still", to_json(layer.still)}, {"model", to_json(layer.model)}};
        fmt::print("{}\n", out.dump(2));
        return kDone;
    }
    fmt::print("{} frames; mean, 99 % and largest error without the layer, with it held still, and moved by the markers\n", measured.frames);
    for (const auto& layer : measured.layers) {
        const auto three = [](const analysis::ErrorSummary& e) { return fmt::format("{:.5f} {:.4f} {:.4f}", e.mean(), e.percentile(0.99), e.maximum()); };
        fmt::print("  {:<7} {}  |  {}  |  {}  ({:+.1f} % of still)\n", layer.name, three(layer.none), three(layer.still), three(layer.model),
                   layer.still.mean() > 0 ? 100 * (layer.model.mean() / layer.still.mean() - 1) : 0.0);
    }
    return kDone;
}

}  // namespace

void add_evaluate(CLI::App& mien, int& code) {
    auto request = std::make_shared<Request>();
    CLI::App* command = mien.add_subcommand("evaluate", "Measure what a trained model leaves of the scans of a clip");
    command->add_option("model", request->model, "Model file of mien train or mien remap")->required()->check(CLI::ExistingFile);
    command->add_option("clip", request->clip, "Clip folder with scans and the model's markers")->required();
    command->add_option("--every", request->every, "Measure only every N-th frame")->check(above_zero())->capture_default_str();
    command->add_option("--high-pass", request->high_pass, "As given to mien train, mm")->check(above_zero())->capture_default_str();
    add_threads(*command, request->threads);
    command->add_flag("--json", request->json, "As JSON");
    command->callback([request, &code] { code = guarded([&] { return evaluate(*request); }, request->json); });
}

}  // namespace mien::tools
