#include "analysis/training.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

#include "analysis/layer_fit.hpp"
#include "analysis/texture_triangulation.hpp"
#include "core/parallel.hpp"

namespace mien::analysis {
namespace {

using model::PolynomialOrder;

constexpr int kGlobal = 5;
constexpr int kFewest = 6;         // samples of a texel below which nothing is fitted there
constexpr float kAtRest = 0.1f;    // mm RMS of the markers' offsets
constexpr std::uint32_t kSkin = 1u << int(Surface::skin);

/// Drops texels of a domain that too few frames have seen.
void drop_unseen(model::DomainMap& domain, std::vector<LayerFit*> fits) {
    std::vector<std::uint32_t> kept;
    model::DomainMap rest;
    rest.width = domain.width;
    rest.height = domain.height;
    for (const model::DomainMap::Run& run : domain.runs) {
        const auto begin = std::uint32_t(kept.size());
        for (std::uint32_t i = run.begin; i < run.end; ++i) {
            if (fits.front()->count(i) < kFewest) continue;
            kept.push_back(i);
            rest.place.push_back(domain.place[i]);
            rest.b1.push_back(domain.b1[i]);
            rest.b2.push_back(domain.b2[i]);
        }
        if (kept.size() > begin) rest.runs.push_back({run.triangle, begin, std::uint32_t(kept.size())});
    }
    for (LayerFit* fit : fits) fit->keep(kept);
    domain = std::move(rest);
}

class Trainer {
public:
    Trainer(const Clip& clip, const TrainingOptions& options) : clip_(clip), options_(options) {}

    Result<TrainedModel> run() {
        MIEN_CHECK(check());
        MIEN_CHECK(measure_markers());
        const ScanSource& scans = *clip_.scans;
        model::DetailModel& model = trained_.model;
        model.medium_domain = model::detail_domain(model, scans.medium_size(), scans.medium_size());
        model.fine_domain = model::detail_domain(model, scans.fine_size(), scans.fine_size());
        if (model.medium_domain.size() == 0) return Error{ErrorCode::invalid, "no texel of the skin is near a marker"};

        // The medium layer first, then the fine one on what it leaves.
        std::vector<LayerFit> medium = fits(3, model.medium_domain.size());
        MIEN_CHECK(gather_medium(medium));
        drop_unseen(model.medium_domain, pointers(medium));
        if (model.medium_domain.size() == 0) return Error{ErrorCode::invalid, "the scans show no texel of the skin often enough"};
        trained_.medium_ridge = finish(medium, model.medium, trained_.medium, trained_.medium_error);
        medium.clear();

        const auto where = domain_texels(model.fine_domain, make_texel_map(model.neutral, model.fine_domain.width, model.fine_domain.height, kSkin));
        trained_.high_pass_sigma = options_.high_pass_mm / texel_span(model.neutral, model.fine_domain, where);
        std::vector<LayerFit> fine = fits(1, model.fine_domain.size());
        std::vector<LayerFit> albedo = scans.has_albedo() ? fits(3, model.fine_domain.size()) : std::vector<LayerFit>{};
        MIEN_CHECK(gather_fine(fine, albedo));
        std::vector<LayerFit*> both = pointers(fine);
        for (LayerFit* fit : pointers(albedo)) both.push_back(fit);
        drop_unseen(model.fine_domain, both);
        trained_.fine_ridge = finish(fine, model.fine, trained_.fine, trained_.fine_error);
        if (!albedo.empty()) trained_.albedo_ridge = finish(albedo, model.albedo, trained_.albedo, trained_.albedo_error);
        return std::move(trained_);
    }

private:
    Result<void> check() const {
        const auto missing = [](const char* what) { return Error{ErrorCode::missing, std::string("training needs ") + what}; };
        if (!clip_.neutral || !clip_.neutral->has_texcoords()) return missing("a neutral mesh with texture coordinates");
        if (!clip_.markers) return missing("markers");
        if (clip_.marker_sites.size() < 3) return missing("marker_sites, three or more");
        if (!clip_.scans) return missing("scans (positions_medium and positions_fine)");
        if (clip_.scans->frames() < clip_.markers->frames) return missing("a scan of every frame");
        return {};
    }

