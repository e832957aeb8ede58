#include "encoder/detail_encoder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>

#include "coding/coefficient_planes.hpp"
#include "core/parallel.hpp"
#include "encoder/detail_planes.hpp"
#include "encoder/head_layers.hpp"
#include "protocol/messages.hpp"
#include "protocol/stream_file.hpp"

namespace mien::encoder {
namespace {

using protocol::BlobKind;
using protocol::LayerKind;

constexpr double kSpread = 0.02;  // see term_factors
constexpr double kLeastFine = 1e-5;  // mm: a fit that leaves nothing says nothing
constexpr int kSearch = 8;        // rounds to keep the asked number of bytes
constexpr int kSearchPairs = 3;   // of errors that are tried to keep a layer's
constexpr double kSlack = 0.015;  // octaves of bytes: one percent may stay unused
constexpr double kCoarsest = 8;   // octaves of step

/// The texels that a map keeps, and what codes them.
struct Domain {
    model::DomainMap map;                  ///< as decoders will have it
    std::vector<std::uint32_t> from;       ///< of its texels in the trained domain
    std::vector<std::uint32_t> rank;       ///< of its texels among the mask's
    std::optional<coding::MaskedWavelet> wavelet;
    Hash mask;
};

struct LayerJob {
    const char* name;
    LayerKind kind;
    const Domain* domain;
    std::optional<DetailPlanes> planes;
    double rms;
    int stages;
    std::optional<DetailPlanes::Coded> coded;  ///< at rms, when that has been tried
};

std::size_t bytes_of(const DetailPlanes::Coded& map) {
    std::size_t bytes = 0;
    for (const auto& stage : map.stages) bytes += stage.coded.size() + 34;
    return bytes;
}

class DetailPacker {
public:
    DetailPacker(const model::DetailModel& model, const model::TermMoments& moments, const DetailOptions& options)
        : model_(model), moments_(moments), options_(options) {}

    Result<EncodedDetail> run(const std::string& actor) {
        MIEN_CHECK(check());
        parts_.manifest.actor = actor;
        MIEN_CHECK(add_mesh_and_markers());
        MIEN_CHECK(add_rest_of_head());
        Domain medium = domain(model_.medium_domain), fine = domain(model_.fine_domain);
        add_job("medium", LayerKind::medium, medium, model_.medium, out_.model.medium, options_.medium, options_.stages);
        add_job("fine", LayerKind::fine, fine, model_.fine, out_.model.fine, options_.fine, options_.fine_stages > 0 ? options_.fine_stages : options_.stages);
        add_job("albedo", LayerKind::albedo_map, fine, model_.albedo, out_.model.albedo, options_.albedo, options_.stages);
        for (const LayerJob& job : jobs_)
            if (!(job.planes->largest(job.planes->step_for(job.rms)) < coding::CoefficientPlanes::kMaxValue))
                return Error{ErrorCode::invalid, std::string("the ") + job.name + " map is not finite or too large for so small an error"};
        keep_map_bytes();
        MIEN_TRY(coded, code_maps());
        Stored stored = store(coded);
        out_.manifest = stored.manifest;
        out_.blobs = std::move(stored.blobs);
        tell_of(coded);
        out_.model.medium_domain = std::move(medium.map);
        out_.model.fine_domain = std::move(fine.map);
        return std::move(out_);
    }

private:
    using CodedMaps = std::vector<DetailPlanes::Coded>;

    Result<void> check() const {
        const auto refuse = [](const char* why) { return Error{ErrorCode::invalid, std::string("this model cannot be stored: ") + why}; };
        if (model_.sites.size() < 3 || model_.sites.size() > coding::kMaxDetailMarkers) return refuse("it has fewer than 3 or more than 4096 markers");
        if (!model_.neutral.has_texcoords()) return refuse("its mesh has no texture coordinates");
        for (const model::DomainMap* map : {&model_.medium_domain, &model_.fine_domain})
            if (map->width > coding::kMaxMaskSide || map->height > coding::kMaxMaskSide) return refuse("a map is larger than 4096 x 4096");
        return {};
    }

