#include "analysis/model_evaluation.hpp"

#include <cmath>

#include "analysis/texture_triangulation.hpp"
#include "core/parallel.hpp"

namespace mien::analysis {
namespace {

constexpr std::uint32_t kSkin = 1u << int(Surface::skin);

/// Errors of one layer of one frame: what the target has beyond `values`; values empty: all of it.
void compare(const std::vector<float>& target, const std::vector<float>& values, std::size_t texels, bool distance, ErrorSummary& into) {
    const std::size_t channels = target.size() / std::max<std::size_t>(1, texels);
    for (std::size_t i = 0; i < texels; ++i) {
        double squares = 0, sum = 0;
        for (std::size_t c = 0; c < channels; ++c) {
            const double error = double(target[c * texels + i]) - (values.empty() ? 0.0 : double(values[c * texels + i]));
            squares += error * error;
            sum += std::abs(error);
        }
        if (!std::isfinite(squares)) continue;   // not seen
        into.add(distance ? std::sqrt(squares) : sum / double(channels));
    }
}

struct FrameErrors {
    ErrorSummary none[3], still[3], model[3];
    std::optional<Error> error;
};

class ModelJudge {
public:
    ModelJudge(const model::FaceModel& face, const Clip& clip, double high_pass_mm)
        : face_(face), clip_(clip), shell_(std::get<model::ShellBase>(face.base)), detail_(*face.detail), model_(detail_.model()),
          markers_(model::make_marker_mesh(face.neutral, shell_.sites, triangulate_over_texture(face.neutral, shell_.sites))),
          medium_where_(where(model_.medium_domain)),
          fine_target_(model_, high_pass_mm / texel_span(model_.neutral, model_.fine_domain, where(model_.fine_domain)), FineOver::scan), still_(detail_.parameters(model_.neutral.positions)) {
        markers_.neutral = shell_.markers;
        rest_ = shell_.markers;
        if (clip.neutral && clip.marker_sites.size() == shell_.sites.size())
            for (std::size_t m = 0; m < clip.marker_sites.size(); ++m) rest_.row(Eigen::Index(m)) = clip.marker_sites[m].position(clip.neutral->positions).transpose();
    }

    bool has(int layer) const {
        const model::PolynomialMap* maps[] = {&model_.medium, &model_.fine, &model_.albedo};
        return maps[layer]->texels > 0 && (layer < 2 || clip_.scans->has_albedo());
    }

    FrameErrors judge(std::int64_t frame) const {
        FrameErrors out;
        const auto scan = clip_.scans->read(frame, {true, true, has(2)});
        if (!scan.ok()) {
            out.error = scan.error();
            return out;
        }
        Points markers = head_space_markers(clip_, frame, rest_) - rest_ + shell_.markers;
        if (!model::fill_missing_markers(markers_, markers)) markers = shell_.markers;
        Points base = face_.neutral.positions;
        base.noalias() += shell_.response * (markers - shell_.markers);
        const model::DomainParameters parameters = detail_.parameters(base);

        std::vector<float> target(3 * model_.medium_domain.size()), values, medium = evaluated(model_.medium, model_.medium_domain, parameters);
        if (has(0)) {
            medium_target(scan->medium, model_.neutral, model_.medium_domain, medium_where_, base, target.data());
            compare_all(0, target, medium, model_.medium, model_.medium_domain, out);
        }
        if (has(1)) {
            target.resize(model_.fine_domain.size());
            fine_target_.compute(*scan, base, medium.data(), target.data());
            values = evaluated(model_.fine, model_.fine_domain, parameters);
            compare_all(1, target, values, model_.fine, model_.fine_domain, out);
        }
        if (has(2)) {
            const std::size_t n = model_.fine_domain.size();
            target.resize(3 * n);
            for (std::size_t k = 0; k < n; ++k)
                for (std::size_t c = 0; c < 3; ++c) target[c * n + k] = scan->albedo.values[3 * std::size_t(model_.fine_domain.place[k]) + c];
            values = evaluated(model_.albedo, model_.fine_domain, parameters);
            compare_all(2, target, values, model_.albedo, model_.fine_domain, out);
        }
        return out;
    }

private:
    std::vector<TexelMap::Texel> where(const model::DomainMap& domain) const {
        return domain_texels(domain, make_texel_map(model_.neutral, domain.width, domain.height, kSkin));
    }
    static std::vector<float> evaluated(const model::PolynomialMap& map, const model::DomainMap& domain, const model::DomainParameters& parameters) {
        std::vector<float> values(std::size_t(map.channels) * domain.size());
        if (map.texels > 0) model::evaluate(map, domain, parameters, values.data());
        return values;
    }
    void compare_all(int layer, const std::vector<float>& target, const std::vector<float>& values, const model::PolynomialMap& map,
                     const model::DomainMap& domain, FrameErrors& out) const {
        compare(target, {}, domain.size(), layer < 2, out.none[layer]);
        compare(target, evaluated(map, domain, still_), domain.size(), layer < 2, out.still[layer]);
        compare(target, values, domain.size(), layer < 2, out.model[layer]);
    }

