#include "decoder/detail_decoder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>

#include "coding/coefficient_planes.hpp"
#include "coding/detail_code.hpp"
#include "coding/texel_mask.hpp"
#include "core/parallel.hpp"
#include "decoder/detail_limits.hpp"
#include "decoder/mesh_blobs.hpp"
#include "model/term_basis.hpp"
#include "protocol/messages.hpp"
#include "protocol/stream_file.hpp"

namespace mien::decoder {
namespace {

using protocol::Layer;
using protocol::LayerKind;

Error damaged(const std::string& what) { return {ErrorCode::damaged, "the " + what}; }

constexpr const char* kMisplaced = "model manifest's layers do not build on each other";

class DetailUnpacker {
public:
    explicit DetailUnpacker(const FindBlob& find) : find_(find) {}

    Result<model::DetailModel> run(const Hash& manifest_hash) {
        MIEN_TRY(bytes, needed_blob(find_, manifest_hash));
        MIEN_TRY(manifest, protocol::parse_manifest(*bytes));
        for (const Layer& layer : manifest.layers) MIEN_CHECK(add(layer));
        if (factors_.terms == 0) return Error{ErrorCode::invalid, "the model has no marker domain, so it has no detail"};
        std::vector<std::optional<Error>> errors(jobs_.size());
        parallel_for(std::int64_t(jobs_.size()), [&](std::int64_t j) {
            if (auto done = unpack(jobs_[std::size_t(j)]); !done) errors[std::size_t(j)] = done.error();
        });
        for (const auto& error : errors)
            if (error) return *error;
        for (const Job& job : jobs_) (job.map == &model_.medium ? model_.medium_domain : model_.fine_domain) = job.domain->map;
        return std::move(model_);
    }

private:
    Result<void> add(const Layer& layer) {
        if (seen_[std::size_t(layer.kind)] && layer.kind >= LayerKind::thin_shell) return damaged(kMisplaced);
        seen_[std::size_t(layer.kind)] = true;
        switch (layer.kind) {
            case LayerKind::shape: {
                if (model_.neutral.vertex_count() > 0) return damaged(kMisplaced);
                MIEN_TRY(mesh, mesh_of(find_, layer));
                model_.neutral = std::move(mesh);
                return {};
            }
            case LayerKind::thin_shell: return add_shell(layer);
            case LayerKind::marker_domain: return add_marker_domain(layer);
            case LayerKind::medium: return add_map(layer, "medium", 3, model_.medium);
            case LayerKind::fine: return add_map(layer, "fine", 1, model_.fine);
            case LayerKind::albedo_map: return add_map(layer, "albedo", 3, model_.albedo);
            default: return {};
        }
    }

    Result<void> add_shell(const Layer& layer) {
        if (!model_.neutral.has_texcoords()) return damaged(kMisplaced);
        MIEN_TRY(bytes, needed_blob(find_, layer, 0));
        MIEN_TRY(shell, coding::decode_shell(*bytes, model_.neutral.vertex_count()));
        MIEN_CHECK(check_skin(model_.neutral, shell.sites.size()));
        model_.sites = std::move(shell.sites);
        model_.fixed = std::move(shell.fixed);
        return {};
    }

    Result<void> add_marker_domain(const Layer& layer) {
        if (model_.sites.empty()) return damaged(kMisplaced);
        MIEN_TRY(bytes, needed_blob(find_, layer, 0));
        const auto M = Eigen::Index(model_.sites.size());
        MIEN_TRY(markers, coding::decode_marker_domain(*bytes, std::uint32_t(M)));
        model_.reach = markers.reach;
        model_.axes.q.resize(M, model::kDeformationSize);
        model_.axes.r.resize(M, model::kDeformationSize);
        for (Eigen::Index m = 0; m < M; ++m)
            for (int k = 0; k < model::kDeformationSize; ++k) {
                model_.axes.q(m, k) = markers.axes[std::size_t(m)][std::size_t(k)];
                model_.axes.r(m, k) = markers.axes[std::size_t(m)][std::size_t(k + model::kDeformationSize)];
            }
        model_.marker_triangles = std::move(markers.triangles);
        factors_ = {markers.terms, std::move(markers.factors)};
        return {};
    }

