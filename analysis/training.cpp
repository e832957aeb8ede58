#include "analysis/training.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

#include "analysis/frame_predictors.hpp"
#include "analysis/frame_values.hpp"
#include "analysis/layer_fit.hpp"
#include "analysis/texture_triangulation.hpp"
#include "core/parallel.hpp"

namespace mien::analysis {
namespace {

using model::PolynomialOrder;

constexpr int kFewest = 6;         // samples of a texel below which nothing is fitted there
// Parts of a take that are left out in turn when strengths are chosen. What the medium layer makes of an expression that nobody showed may
// be millimetres off, so whole takes are. For thin layers that is too careful, as nobody would leave an expression out of a training.
constexpr int kMediumParts = 1, kFineParts = 5;
constexpr float kAtRest = 0.1f;    // mm RMS of the markers' offsets
constexpr std::uint32_t kSkin = 1u << int(Surface::skin);
constexpr std::size_t kKept = 375'000'000;  // bytes for each value of a texel: all four of the fine maps take 1.5 GB
// Of choosing axes: every so many texels of a map, and frames in all.
constexpr std::uint32_t kEveryMedium = 5, kEveryFine = 17;
constexpr std::int64_t kAxisFrames = 60;
constexpr std::int64_t kBatch = 128;  // kept frames that are added together
constexpr Ridge kSlopeRidge{0.01, 0.01, 0.01, true};
constexpr double kLeastScale = 1e-9;  // mm or albedo: what is explained exactly leaves nothing to weigh by

/// A way to explain a layer: the first `terms` predictors of a kind.
struct Way {
    Predictors kind;
    int terms;
    std::vector<int> degrees() const { return kind == Predictors::polynomial ? polynomial_degrees() : linear_degrees(terms - 1); }
};

/// A layer on its way: what it is to explain, and its problems by way.
struct LayerProblem {
    int parts;                    // of a take
    std::vector<Way> ways;
    FrameValues values;
    std::vector<LayerFit> fits;   // by way
    double scale = 0;   // of reweighing