    /// Markers of all frames: base shape, axes, what the rivals need.
    Result<void> measure_markers() {
        model::DetailModel& model = trained_.model;
        model.neutral = *clip_.neutral;
        model.sites = clip_.marker_sites;
        model.fixed = options_.fixed;
        model.marker_triangles = triangulate_over_texture(model.neutral, model.sites);
        if (model.marker_triangles.empty()) return Error{ErrorCode::invalid, "the markers span no triangle in texture space"};
        trained_.driver = std::make_shared<model::MarkerDriver>(model.neutral, model.sites, model.fixed, model.marker_triangles);
        const model::MarkerMesh& mesh = trained_.driver->mesh();
        trained_.frames = clip_.markers->frames;

        DeformationMoments moments(mesh);
        const Eigen::Index M = mesh.neutral.rows();
        Eigen::MatrixXd offsets(3 * M, trained_.frames);
        trained_.deformation_scale.setZero();
        for (std::int64_t f = 0; f < trained_.frames; ++f) {
            Points markers = head_space_markers(clip_, f, mesh.neutral);
            if (!model::fill_missing_markers(mesh, markers)) markers = mesh.neutral;
            markers_.push_back(markers);
            const model::Deformations S = trained_.driver->meter().measure(markers);
            moments.add(S);
            trained_.deformation_scale += S.cast<double>().cwiseAbs2().colwise().mean().transpose() / double(trained_.frames);
            const Points offset = markers - mesh.neutral;
            offsets.col(f) = Eigen::Map<const Eigen::VectorXf>(offset.data(), 3 * M).cast<double>();
            at_rest_.push_back(std::sqrt(offset.cwiseAbs2().rowwise().sum().mean()) < kAtRest);
        }
        if (std::none_of(at_rest_.begin(), at_rest_.end(), [](bool b) { return b; })) {
            Eigen::Index calmest = 0;
            offsets.colwise().norm().minCoeff(&calmest);
            at_rest_[std::size_t(calmest)] = true;
        }
        trained_.deformation_scale = trained_.deformation_scale.cwiseSqrt().cwiseMax(1e-9);
        trained_.axis_energy = axis_energy(moments);
        model.axes = deformation_axes(moments, options_.axes);
        model.reach = float(options_.reach_mm);
        for (const Points& markers : markers_)
            model::add_term_moments(trained_.moments, model.axes, trained_.driver->meter().measure(markers), 1 / double(trained_.frames));
        // Principal components about neutral by the Gram matrix, scaled to scores of unit RMS.
        const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> gram(offsets.transpose() * offsets);
        trained_.global_components = Eigen::MatrixXd::Zero(3 * M, kGlobal);
        for (int k = 0; k < std::min<int>(kGlobal, int(trained_.frames)); ++k) {
            const double energy = gram.eigenvalues()[trained_.frames - 1 - k];
            if (energy > 1e-9) trained_.global_components.col(k) = offsets * gram.eigenvectors().col(trained_.frames - 1 - k) * std::sqrt(double(trained_.frames)) / energy;
        }
        return {};
    }

    std::vector<Predictors> kinds() const {
        if (!options_.rivals) return {Predictors::polynomial};
        return {Predictors::polynomial, Predictors::deformation, Predictors::global, Predictors::neutral};
    }
    int predictors(Predictors kind) const {
        if (kind != Predictors::polynomial) return predictor_count(kind);
        return model::term_count(options_.rivals ? PolynomialOrder::bicubic : options_.order);
    }
    std::vector<LayerFit> fits(int values, std::size_t texels) const {
        std::vector<LayerFit> all;
        for (const Predictors kind : kinds()) all.emplace_back(predictors(kind), values, texels, takes());
        return all;
    }
    static std::vector<LayerFit*> pointers(std::vector<LayerFit>& fits) {
        std::vector<LayerFit*> all;
        for (LayerFit& fit : fits) all.push_back(&fit);
        return all;
    }
    int takes() const { return std::max(1, int(clip_.takes.size())); }
    int take_of(std::int64_t frame) const {
        int take = 0;
        while (take + 1 < int(clip_.takes.size()) && clip_.takes[std::size_t(take) + 1].first <= frame) ++take;
        return take;
    }