    /// The mask blob's texels; rebuilt once for all layers that share it.
    struct Domain {
        coding::TexelMask mask;
        model::DomainMap map;
        std::uint32_t texels = 0;             // of the mask
        std::vector<std::uint32_t> rank;      // of the map's texels among the mask's
    };
    Result<const Domain*> domain(const Hash& hash, const Bytes& bytes) {
        if (const auto known = domains_.find(hash); known != domains_.end()) return &known->second;
        MIEN_TRY(mask, coding::decode_mask(bytes));
        Domain out;
        std::vector<std::uint32_t> number(mask.set.size());
        for (std::size_t i = 0; i < mask.set.size(); ++i)
            if (mask.set[i]) number[i] = out.texels++;
        MIEN_CHECK(check_domain(model_.neutral, model_.marker_triangles, model_.sites.size(), mask.width, mask.height, out.texels));
        out.map = model::detail_domain(model_, mask.width, mask.height, mask.set);
        for (const std::uint32_t place : out.map.place) out.rank.push_back(number[place]);
        out.mask = std::move(mask);
        return &domains_.emplace(hash, std::move(out)).first->second;
    }

    /// A map whose head has been checked.
    struct Job {
        const char* name;
        const Domain* domain;
        coding::CodedMap coded;
        std::vector<coding::MapStage> refinements;
        model::PolynomialMap* map;
    };

    Result<void> add_map(const Layer& layer, const char* name, int channels, model::PolynomialMap& map) {
        if (factors_.terms == 0) return damaged(kMisplaced);
        if (layer.blobs.size() < 2) return damaged("model manifest names too few blobs for a layer");
        const Bytes *mask_bytes = find_(layer.blobs[0]), *map_bytes = find_(layer.blobs[1]);
        if (!mask_bytes || !map_bytes) return {};
        MIEN_TRY(coded, coding::decode_map(*map_bytes));
        const int terms = model::term_count(model::PolynomialOrder(coded.head.order));
        if (coded.head.channels != channels || terms > factors_.terms || layer.blobs.size() > 1 + std::size_t(coded.head.stages))
            return damaged(std::string(name) + " map does not fit the model");
        MIEN_TRY(on, domain(layer.blobs[0], *mask_bytes));
        for (const Job& job : jobs_)
            if (job.map == &model_.fine && &map == &model_.albedo && job.domain != on) return damaged("fine and albedo maps cover different texels");
        if (!plausible(std::uint64_t(on->texels) * std::uint64_t(channels * terms), coded.first.coded.size()))
            return Error{ErrorCode::limit_exceeded, std::string("the ") + name + " map announces more coefficients than it can hold"};
        Job job{name, on, std::move(coded), {}, &map};
        for (std::size_t stage = 1; stage + 1 < layer.blobs.size(); ++stage) {
            const Bytes* bytes = find_(layer.blobs[stage + 1]);
            if (!bytes) break;
            MIEN_TRY(refinement, coding::decode_refinement(*bytes, int(stage)));
            job.refinements.push_back(std::move(refinement));
        }
        jobs_.push_back(std::move(job));
        return {};
    }

