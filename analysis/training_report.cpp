#include "analysis/training_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace mien::analysis {
namespace {

using Json = nlohmann::ordered_json;

struct Layer {
    const char* name;
    const char* unit;
    const std::vector<LayerErrors>& ways;
};
std::vector<Layer> layers(const Evaluation& evaluation) {
    std::vector<Layer> all{{"medium", "mm", evaluation.medium}, {"fine", "mm", evaluation.fine}};
    if (!evaluation.albedo.empty()) all.push_back({"albedo", "linear, 0 to 1", evaluation.albedo});
    return all;
}

struct NamedRidge {
    const char* name;
    const Ridge& ridge;
};
std::vector<NamedRidge> ridges(const TrainedModel& trained) {
    std::vector<NamedRidge> all{{"medium", trained.medium_ridge}, {"fine", trained.fine_ridge}};
    if (trained.model.albedo.texels > 0) all.push_back({"albedo", trained.albedo_ridge});
    return all;
}

/// From black over red and yellow to white.
void glow(double share, std::uint8_t* rgb) {
    for (int c = 0; c < 3; ++c) rgb[c] = std::uint8_t(std::lround(255 * std::clamp(3 * share - c, 0.0, 1.0)));
}

}  // namespace

std::string report_markdown(const TrainedModel& trained, const std::vector<ClipEvaluation>& clips) {
    std::string s = fmt::format("# A face's detail, learnt from {} frames\n\n", trained.frames);
    s += fmt::format("{} markers, {} marker triangles; medium map {}², {} texels; fine map {}², {} texels.\n\n", trained.model.sites.size(),
                     trained.model.marker_triangles.size(), trained.model.medium_domain.width, trained.model.medium_domain.size(),
                     trained.model.fine_domain.width, trained.model.fine_domain.size());
    s += "Energy of S that the first axes hold, mean over the markers:\n\n| axes | 1 | 2 | 3 | 4 | 5 |\n| --- | ---: | ---: | ---: | ---: | ---: |\n| % |";
    for (const double energy : trained.axis_energy) s += fmt::format(" {:.1f} |", 100 * energy);
    s += "\n\n| ridge, per frame | linear | quadratic | cubic |\n| --- | ---: | ---: | ---: |\n";
    for (const auto& [name, ridge] : ridges(trained)) s += fmt::format("| {} | {:.3g} | {:.3g} | {:.3g} |\n", name, ridge.linear, ridge.quadratic, ridge.cubic);
    for (const ClipEvaluation& clip : clips) {
        s += fmt::format("\n## {}: {} frames\n", clip.name, clip.evaluation.frames);
        for (const Layer& layer : layers(clip.evaluation)) {
            s += fmt::format("\n| {} ({}) | mean | 99 % | maximum |\n| --- | ---: | ---: | ---: |\n", layer.name, layer.unit);
            for (const LayerErrors& way : layer.ways)
                s += fmt::format("| {} | {:.5f} | {:.4f} | {:.3f} |\n", way.name, way.errors.mean(), way.errors.percentile(0.99), way.errors.maximum());
        }
    }
    return s;
}

std::string report_json(const TrainedModel& trained, const std::vector<ClipEvaluation>& clips) {
    Json j;
    j["frames"] = trained.frames;
    j["markers"] = trained.model.sites.size();
    j["medium_texels"] = trained.model.medium_domain.size();
    j["fine_texels"] = trained.model.fine_domain.size();
    j["axis_energy"] = trained.axis_energy;
    for (const auto& [name, ridge] : ridges(trained)) j["ridge"][name] = {{"linear", ridge.linear}, {"quadratic", ridge.quadratic}, {"cubic", ridge.cubic}};
    j["clips"] = Json::array();
    for (const ClipEvaluation& clip : clips) {
        Json entry{{"name", clip.name}, {"frames", clip.evaluation.frames}};
        for (const Layer& layer : layers(clip.evaluation))
            for (const LayerErrors& way : layer.ways)
                entry[layer.name][way.name] = {{"mean", way.errors.mean()}, {"p99", way.errors.percentile(0.99)}, {"max", way.errors.maximum()}};
        j["clips"].push_back(std::move(entry));
    }
    return j.dump(1, ' ', false, Json::error_handler_t::replace);
}

Image error_picture(const model::DomainMap& domain, const std::vector<LayerErrors>& layer, double most) {
    Image picture(domain.width * int(layer.size()), domain.height, 3);
    for (std::size_t i = 0; i < picture.pixels.size(); i += 3) {
        picture.pixels[i] = 40;
        picture.pixels[i + 1] = 46;
        picture.pixels[i + 2] = 56;
    }
    for (std::size_t w = 0; w < layer.size(); ++w)
        for (std::size_t i = 0; i < domain.size(); ++i)
            if (std::isfinite(layer[w].mean[i]))
                glow(layer[w].mean[i] / most, picture.at(int(w) * domain.width + int(domain.place[i]) % domain.width, int(domain.place[i]) / domain.width));
    return picture;
}

}  // namespace mien::analysis