    Result<void> add_mesh_and_markers() {
        MIEN_TRY(mesh, store_mesh(model_.neutral, options_.mesh_step, true, parts_.list));
        out_.model.neutral = std::move(mesh.mesh);
        parts_.layer(LayerKind::shape, std::move(mesh.blobs));

        std::vector<std::uint32_t> fixed = model_.fixed;
        std::sort(fixed.begin(), fixed.end());
        fixed.erase(std::unique(fixed.begin(), fixed.end()), fixed.end());
        const Hash shell = parts_.list.add(BlobKind::shell, coding::encode_shell({model_.sites, fixed}));
        MIEN_TRY(stored_shell, coding::decode_shell(parts_.list.bytes_of(shell), out_.model.neutral.vertex_count()));
        out_.model.sites = std::move(stored_shell.sites);
        out_.model.fixed = std::move(stored_shell.fixed);
        parts_.layer(LayerKind::thin_shell, {shell});

        coding::MarkerDomain markers;
        markers.reach = model_.reach;
        markers.triangles = model_.marker_triangles;
        const auto M = Eigen::Index(model_.sites.size());
        for (Eigen::Index m = 0; m < M; ++m) {
            auto& row = markers.axes.emplace_back();
            for (int k = 0; k < model::kDeformationSize; ++k) {
                row[std::size_t(k)] = model_.axes.q(m, k);
                row[std::size_t(k + model::kDeformationSize)] = model_.axes.r(m, k);
            }
        }
        markers.extents.assign(model_.axes.extents.begin(), model_.axes.extents.end());
        const auto order = std::max({model_.medium.order, model_.fine.order, model_.albedo.order});
        const model::TermFactors factors = model::term_factors(moments_, order, kSpread);
        markers.terms = factors.terms;
        markers.factors = factors.values;
        const Hash blob = parts_.list.add(BlobKind::marker_domain, coding::encode_marker_domain(markers));
        MIEN_TRY(stored, coding::decode_marker_domain(parts_.list.bytes_of(blob), std::uint32_t(M)));
        out_.model.reach = stored.reach;
        out_.model.marker_triangles = std::move(stored.triangles);
        out_.model.axes.q.resize(M, model::kDeformationSize);
        out_.model.axes.r.resize(M, model::kDeformationSize);
        for (Eigen::Index m = 0; m < M; ++m)
            for (int k = 0; k < model::kDeformationSize; ++k) {
                out_.model.axes.q(m, k) = stored.axes[std::size_t(m)][std::size_t(k)];
                out_.model.axes.r(m, k) = stored.axes[std::size_t(m)][std::size_t(k + model::kDeformationSize)];
            }
        out_.model.axes.extents = Eigen::Map<const Eigen::VectorXf>(stored.extents.data(), Eigen::Index(stored.extents.size()));
        factors_ = {stored.terms, std::move(stored.factors)};
        parts_.layer(LayerKind::marker_domain, {blob});
        return {};
    }

    Result<void> add_rest_of_head() {
        parts_.model.neutral = out_.model.neutral;
        // A sheet of skin alone has nothing to blend, and four markers are what blending asks for.
        const std::vector<Surface> surfaces = model_.neutral.triangle_surfaces();
        const bool more_than_skin = std::any_of(surfaces.begin(), surfaces.end(), [](Surface s) { return s != Surface::skin; });
        if (more_than_skin && model_.sites.size() >= 4) MIEN_CHECK(add_blend(model_.neutral, model_.sites, model_.fixed, true, parts_));
        add_eyes(parts_);
        MIEN_CHECK(add_contacts(model_.neutral, parts_));
        if (options_.picture) MIEN_CHECK(add_picture(*options_.picture, parts_));
        return {};
    }

    /// The trained domain on the mesh as stored. Rounding may lose a texel at a border.
    Domain domain(const model::DomainMap& trained) {
        Domain out;
        if (trained.size() == 0) return out;
        coding::TexelMask mask{trained.width, trained.height, std::vector<std::uint8_t>(std::size_t(trained.width) * std::size_t(trained.height), 0)};
        std::vector<std::uint32_t> number(mask.set.size(), 0);
        for (std::uint32_t i = 0; i < trained.size(); ++i) mask.set[trained.place[i]] = 1, number[trained.place[i]] = i;
        out.map = model::detail_domain(out_.model, mask.width, mask.height, mask.set);
        std::fill(mask.set.begin(), mask.set.end(), std::uint8_t(0));
        for (const std::uint32_t place : out.map.place) mask.set[place] = 1, out.from.push_back(number[place]);
        for (std::uint32_t i = 0, rank = 0; i < mask.set.size(); ++i)
            if (mask.set[i]) number[i] = rank++;
        for (const std::uint32_t place : out.map.place) out.rank.push_back(number[place]);
        out.wavelet.emplace(mask);
        out.mask = parts_.list.add(BlobKind::texel_mask, coding::encode_mask(mask));
        return out;
    }

    void add_job(const char* name, LayerKind kind, const Domain& domain, const model::PolynomialMap& map, model::PolynomialMap& kept, double rms, int stages) {
        if (map.planes.empty() || domain.map.size() == 0) return;
        kept = model::PolynomialMap(map.channels, map.order, domain.map.size());
        for (int c = 0; c < map.channels; ++c)
            for (int k = 0; k < model::term_count(map.order); ++k)
                for (std::size_t i = 0; i < kept.texels; ++i) kept.plane(c, k)[i] = map.plane(c, k)[domain.from[i]];
        LayerJob& job = jobs_.emplace_back(LayerJob{name, kind, &domain, std::nullopt, rms, stages, std::nullopt});
        job.planes.emplace(kept, domain.map, out_.model.marker_triangles, factors_, *domain.wavelet, domain.rank);
    }