    /// Reads all scans a few at a time. prepare(frame, scan, predictors) runs in parallel; use(first, count) after each batch.
    template <typename Prepare, typename Use>
    Result<void> each_batch(const char* what, ScanParts parts, const Prepare& prepare, const Use& use) {
        const std::int64_t at_once = 2 * std::int64_t(thread_count()), frames = trained_.frames;
        for (std::int64_t first = 0; first < frames; first += at_once) {
            const std::int64_t count = std::min(at_once, frames - first);
            std::vector<std::optional<Error>> errors(static_cast<std::size_t>(count));
            drives_.clear();
            drives_.resize(std::size_t(count));
            parallel_for(count, [&](std::int64_t i) {
                auto scan = clip_.scans->read(first + i, parts);
                if (!scan.ok()) {
                    errors[std::size_t(i)] = scan.error();
                    return;
                }
                drives_[std::size_t(i)] = std::make_unique<FramePredictors>(trained_, markers_[std::size_t(first + i)]);
                prepare(i, *scan);
            });
            for (const auto& error : errors)
                if (error) return *error;
            use(first, count);
            if (options_.progress) options_.progress(what, first + count, frames);
        }
        return {};
    }

    /// Adds a batch whose values lie in `values`, one block of stride per frame, to the fits of one layer.
    void add(std::vector<LayerFit>& fits, const model::DomainMap& domain, const std::vector<float>& values, std::size_t stride, std::int64_t first, std::int64_t count) {
        std::vector<std::uint32_t> triangle(domain.size());
        for (const auto& run : domain.runs) std::fill(triangle.begin() + run.begin, triangle.begin() + run.end, run.triangle);
        for (std::size_t k = 0; k < fits.size(); ++k) {
            const Predictors kind = kinds()[k];
            std::vector<LayerFit::Frame> batch;
            for (std::int64_t i = 0; i < count; ++i) {
                if (kind == Predictors::neutral && !at_rest_[std::size_t(first + i)]) continue;
                const FramePredictors& drive = *drives_[std::size_t(i)];
                const int n = predictors(kind);
                batch.push_back({[&, n, kind](std::uint32_t texel, double* x) {
                                     double all[model::kMaxTerms];
                                     drive.at(kind, domain, triangle[texel], texel, all);
                                     std::copy_n(all, n, x);
                                 },
                                 values.data() + std::size_t(i) * stride, take_of(first + i)});
            }
            fits[k].add(batch);
        }
    }

    Result<void> gather_medium(std::vector<LayerFit>& fits) {
        const model::DetailModel& model = trained_.model;
        const model::DomainMap& domain = model.medium_domain;
        const auto where = domain_texels(domain, make_texel_map(model.neutral, domain.width, domain.height, kSkin));
        const std::size_t stride = 3 * domain.size();
        std::vector<float> values(stride * 2 * std::size_t(thread_count()));
        return each_batch("fitting the medium layer", {true, false, false},
            [&](std::int64_t i, const Scan& scan) {
                medium_target(scan.medium, model.neutral, domain, where, drives_[std::size_t(i)]->frame().base, values.data() + std::size_t(i) * stride);
            },
            [&](std::int64_t first, std::int64_t count) { add(fits, domain, values, stride, first, count); });
    }

    Result<void> gather_fine(std::vector<LayerFit>& fine, std::vector<LayerFit>& albedo) {
        const model::DetailModel& model = trained_.model;
        const model::DomainMap& domain = model.fine_domain;
        const FineTarget target(model, trained_.high_pass_sigma, options_.fine_over);
        trained_.fine_over = options_.fine_over;
        const std::size_t n = domain.size();
        std::vector<float> heights(n * 2 * std::size_t(thread_count())), colours(albedo.empty() ? 0 : 3 * heights.size());
        return each_batch("fitting the fine layer", {options_.fine_over == FineOver::scan, true, !albedo.empty()},
            [&](std::int64_t i, const Scan& scan) {
                const model::DrivenFrame& frame = drives_[std::size_t(i)]->frame();
                std::vector<float> medium(3 * model.medium_domain.size());
                model::evaluate(model.medium, model.medium_domain, frame.parameters, medium.data());
                target.compute(scan, frame.base, medium.data(), heights.data() + std::size_t(i) * n);
                for (int c = 0; c < 3 && !albedo.empty(); ++c)
                    for (std::size_t k = 0; k < n; ++k)
                        colours[(3 * std::size_t(i) + std::size_t(c)) * n + k] = scan.albedo.values[3 * std::size_t(domain.place[k]) + std::size_t(c)];
            },
            [&](std::int64_t first, std::int64_t count) {
                add(fine, domain, heights, n, first, count);
                if (!albedo.empty()) add(albedo, domain, colours, 3 * n, first, count);
            });
    }