    const model::FaceModel& face_;
    const Clip& clip_;
    const model::ShellBase& shell_;
    const model::DetailLayers& detail_;
    const model::DetailModel& model_;
    model::MarkerMesh markers_;                       // over the driving markers
    std::vector<TexelMap::Texel> medium_where_;
    FineTarget fine_target_;
    model::DomainParameters still_;
    Points rest_;                                     // the clip's markers at rest
};

}  // namespace

Result<ModelEvaluation> evaluate_model(const model::FaceModel& face, const Clip& clip, std::int64_t stride, double high_pass_mm, const Progress& progress) {
    const auto missing = [](const char* what) { return Error{ErrorCode::missing, std::string("measuring a model needs ") + what}; };
    const auto* shell = std::get_if<model::ShellBase>(&face.base);
    if (!shell || !face.detail) return missing("a model of mien train");
    if (!clip.markers) return missing("a clip with markers");
    if (!clip.scans) return missing("a clip with scans (positions_medium and positions_fine)");
    if (clip.markers->points != shell->markers.rows())
        return Error{ErrorCode::mismatch, "the model has " + std::to_string(shell->markers.rows()) + " markers, but the clip has " +
                                              std::to_string(clip.markers->points) + "; mien remap gives a model other markers"};
    const model::DetailModel& detail = face.detail->model();
    if ((detail.medium.texels > 0 && detail.medium_domain.width != clip.scans->medium_size()) || (detail.fine.texels > 0 && detail.fine_domain.width != clip.scans->fine_size()))
        return Error{ErrorCode::mismatch, "the scans have another size than the model's maps"};
    if (clip.scans->frames() < clip.markers->frames) return missing("a scan of every frame");

    const ModelJudge judge(face, clip, high_pass_mm);
    ModelEvaluation out;
    FrameErrors sum;
    std::vector<std::int64_t> frames;
    for (std::int64_t f = 0; f < clip.markers->frames; f += stride) frames.push_back(f);
    const auto at_once = std::size_t(thread_count());
    for (std::size_t first = 0; first < frames.size(); first += at_once) {
        std::vector<FrameErrors> batch(std::min(at_once, frames.size() - first));
        parallel_for(std::int64_t(batch.size()), [&](std::int64_t i) { batch[std::size_t(i)] = judge.judge(frames[first + std::size_t(i)]); });
        for (const FrameErrors& one : batch) {
            if (one.error) return *one.error;
            for (int layer = 0; layer < 3; ++layer) {
                sum.none[layer].merge(one.none[layer]);
                sum.still[layer].merge(one.still[layer]);
                sum.model[layer].merge(one.model[layer]);
            }
            ++out.frames;
        }
        if (progress) progress("measuring", std::int64_t(first + batch.size()), std::int64_t(frames.size()));
    }
    const char* names[] = {"medium", "fine", "albedo"};
    for (int layer = 0; layer < 3; ++layer)
        if (judge.has(layer)) out.layers.push_back({names[layer], sum.none[layer], sum.still[layer], sum.model[layer]});
    return out;
}

}  // namespace mien::analysis