    /// By how many octaves a map's step must grow for it to take `most` bytes, as its stages tell. A stage cuts off what coding to its step
    /// rounds, and so is like one about half an octave coarser.
    static double octaves_for(const DetailPlanes::Coded& coded, std::size_t most) {
        double bytes = double(encoder::bytes_of(coded)), octaves = 0.5;
        for (std::size_t stage = coded.stages.size(); stage-- > 1; octaves += 1) {
            const double less = bytes - double(coded.stages[stage].coded.size() + 34);
            if (less <= double(most)) return octaves + std::log(bytes / double(most)) / std::log(bytes / less);
            bytes = less;
        }
        return octaves;
    }

    /// Grows a layer's step until its map takes at most `most` bytes and hardly less, or the step is 256 times what was asked. Two
    /// are tried at a time: whatever the threads, the same.
    void keep_bytes(LayerJob& job, std::size_t most) {
        const auto excess = [&](const DetailPlanes::Coded& coded) { return std::log2(double(encoder::bytes_of(coded)) / double(most)); };
        if (excess(*job.coded) <= 0) return;
        struct Try {
            double octaves, excess;
        };
        Try low{0, excess(*job.coded)};   // too many bytes
        std::optional<Try> high;          // few enough: job.coded
        const double step = double(job.coded->head.step), guess = octaves_for(*job.coded, most);
        double next[2] = {std::max(0.05, guess - 0.1), guess + 0.1};
        for (int round = 0; low.octaves < kCoarsest && (!high || (round < kSearchPairs && high->excess < -kSlack)); ++round) {
            DetailPlanes::Coded coded[2];
            for (double& octaves : next) octaves = std::min(octaves, kCoarsest);
            // A stage less for each octave: the first one says no less then.
            parallel_for(2, [&](std::int64_t i) { coded[i] = job.planes->code(float(std::exp2(next[i]) * step), std::max(1, job.stages - int(std::lround(next[i])))); });
            for (int i = 0; i < 2; ++i) {
                const Try tried{next[i], excess(coded[i])};
                const bool fits = tried.excess <= 0 || tried.octaves == kCoarsest;
                if (!fits && tried.octaves > low.octaves) low = tried;
                if (fits && (!high || tried.octaves < high->octaves)) {
                    high = tried;
                    job.coded = std::move(coded[i]);
                }
            }
            if (high) {
                // Bytes fall about evenly with octaves between the two.
                const double slope = (high->octaves - low.octaves) / (low.excess - high->excess);
                next[0] = low.octaves + slope * (low.excess + kSlack / 4);
                next[1] = low.octaves + slope * (low.excess + kSlack * 3 / 4);
            } else {
                next[0] = low.octaves + 0.4;
                next[1] = low.octaves + 1.2;
            }
        }
        job.stages = int(job.coded->stages.size());
        job.rms = job.planes->error(job.coded->head.step);
    }

    /// Keeps the bounds of shape and of all maps.
    void keep_map_bytes() {
        if (options_.most_shape_bytes == 0 && options_.most_map_bytes == 0) return;
        CodedMaps coded = code_maps_at(1);
        std::size_t shape = 0, all = 0;
        for (std::size_t j = 0; j < jobs_.size(); ++j) {
            LayerJob& job = jobs_[j];
            job.coded = std::move(coded[j]);
            const auto rest = [](std::size_t most, std::size_t taken) { return most > taken ? most - taken : 1; };
            std::size_t most = std::numeric_limits<std::size_t>::max();
            if (job.kind != LayerKind::albedo_map && options_.most_shape_bytes > 0)
                most = job.kind == LayerKind::medium ? options_.most_shape_bytes / 2 : rest(options_.most_shape_bytes, shape);
            if (options_.most_map_bytes > 0) most = std::min(most, rest(options_.most_map_bytes, all));
            keep_bytes(job, most);
            all += encoder::bytes_of(*job.coded);
            if (job.kind != LayerKind::albedo_map) shape += encoder::bytes_of(*job.coded);
        }
    }

    /// All maps at `scale` times their asked errors.
    CodedMaps code_maps_at(double scale) const {
        if (options_.progress) options_.progress("coding the maps", 0, 0);
        CodedMaps coded(jobs_.size());
        parallel_for(std::int64_t(jobs_.size()), [&](std::int64_t j) {
            const LayerJob& job = jobs_[std::size_t(j)];
            if (scale == 1 && job.coded) {
                coded[std::size_t(j)] = *job.coded;
                return;
            }
            coded[std::size_t(j)] = job.planes->code(job.planes->step_for(scale * job.rms), job.stages);
        });
        return coded;
    }