    /// Strengths, the map of the asked order with its left-out error, and for a report all others.
    Ridge finish(const std::vector<LayerFit>& fits, model::PolynomialMap& map, std::vector<FittedMap>& all, double& error) {
        if (options_.progress) options_.progress("choosing strengths", 0, 0);
        const std::vector<int> degrees = polynomial_degrees();
        const LayerFit& polynomial = fits.front();
        const int most = model::term_count(options_.rivals ? PolynomialOrder::bicubic : options_.order);
        const Ridge ridge = options_.ridge ? *options_.ridge : choose_ridge(polynomial, most, degrees, takes());
        map = model::PolynomialMap(polynomial.values(), options_.order, polynomial.texels());
        map.planes = polynomial.solve(model::term_count(options_.order), degrees, ridge);
        error = std::sqrt(polynomial.values() * polynomial.left_out_error(model::term_count(options_.order), degrees, ridge));
        if (!options_.rivals) return ridge;
        for (const auto order : {PolynomialOrder::linear, PolynomialOrder::biquadratic, PolynomialOrder::bicubic})
            all.push_back({Predictors::polynomial, model::term_count(order), polynomial.values(), ridge, polynomial.solve(model::term_count(order), degrees, ridge)});
        for (std::size_t k = 1; k < fits.size(); ++k) {
            const Predictors kind = kinds()[k];
            const std::vector<int> linear = linear_degrees(predictor_count(kind) - 1);
            const Ridge own = kind == Predictors::neutral ? Ridge{} : options_.ridge ? *options_.ridge : choose_ridge(fits[k], predictor_count(kind), linear, takes());
            all.push_back({kind, predictor_count(kind), fits[k].values(), own, fits[k].solve(predictor_count(kind), linear, own)});
        }
        return ridge;
    }

    const Clip& clip_;
    const TrainingOptions& options_;
    TrainedModel trained_;
    std::vector<Points> markers_;
    std::vector<bool> at_rest_;
    std::vector<std::unique_ptr<const FramePredictors>> drives_;  // of the batch
};

}  // namespace

Points head_space_markers(const Clip& clip, std::int64_t frame, PointsRef neutral_markers) {
    Points markers = clip.markers->frame(frame);
    if (!clip.head_pose.empty()) {
        apply_pose(clip.head_pose[std::size_t(frame)].inverse(), markers);
        return markers;
    }
    Eigen::VectorXf weights(markers.rows());
    Points there = markers;
    for (Eigen::Index m = 0; m < markers.rows(); ++m) {
        weights[m] = markers.row(m).allFinite() ? 1.0f : 0.0f;
        if (weights[m] == 0) there.row(m).setZero();
    }
    apply_pose(fit_rigid(there, neutral_markers, weights), markers);
    return markers;
}

int predictor_count(Predictors kind) {
    switch (kind) {
        case Predictors::polynomial: return model::kMaxTerms;
        case Predictors::deformation: return 1 + model::kDeformationSize;
        case Predictors::global: return 1 + kGlobal;
        case Predictors::neutral: return 1;
    }
    return 0;
}

FramePredictors::FramePredictors(const TrainedModel& trained, PointsRef markers)
    : trained_(trained), frame_(trained.driver->drive(markers, trained.model.axes)) {
    Points there = markers;
    model::fill_missing_markers(trained.driver->mesh(), there);
    const Points offset = there - trained.driver->mesh().neutral;
    const Eigen::VectorXd flat = Eigen::Map<const Eigen::VectorXf>(offset.data(), offset.size()).cast<double>();
    Eigen::Map<Eigen::Matrix<double, 5, 1>> scores(global_);
    scores = trained.global_components.transpose() * flat;
}

void FramePredictors::at(Predictors kind, const model::DomainMap& domain, std::uint32_t triangle, std::uint32_t texel, double* out) const {
    const float b1 = domain.b1[texel], b2 = domain.b2[texel];
    out[0] = 1;
    if (kind == Predictors::polynomial) {
        model::polynomial_terms(double(frame_.parameters.d1[triangle].at(b1, b2)), double(frame_.parameters.d2[triangle].at(b1, b2)), out);
    } else if (kind == Predictors::deformation) {
        const Triangle& c = trained_.model.marker_triangles[triangle];
        for (int k = 0; k < model::kDeformationSize; ++k)
            out[1 + k] = double((1 - b1 - b2) * frame_.S(c[0], k) + b1 * frame_.S(c[1], k) + b2 * frame_.S(c[2], k)) / trained_.deformation_scale[k];
    } else if (kind == Predictors::global) {
        std::copy_n(global_, 5, out + 1);
    }
}

Result<TrainedModel> train(const Clip& clip, const TrainingOptions& options) { return Trainer(clip, options).run(); }

}  // namespace mien::analysis
