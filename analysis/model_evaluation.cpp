#include "analysis/model_evaluation.hpp"

#include <cmath>

#include "analysis/texture_triangulation.hpp"
#include "core/parallel.hpp"

namespace mien::analysis {
namespace {

constexpr std::uint32_t kSkin = 1u << int(Surface::skin);

std::vector<TexelMap::Texel> texels_of(const Mesh& neutral, const model::DomainMap& domain) {
    return domain_texels(domain, make_texel_map(neutral, domain.width, domain.height, kSkin));
}

std::vector<float> evaluated(const model::PolynomialMap& map, const model::DomainMap& domain, const model::DomainParameters& parameters) {
    std::vector<float> values(std::size_t(map.channels) * domain.size());
    if (map.texels > 0) model::evaluate(map, domain, parameters, values.data());
    return values;
}

/// What `truth` has beyond `values`; values empty: all of it.
void compare(const std::vector<float>& truth, const std::vector<float>& values, std::size_t texels, bool distance, ErrorSummary& into) {
    const std::size_t channels = texels > 0 ? truth.size() / texels : 0;
    for (std::size_t i = 0; i < texels && channels > 0; ++i) {
        double squares = 0, sum = 0;
        for (std::size_t c = 0; c < channels; ++c) {
            const double error = double(truth[c * texels + i]) - (values.empty() ? 0.0 : double(values[c * texels + i]));
            squares += error * error;
            sum += std::abs(error);
        }
        if (std::isfinite(squares)) into.add(distance ? std::sqrt(squares) : sum / double(channels));
    }
}

}  // namespace

struct ModelOnClip::State {
    State(const model::FaceModel& face_, const Clip& clip_, double high_pass_mm)
        : face(face_), clip(clip_), shell(std::get<model::ShellBase>(face.base)), detail(*face.detail), model(detail.model()),
          markers(model::make_marker_mesh(face.neutral, shell.sites, triangulate_over_texture(face.neutral, shell.sites))),
          medium_where(texels_of(model.neutral, model.medium_domain)),
          fine_target(model, high_pass_mm / texel_span(model.neutral, model.fine_domain, texels_of(model.neutral, model.fine_domain)), FineOver::scan),
          still(detail.parameters(model.neutral.positions)) {
        markers.neutral = shell.markers;
        rest = markers_at_rest(clip, shell.markers);
    }

    const model::FaceModel& face;
    const Clip& clip;
    const model::ShellBase& shell;
    const model::DetailLayers& detail;
    const model::DetailModel& model;
    model::MarkerMesh markers;                       // over the driving markers
    std::vector<TexelMap::Texel> medium_where;
    FineTarget fine_target;
    model::DomainParameters still;
    Points rest;                                     // the clip's markers at rest
};

ModelOnClip::ModelOnClip(std::unique_ptr<const State> state) : state_(std::move(state)) {}
ModelOnClip::ModelOnClip(ModelOnClip&&) noexcept = default;
ModelOnClip::~ModelOnClip() = default;

Result<ModelOnClip> ModelOnClip::create(const model::FaceModel& face, const Clip& clip, double high_pass_mm) {
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
    return ModelOnClip(std::make_unique<const State>(face, clip, high_pass_mm));
}

bool ModelOnClip::has(int layer) const {
    const model::PolynomialMap* maps[] = {&state_->model.medium, &state_->model.fine, &state_->model.albedo};
    return maps[layer]->texels > 0 && (layer < 2 || state_->clip.scans->has_albedo());
}

const model::DomainMap& ModelOnClip::domain(int layer) const { return layer == 0 ? state_->model.medium_domain : state_->model.fine_domain; }

Result<ModelFrame> ModelOnClip::frame(std::int64_t frame) const {
    const State& s = *state_;
    MIEN_TRY(scan, s.clip.scans->read(frame, {true, true, has(2)}));
    Points markers = head_space_markers(s.clip, frame, s.rest, s.shell.markers);
    if (!model::fill_missing_markers(s.markers, markers)) markers = s.shell.markers;
    ModelFrame out;
    out.base = s.face.neutral.positions;
    out.base.noalias() += s.shell.response * (markers - s.shell.markers);
    const model::DomainParameters parameters = s.detail.parameters(out.base);
    const model::PolynomialMap* maps[] = {&s.model.medium, &s.model.fine, &s.model.albedo};
    for (int layer = 0; layer < 3; ++layer) {
        if (!has(layer)) continue;
        LayerValues& values = out.layers[layer];
        values.still = evaluated(*maps[layer], domain(layer), s.still);
        values.model = evaluated(*maps[layer], domain(layer), parameters);
        values.truth.resize(values.model.size());
    }
    if (has(0)) medium_target(scan.medium, s.model.neutral, s.model.medium_domain, s.medium_where, out.base, out.layers[0].truth.data());
    const std::vector<float> no_medium(3 * s.model.medium_domain.size(), 0.0f);
    if (has(1)) s.fine_target.compute(scan, out.base, has(0) ? out.layers[0].model.data() : no_medium.data(), out.layers[1].truth.data());
    if (has(2)) {
        const std::size_t n = s.model.fine_domain.size();
        for (std::size_t k = 0; k < n; ++k)
            for (std::size_t c = 0; c < 3; ++c) out.layers[2].truth[c * n + k] = scan.albedo.values[3 * std::size_t(s.model.fine_domain.place[k]) + c];
    }
    return out;
}

Result<ModelEvaluation> evaluate_model(const ModelOnClip& pair, std::int64_t frames, std::int64_t stride, const Progress& progress) {
    struct FrameErrors {
        ErrorSummary none[3], still[3], model[3];
        std::optional<Error> error;
    };
    std::vector<std::int64_t> chosen;
    for (std::int64_t f = 0; f < frames; f += stride) chosen.push_back(f);
    const auto at_once = std::size_t(thread_count());
    FrameErrors sum;
    for (std::size_t first = 0; first < chosen.size(); first += at_once) {
        std::vector<FrameErrors> batch(std::min(at_once, chosen.size() - first));
        parallel_for(std::int64_t(batch.size()), [&](std::int64_t i) {
            FrameErrors& errors = batch[std::size_t(i)];
            const auto frame = pair.frame(chosen[first + std::size_t(i)]);
            if (!frame.ok()) {
                errors.error = frame.error();
                return;
            }
            for (int layer = 0; layer < 3; ++layer) {
                if (!pair.has(layer)) continue;
                const LayerValues& values = frame->layers[layer];
                const std::size_t texels = pair.domain(layer).size();
                compare(values.truth, {}, texels, layer < 2, errors.none[layer]);
                compare(values.truth, values.still, texels, layer < 2, errors.still[layer]);
                compare(values.truth, values.model, texels, layer < 2, errors.model[layer]);
            }
        });
        for (const FrameErrors& one : batch) {
            if (one.error) return *one.error;
            for (int layer = 0; layer < 3; ++layer) {
                sum.none[layer].merge(one.none[layer]);
                sum.still[layer].merge(one.still[layer]);
                sum.model[layer].merge(one.model[layer]);
            }
        }
        if (progress) progress("measuring", std::int64_t(first + batch.size()), std::int64_t(chosen.size()));
    }
    ModelEvaluation out;
    out.frames = std::int64_t(chosen.size());
    const char* names[] = {"medium", "fine", "albedo"};
    for (int layer = 0; layer < 3; ++layer)
        if (pair.has(layer)) out.layers.push_back({names[layer], sum.none[layer], sum.still[layer], sum.model[layer]});
    return out;
}

}  // namespace mien::analysis