    Result<CodedMaps> code_maps() {
        CodedMaps best = code_maps_at(1);
        if (options_.most_bytes == 0) return best;
        const auto size = [&](const CodedMaps& maps) {
            const Stored stored = store(maps);
            return model_file(stored.manifest, stored.blobs, options_.name).size();
        };
        const auto fits = [&](const CodedMaps& maps) { return size(maps) <= options_.most_bytes; };
        if (fits(best)) return best;
        double low = 0, high = 6;  // log2 of the scale
        best = code_maps_at(std::exp2(high));
        if (const std::size_t least = size(best); least > options_.most_bytes)
            return Error{ErrorCode::invalid, fmt::format("the model cannot be stored in {} bytes: its maps at their coarsest, it takes {}", options_.most_bytes, least)};
        for (int i = 0; i < kSearch; ++i) {
            const double middle = (low + high) / 2;
            CodedMaps maps = code_maps_at(std::exp2(middle));
            if (fits(maps)) {
                best = std::move(maps);
                high = middle;
            } else {
                low = middle;
            }
        }
        return best;
    }

    struct Stored {
        Hash manifest;
        std::vector<protocol::StaticBlob> blobs;
    };
    /// All blobs of the model, with these maps: every layer's first stage, then stage by stage what refines them: the order of fetching.
    Stored store(const CodedMaps& coded) const {
        protocol::Manifest manifest = parts_.manifest;
        BlobList list = parts_.list;
        std::vector<std::vector<Hash>> of_layer(jobs_.size());
        for (std::size_t l = 0; l < jobs_.size(); ++l)
            of_layer[l] = {jobs_[l].domain->mask, list.add(BlobKind::detail_map, coding::encode_map(coded[l].head, coded[l].stages[0]))};
        for (int stage = 1; stage < coding::kMaxStages; ++stage)
            for (std::size_t l = 0; l < jobs_.size(); ++l)
                if (stage < jobs_[l].stages) of_layer[l].push_back(list.add(BlobKind::refinement, coding::encode_refinement(stage, coded[l].stages[std::size_t(stage)])));
        for (std::size_t l = 0; l < jobs_.size(); ++l) manifest.layers.push_back({jobs_[l].kind, std::move(of_layer[l])});
        const Bytes bytes = protocol::encode_manifest(manifest);
        Stored stored{sha256(bytes), std::move(list.blobs())};
        stored.blobs.insert(stored.blobs.begin(), {stored.manifest, BlobKind::manifest, bytes});
        return stored;
    }

    void tell_of(const CodedMaps& coded) {
        for (std::size_t l = 0; l < jobs_.size(); ++l) {
            out_.layers.push_back({jobs_[l].name, jobs_[l].planes->error(coded[l].head.step), {}});
            for (const auto& stage : coded[l].stages) out_.layers.back().stage_bytes.push_back(stage.coded.size());
        }
    }

    const model::DetailModel& model_;
    const model::TermMoments& moments_;
    const DetailOptions& options_;
    ModelParts parts_;
    model::TermFactors factors_;
    std::vector<LayerJob> jobs_;
    EncodedDetail out_;
};

}  // namespace

DetailOptions detail_options(double fine_error) {
    DetailOptions options;
    const double fine = std::clamp(fine_error, kLeastFine, options.fine);
    options.fine_stages = options.stages + int(std::lround(std::log2(options.fine / fine)));
    options.fine = fine;
    options.most_shape_bytes = 200'000;
    options.most_map_bytes = 800'000;
    return options;
}

Result<EncodedDetail> encode_detail(const model::DetailModel& model, const model::TermMoments& moments, const std::string& actor, const DetailOptions& options) {
    assert(moments.rows() == Eigen::Index(model.sites.size()) && options.stages >= 1 && options.stages <= coding::kMaxStages);
    assert(options.fine_stages >= 0 && options.fine_stages <= coding::kMaxStages);
    assert(options.medium > 0 && options.fine > 0 && options.albedo > 0);
    return DetailPacker(model, moments, options).run(actor);
}

Bytes model_file(const Hash& manifest, const std::vector<protocol::StaticBlob>& blobs, const std::string& name) {
    protocol::StreamHeader header;
    header.name = name;
    header.model = manifest;
    Bytes file;
    protocol::StreamFileWriter writer([&](ByteView bytes) { file.insert(file.end(), bytes.begin(), bytes.end()); }, header, blobs);
    writer.finish();
    return file;
}

}  // namespace mien::encoder