    Result<void> unpack(const Job& job) const {
        const coding::MapHead& head = job.coded.head;
        const coding::MaskedWavelet wavelet(job.domain->mask);
        coding::CoefficientPlanes values(wavelet, head.channels * model::term_count(model::PolynomialOrder(head.order)));
        if (!values.decode(job.coded.first.coded)) return damaged(std::string(job.name) + " map does not decode");
        for (const coding::MapStage& refinement : job.refinements)
            if (!values.decode(refinement.coded)) return damaged(std::string("refinement of the ") + job.name + " map does not decode");
        const coding::MapStage& last = job.refinements.empty() ? job.coded.first : job.refinements.back();
        *job.map = floats(values, wavelet, head, last.lift, head.stages - 1 - int(job.refinements.size()), *job.domain);
        model::from_trained_basis(*job.map, job.domain->map, model_.marker_triangles, factors_);
        if (!std::all_of(job.map->planes.begin(), job.map->planes.end(), [](float c) { return std::isfinite(c); })) return damaged(std::string(job.name) + " map is not finite");
        return {};
    }

    /// Integers to coefficients in the trained basis.
    static model::PolynomialMap floats(const coding::CoefficientPlanes& values, const coding::MaskedWavelet& wavelet, const coding::MapHead& head, const std::array<std::int8_t, 2>& lift,
                                       int below, const Domain& on) {
        const auto order = model::PolynomialOrder(head.order);
        const int terms = model::term_count(order);
        const float unit = std::ldexp(head.step, below);
        std::vector<std::vector<float>> samples(static_cast<std::size_t>(values.planes()));
        parallel_for(values.planes(), [&](std::int64_t p) {
            std::vector<float> coefficients(wavelet.size());
            const std::int32_t* plane = values.plane(int(p));
            for (std::size_t i = 0; i < coefficients.size(); ++i) {
                if (plane[i] == 0) continue;
                const int magnitude = std::abs(plane[i]);
                const float size = unit * (float(magnitude) + float(lift[magnitude > 1]) / 128);
                coefficients[i] = plane[i] < 0 ? -size : size;
            }
            samples[std::size_t(p)].resize(wavelet.size());
            wavelet.inverse(coefficients.data(), samples[std::size_t(p)].data());
        });
        model::PolynomialMap map(head.channels, order, on.map.size());
        parallel_for(map.channels * terms, [&](std::int64_t p) {
            const int channel = int(p) / terms, k = int(p) % terms;
            float* out = map.plane(channel, k);
            for (int c = 0; c < map.channels; ++c) {
                // Transposed: from the coded channels back to the map's.
                const float turn = map.channels == 3 ? float(head.rotation[std::size_t(3 * c + channel)]) / (1 << 14) : 1.0f;
                const std::vector<float>& from = samples[std::size_t(c * terms + k)];
                for (std::size_t i = 0; i < map.texels; ++i) out[i] += turn * from[on.rank[i]];
            }
        });
        return map;
    }

    const FindBlob& find_;
    model::DetailModel model_;
    model::TermFactors factors_;
    std::array<bool, 256> seen_{};  // layers of each kind
    std::map<Hash, Domain> domains_;
    std::vector<Job> jobs_;
};

}  // namespace

Result<model::DetailModel> decode_detail(const Hash& manifest, const FindBlob& find) { return DetailUnpacker(find).run(manifest); }

Result<model::DetailModel> decode_detail_file(ByteView file) {
    MIEN_TRY(reader, protocol::StreamFileReader::open(
                         [file](std::uint64_t offset, std::span<std::byte> into) -> Result<std::size_t> {
                             const std::size_t size = offset < file.size() ? std::min<std::size_t>(into.size(), file.size() - offset) : 0;
                             if (size > 0) std::memcpy(into.data(), file.data() + offset, size);
                             return size;
                         },
                         file.size()));
    std::map<Hash, Bytes> blobs;
    std::optional<Error> trouble;
    auto model = decode_detail(reader.header().model, [&](const Hash& hash) -> const Bytes* {
        if (const auto known = blobs.find(hash); known != blobs.end()) return &known->second;
        auto bytes = reader.blob(hash);
        if (!bytes) {
            if (bytes.error().code != ErrorCode::missing) trouble = bytes.error();
            return nullptr;
        }
        return &(blobs[hash] = std::move(*bytes));
    });
    if (trouble) return *trouble;
    return model;
}

}  // namespace mien::decoder