    void keep(const std::vector<std::uint32_t>& texels) {
        values.keep(texels);
        for (LayerFit& fit : fits) fit.keep(texels);
    }
};

/// Drops texels of a domain that too few frames have seen.
void drop_unseen(model::DomainMap& domain, const std::vector<LayerProblem*>& layers) {
    std::vector<std::uint32_t> kept;
    model::DomainMap rest;
    rest.width = domain.width;
    rest.height = domain.height;
    for (const model::DomainMap::Run& run : domain.runs) {
        const auto begin = std::uint32_t(kept.size());
        for (std::uint32_t i = run.begin; i < run.end; ++i) {
            if (layers.front()->fits.front().count(i) < kFewest) continue;
            kept.push_back(i);
            rest.place.push_back(domain.place[i]);
            rest.b1.push_back(domain.b1[i]);
            rest.b2.push_back(domain.b2[i]);
        }
        if (kept.size() > begin) rest.runs.push_back({run.triangle, begin, std::uint32_t(kept.size())});
    }
    for (LayerProblem* layer : layers) layer->keep(kept);
    domain = std::move(rest);
}

/// The marker triangle of every texel.
std::vector<std::uint32_t> triangles_of(const model::DomainMap& domain) {
    std::vector<std::uint32_t> triangle(domain.size());
    for (const auto& run : domain.runs) std::fill(triangle.begin() + run.begin, triangle.begin() + run.end, run.triangle);
    return triangle;
}

/// Texels 0, every, 2 every, ... of a domain.
model::DomainMap thinned(const model::DomainMap& domain, std::uint32_t every) {
    model::DomainMap few;
    few.width = domain.width;
    few.height = domain.height;
    for (const model::DomainMap::Run& run : domain.runs) {
        const auto begin = std::uint32_t(few.size());
        for (std::uint32_t i = (run.begin + every - 1) / every * every; i < run.end; i += every) {
            few.place.push_back(domain.place[i]);
            few.b1.push_back(domain.b1[i]);
            few.b2.push_back(domain.b2[i]);
        }
        if (few.size() > begin) few.runs.push_back({run.triangle, begin, std::uint32_t(few.size())});
    }
    return few;
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

        MIEN_CHECK(choose_axes());

        // The medium layer first, then the fine one on what it leaves.
        {
            LayerProblem medium = problem(3, model.medium_domain.size(), kMediumParts);
            MIEN_CHECK(solve({&medium}, model.medium_domain, options_.medium_rounds, [&] { return gather_medium(medium); }));
            if (model.medium_domain.size() == 0) return Error{ErrorCode::invalid, "the scans show no texel of the skin often enough"};
            trained_.medium_ridge = finish(medium, model.medium, trained_.medium);
        }
        const auto where = domain_texels(model.fine_domain, make_texel_map(model.neutral, model.fine_domain.width, model.fine_domain.height, kSkin));
        trained_.high_pass_sigma = options_.high_pass_mm / texel_span(model.neutral, model.fine_domain, where);
        LayerProblem fine = problem(1, model.fine_domain.size(), kFineParts);
        std::optional<LayerProblem> albedo;
        if (scans.has_albedo()) albedo = problem(3, model.fine_domain.size(), kFineParts);
        std::vector<LayerProblem*> both{&fine};
        if (albedo) both.push_back(&*albedo);
        MIEN_CHECK(solve(both, model.fine_domain, options_.rounds, [&] { return gather_fine(fine, albedo); }));
        trained_.fine_ridge = finish(fine, model.fine, trained_.fine);
        const Way own = ways()[own_way()];
        trained_.fine_stored = fine.fits[own_way()].noise_for(options_.stored_share, own.terms, own.degrees(), trained_.fine_ridge);
        if (albedo) trained_.albedo_ridge = finish(*albedo, model.albedo, trained_.albedo);
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
        model.neutral = options_.neutral ? *options_.neutral : *clip_.neutral;
        model.sites = clip_.marker_sites;
        model.fixed = options_.fixed;
        model.marker_triangles = triangulate_over_texture(model.neutral, model.sites);
        if (model.marker_triangles.empty()) return Error{ErrorCode::invalid, "the markers span no triangle in texture space"};
        trained_.driver = std::make_shared<model::MarkerDriver>(model.neutral, model.sites, model.fixed, model.marker_triangles);
        const model::MarkerMesh& mesh = trained_.driver->mesh();
        const Points rest = markers_at_rest(clip_, mesh.neutral);
        trained_.frames = clip_.markers->frames;

        moments_.emplace(mesh);
        const Eigen::Index M = mesh.neutral.rows();
        Eigen::MatrixXd offsets(3 * M, trained_.frames);
        trained_.deformation_scale.setZero();
        for (std::int64_t f = 0; f < trained_.frames; ++f) {
            Points markers = head_space_markers(clip_, f, rest, mesh.neutral);
            if (!model::fill_missing_markers(mesh, markers)) markers = mesh.neutral;
            markers_.push_back(markers);
            const model::Deformations S = trained_.driver->meter().measure(markers);
            moments_->add(S);
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
        trained_.axis_energy = axis_energy(*moments_);
        model.axes = deformation_axes(*moments_, options_.axes);   // until the layers have told theirs
        model.reach = float(options_.reach_mm);
        // Principal components about neutral by the Gram matrix, scaled to scores of unit RMS.
        const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> gram(offsets.transpose() * offsets);
        trained_.global_components = Eigen::MatrixXd::Zero(3 * M, kGlobalPredictors);
        for (int k = 0; k < std::min<int>(kGlobalPredictors, int(trained_.frames)); ++k) {
            const double energy = gram.eigenvalues()[trained_.frames - 1 - k];
            if (energy > 1e-9) trained_.global_components.col(k) = offsets * gram.eigenvectors().col(trained_.frames - 1 - k) * std::sqrt(double(trained_.frames)) / energy;
        }
        return {};
    }

    std::vector<Way> ways() const {
        if (!options_.rivals) return {{Predictors::polynomial, model::term_count(options_.order)}};
        std::vector<Way> all;
        for (const auto order : {PolynomialOrder::linear, PolynomialOrder::biquadratic, PolynomialOrder::bicubic})
            all.push_back({Predictors::polynomial, model::term_count(order)});
        for (const Predictors rival : {Predictors::deformation, Predictors::global, Predictors::neutral}) all.push_back({rival, predictor_count(rival)});
        return all;
    }
    /// The way that the model goes.
    std::size_t own_way() const { return options_.rivals ? std::size_t(options_.order) - std::size_t(PolynomialOrder::linear) : 0; }
    LayerProblem problem(int values, std::size_t texels, int parts) const { return problem(values, texels, parts, ways(), kKept * std::size_t(values)); }
    LayerProblem problem(int values, std::size_t texels, int parts, std::vector<Way> ways, std::size_t kept) const {
        LayerProblem layer{parts, std::move(ways), FrameValues(trained_.frames, values, texels, lanes(), kept), {}};
        for (const Way& way : layer.ways) layer.fits.emplace_back(way.terms, values, texels, parts * takes());
        return layer;
    }
    int takes() const { return std::max(1, int(clip_.takes.size())); }
    /// Neighbouring frames of a take are left out together: they are too alike to tell of the unseen.
    int fold_of(std::int64_t frame, int parts) const {
        int take = 0;
        while (take + 1 < takes() && clip_.takes[std::size_t(take) + 1].first <= frame) ++take;
        const std::int64_t first = take == 0 ? 0 : clip_.takes[std::size_t(take)].first;
        const std::int64_t end = take + 1 < takes() ? clip_.takes[std::size_t(take) + 1].first : trained_.frames;
        return parts * take + int(parts * (frame - first) / (end - first));
    }

    /// Frames that are read together.
    static std::int64_t lanes() { return std::max<std::int64_t>(NormalEquations::kTogether, 2 * std::int64_t(thread_count())); }

    /// A layer and where its texels are.
    struct Placed {
        LayerProblem* layer;
        const model::DomainMap* domain;
    };
    /// Adds all frames, or every so many, to the problems of some layers. What is not kept is read, a few frames at a time:
    /// measure(frame, lane, scan) writes their values, in parallel.
    template <typename Measure>
    Result<void> gather(const char* what, ScanParts parts, const std::vector<Placed>& layers, const Measure& measure, std::int64_t every = 1) {
        const std::int64_t frames = (trained_.frames + every - 1) / every;
        const auto all_kept = [&](std::int64_t frame) { return std::all_of(layers.begin(), layers.end(), [&](const Placed& placed) { return placed.layer->values.kept(frame); }); };
        for (std::int64_t first = 0, count = 0; first < frames; first += count) {
            for (count = 0; first + count < frames && count < kBatch && all_kept((first + count) * every);) ++count;
            count = std::max(count, std::min(lanes(), frames - first));
            std::vector<std::optional<Error>> errors(static_cast<std::size_t>(count));
            drives_.clear();
            drives_.resize(std::size_t(count));
            parallel_for(count, [&](std::int64_t i) {
                const std::int64_t frame = (first + i) * every;
                drives_[std::size_t(i)] = std::make_unique<FramePredictors>(trained_, markers_[std::size_t(frame)]);
                if (all_kept(frame)) return;
                auto scan = clip_.scans->read(frame, parts);
                if (scan.ok())
                    measure(frame, i, *scan);
                else
                    errors[std::size_t(i)] = scan.error();
            });
            for (const auto& error : errors)
                if (error) return *error;
            for (const Placed& placed : layers) add(*placed.layer, *placed.domain, first, count, every);
            if (options_.progress) options_.progress(what, first + count, frames);
        }
        return {};
    }

    /// Adds a batch of frames to the problems of a layer.
    void add(LayerProblem& layer, const model::DomainMap& domain, std::int64_t first, std::int64_t count, std::int64_t every) {
        const std::vector<std::uint32_t> triangle = triangles_of(domain);
        for (std::size_t k = 0; k < layer.ways.size(); ++k) {
            const Way way = layer.ways[k];
            std::vector<LayerFit::Frame> batch;
            std::vector<const FramePredictors*> drives;
            for (std::int64_t i = 0; i < count; ++i) {
                const std::int64_t at = (first + i) * every;
                if (way.kind == Predictors::neutral && !at_rest_[std::size_t(at)]) continue;
                drives.push_back(drives_[std::size_t(i)].get());
                batch.push_back({layer.values.read(at, i), fold_of(at, layer.parts)});
            }
            const BatchPredictors predictors(trained_, drives, way.kind, way.terms);
            layer.fits[k].add(batch, [&](std::uint32_t texel, double* x) { predictors.at(domain, triangle[texel], texel, x); });
        }
    }

    /// Which plane of S a marker's d1 and d2 lie in and how far they go there. The layers around it tell the plane: all three are fitted as linear in all of S, at few
    /// texels of few frames, and weigh alike. Their fine layer lies over the bare base.
    Result<void> choose_axes() {
        model::DetailModel& model = trained_.model;
        if (options_.axes.choice == AxisChoice::telling) {
            const model::DomainMap medium_domain = thinned(model.medium_domain, kEveryMedium), fine_domain = thinned(model.fine_domain, kEveryFine);
            const auto where = [&](const model::DomainMap& domain) { return domain_texels(domain, make_texel_map(model.neutral, domain.width, domain.height, kSkin)); };
            const auto medium_where = where(medium_domain);
            const double sigma = options_.high_pass_mm / texel_span(model.neutral, model.fine_domain, where(model.fine_domain));
            model.medium = model::PolynomialMap(3, options_.order, model.medium_domain.size());
            const FineTarget target(model, sigma, options_.fine_over);
            const std::vector<float> bare(3 * model.medium_domain.size());

            const std::vector<Way> all_of_S{{Predictors::deformation, predictor_count(Predictors::deformation)}};
            LayerProblem medium = problem(3, medium_domain.size(), 1, all_of_S, 0), fine = problem(1, fine_domain.size(), 1, all_of_S, 0),
                         albedo = problem(3, fine_domain.size(), 1, all_of_S, 0);
            std::vector<Placed> layers{{&medium, &medium_domain}, {&fine, &fine_domain}};
            if (clip_.scans->has_albedo()) layers.push_back({&albedo, &fine_domain});
            const auto measure = [&](std::int64_t frame, std::int64_t lane, const Scan& scan) {
                const Points base = drives_[std::size_t(lane)]->base();
                medium_target(scan.medium, model.neutral, medium_domain, medium_where, base, medium.values.write(frame, lane));
                std::vector<float> heights(model.fine_domain.size());
                target.compute(scan, base, bare.data(), heights.data());
                float* to = fine.values.write(frame, lane);
                for (std::size_t i = 0; i < fine_domain.size(); ++i) to[i] = heights[i * kEveryFine];
                if (scan.albedo.values.empty()) return;
                float* colours = albedo.values.write(frame, lane);
                for (std::size_t c = 0; c < 3; ++c)
                    for (std::size_t i = 0; i < fine_domain.size(); ++i)
                        colours[c * fine_domain.size() + i] = scan.albedo.values[3 * std::size_t(fine_domain.place[i]) + c];
            };
            MIEN_CHECK(gather("choosing axes", {true, true, clip_.scans->has_albedo()}, layers, measure, (trained_.frames + kAxisFrames - 1) / kAxisFrames));
            std::vector<Moment> slopes(model.sites.size(), Moment::Zero());
            for (const Placed& placed : layers) add_slopes(*placed.layer, *placed.domain, slopes);
            model.axes = deformation_axes(*moments_, options_.axes, slopes);
            model.medium = {};
        }
        Eigen::VectorXf longest;
        for (const Points& markers : markers_) {
            const model::Deformations S = trained_.driver->meter().measure(markers);
            model::add_term_moments(trained_.moments, model.axes, S, 1 / double(trained_.frames));
            model::add_extents(longest, model.axes, S);
        }
        if (options_.bounded) model.axes.extents = longest;
        return {};
    }

    /// b b' of a layer's slopes to the markers whose triangle a texel lies in, so that all of a layer is one.
    void add_slopes(const LayerProblem& layer, const model::DomainMap& domain, std::vector<Moment>& slopes) const {
        const LayerFit& fit = layer.fits.front();
        const int terms = layer.ways.front().terms;
        const std::vector<float> planes = fit.solve(terms, layer.ways.front().degrees(), kSlopeRidge);
        const std::vector<std::uint32_t> triangle = triangles_of(domain);
        std::vector<Moment> own(slopes.size(), Moment::Zero());
        double all = 0;
        for (std::size_t i = 0; i < domain.size(); ++i) {
            if (fit.count(i) < 2 * terms) continue;
            const double shares[3] = {1.0 - double(domain.b1[i]) - double(domain.b2[i]), double(domain.b1[i]), double(domain.b2[i])};
            for (int v = 0; v < fit.values(); ++v) {
                Eigen::Matrix<double, model::kDeformationSize, 1> scaled;   // change with S in units of its RMS
                for (int k = 0; k < model::kDeformationSize; ++k) scaled[k] = double(planes[std::size_t(v * terms + 1 + k) * domain.size() + i]);
                const Eigen::Matrix<double, model::kDeformationSize, 1> slope = scaled.cwiseQuotient(trained_.deformation_scale);
                for (std::size_t k = 0; k < 3; ++k) own[trained_.model.marker_triangles[triangle[i]][k]] += std::max(0.0, shares[k]) * slope * slope.transpose();
                all += scaled.squaredNorm();
            }
        }
        if (!(all > 0)) return;
        for (std::size_t m = 0; m < slopes.size(); ++m) slopes[m] += own[m] / all;
    }

    Result<void> gather_medium(LayerProblem& medium) {
        const model::DetailModel& model = trained_.model;
        const model::DomainMap& domain = model.medium_domain;
        const auto where = domain_texels(domain, make_texel_map(model.neutral, domain.width, domain.height, kSkin));
        return gather("fitting the medium layer", {true, false, false}, {{&medium, &domain}}, [&](std::int64_t frame, std::int64_t lane, const Scan& scan) {
            medium_target(scan.medium, model.neutral, domain, where, drives_[std::size_t(lane)]->base(), medium.values.write(frame, lane));
        });
    }

    Result<void> gather_fine(LayerProblem& fine, std::optional<LayerProblem>& albedo) {
        const model::DetailModel& model = trained_.model;
        const model::DomainMap& domain = model.fine_domain;
        const FineTarget target(model, trained_.high_pass_sigma, options_.fine_over);
        trained_.fine_over = options_.fine_over;
        std::vector<Placed> layers{{&fine, &domain}};
        if (albedo) layers.push_back({&*albedo, &domain});
        return gather("fitting the fine layer", {options_.fine_over == FineOver::scan, true, albedo.has_value()}, layers,
            [&](std::int64_t at, std::int64_t lane, const Scan& scan) {
                if (!fine.values.kept(at)) {
                    const FramePredictors& drive = *drives_[std::size_t(lane)];
                    std::vector<float> medium(3 * model.medium_domain.size());
                    model::evaluate(model.medium, model.medium_domain, drive.parameters(), medium.data());
                    target.compute(scan, drive.base(), medium.data(), fine.values.write(at, lane));
                }
                if (!albedo || albedo->values.kept(at)) return;
                float* colours = albedo->values.write(at, lane);
                for (std::size_t c = 0; c < 3; ++c)
                    for (std::size_t k = 0; k < domain.size(); ++k) colours[c * domain.size() + k] = scan.albedo.values[3 * std::size_t(domain.place[k]) + c];
            });
    }

    /// Gathers layers of one domain, then `rounds` times anew with samples weighed by what the fit leaves of them.
    template <typename Gather>
    Result<void> solve(const std::vector<LayerProblem*>& layers, model::DomainMap& domain, int rounds, const Gather& gather_all) {
        MIEN_CHECK(gather_all());
        drop_unseen(domain, layers);
        for (int round = 0; round < rounds; ++round) {
            for (LayerProblem* layer : layers) reweigh(*layer);
            MIEN_CHECK(gather_all());
        }
        return {};
    }

    void reweigh(LayerProblem& layer) const {
        const std::vector<Way>& all = layer.ways;
        if (layer.scale == 0) {
            const Way& own = all[own_way()];
            const LayerFit& fit = layer.fits[own_way()];
            layer.scale = std::max(kLeastScale, fit.typical_error(own.terms, own.degrees(), strengths(own, fit)));
        }
        for (std::size_t k = 0; k < all.size(); ++k)
            layer.fits[k].reweigh(layer.fits[k].solve(all[k].terms, all[k].degrees(), strengths(all[k], layer.fits[k])), all[k].terms, layer.scale);
    }

    Ridge strengths(const Way& way, const LayerFit& fit) const {
        if (way.kind == Predictors::neutral) return {};
        return options_.ridge ? *options_.ridge : choose_ridge(fit, way.terms, way.degrees(), takes());
    }

    /// Strengths, the map of the asked order, and for a report all others.
    Ridge finish(const LayerProblem& layer, model::PolynomialMap& map, std::vector<FittedMap>& fitted) const {
        if (options_.progress) options_.progress("choosing strengths", 0, 0);
        const std::vector<Way>& all = layer.ways;
        Ridge chosen;
        for (std::size_t k = 0; k < all.size(); ++k) {
            const LayerFit& fit = layer.fits[k];
            const Ridge ridge = strengths(all[k], fit);
            std::vector<float> planes = fit.solve(all[k].terms, all[k].degrees(), ridge);
            if (k == own_way()) {
                chosen = ridge;
                map = model::PolynomialMap(fit.values(), options_.order, fit.texels());
                map.planes = planes;
            }
            if (options_.rivals) fitted.push_back({all[k].kind, all[k].terms, fit.values(), ridge, std::move(planes)});
        }
        return chosen;
    }

    const Clip& clip_;
    const TrainingOptions& options_;
    TrainedModel trained_;
    std::optional<DeformationMoments> moments_;
    std::vector<Points> markers_;
    std::vector<bool> at_rest_;
    std::vector<std::unique_ptr<const FramePredictors>> drives_;  // of the batch
};

}  // namespace

Points markers_at_rest(const Clip& clip, PointsRef neutral_markers) {
    Points rest = neutral_markers;
    if (clip.neutral && std::int64_t(clip.marker_sites.size()) == rest.rows())
        for (std::size_t m = 0; m < clip.marker_sites.size(); ++m) rest.row(Eigen::Index(m)) = clip.marker_sites[m].position(clip.neutral->positions).transpose();
    return rest;
}

Points head_space_markers(const Clip& clip, std::int64_t frame, PointsRef rest, PointsRef neutral_markers) {
    Points markers = clip.markers->frame(frame);
    if (!clip.head_pose.empty()) {
        apply_pose(clip.head_pose[std::size_t(frame)].inverse(), markers);
    } else {
        Eigen::VectorXf weights(markers.rows());
        Points there = markers;
        for (Eigen::Index m = 0; m < markers.rows(); ++m) {
            weights[m] = markers.row(m).allFinite() ? 1.0f : 0.0f;
            if (weights[m] == 0) there.row(m).setZero();
        }
        apply_pose(fit_rigid(there, rest, weights), markers);
    }
    return markers - rest + neutral_markers;
}

Result<TrainedModel> train(const Clip& clip, const TrainingOptions& options) { return Trainer(clip, options).run(); }

}  // namespace mien::analysis
