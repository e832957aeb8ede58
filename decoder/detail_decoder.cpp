#include "decoder/detail_decoder.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>

#include "coding/coefficient_planes.hpp"
#include "coding/detail_code.hpp"
#include "coding/texel_mask.hpp"
#include "core/parallel.hpp"
#include "decoder/mesh_blobs.hpp"
#include "model/term_basis.hpp"
#include "protocol/messages.hpp"
#include "protocol/stream_file.hpp"

namespace mien::decoder {
namespace {

using protocol::Layer;
using protocol::LayerKind;

constexpr std::uint64_t kMaxShellValues = 1u << 25;   // vertices x markers: 100 000 x 300
constexpr std::uint64_t kMaxMapValues = 1u << 26;     // texels x planes: 18 planes of a 2048 map that is two thirds full
constexpr std::uint64_t kValuesPerByte = 1u << 14;    // no zero costs less than 24 / 65536 of ln 2 bits
constexpr std::uint64_t kMaxPlaceSteps = 1u << 31;    // texels x marker triangles that each is looked for in

Error damaged(const char* what) { return {ErrorCode::damaged, std::string("the ") + what}; }

/// Bytes first, so that what a few of them announce is believed only as far as they reach.
bool plausible(std::uint64_t values, std::size_t bytes) { return values <= kMaxMapValues && values <= kValuesPerByte * (bytes + 64); }

class DetailUnpacker {
public:
    explicit DetailUnpacker(const FindBlob& find) : find_(find) {}

    Result<model::DetailModel> run(const Hash& manifest_hash) {
        MIEN_TRY(bytes, needed_blob(find_, manifest_hash));
        MIEN_TRY(manifest, protocol::parse_manifest(*bytes));
        for (const Layer& layer : manifest.layers) MIEN_CHECK(add(layer));
        if (factors_.terms == 0) return Error{ErrorCode::invalid, "the model has no marker domain, so it has no detail"};
        return std::move(model_);
    }

private:
    Result<void> add(const Layer& layer) {
        switch (layer.kind) {
            case LayerKind::shape: {
                if (model_.neutral.vertex_count() > 0) return damaged("model manifest has two shapes");
                MIEN_TRY(mesh, mesh_of(find_, layer));
                model_.neutral = std::move(mesh);
                return {};
            }
            case LayerKind::thin_shell: return add_shell(layer);
            case LayerKind::marker_domain: return add_marker_domain(layer);
            case LayerKind::medium: return add_map(layer, "medium", 3, model_.medium, model_.medium_domain);
            case LayerKind::fine: return add_map(layer, "fine", 1, model_.fine, model_.fine_domain);
            case LayerKind::albedo_map: return add_map(layer, "albedo", 3, model_.albedo, model_.fine_domain);
            default: return {};
        }
    }

    Result<void> add_shell(const Layer& layer) {
        if (!model_.neutral.has_texcoords() || !model_.sites.empty()) return damaged("model manifest's layers do not build on each other");
        MIEN_TRY(bytes, needed_blob(find_, layer, 0));
        const std::uint32_t V = model_.neutral.vertex_count();
        MIEN_TRY(shell, coding::decode_shell(*bytes, V));
        if (std::uint64_t(V) * shell.sites.size() > kMaxShellValues) return Error{ErrorCode::limit_exceeded, "the model has too many vertices for so many markers"};
        model_.sites = std::move(shell.sites);
        model_.fixed = std::move(shell.fixed);
        return {};
    }

    Result<void> add_marker_domain(const Layer& layer) {
        if (model_.sites.empty() || factors_.terms > 0) return damaged("model manifest's layers do not build on each other");
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
        // Triangles that lie within two edges of a marker, at most: what a texel is looked for in.
        std::vector<std::uint64_t> around(std::size_t(M), 0), near(std::size_t(M), 0);
        for (const Triangle& t : markers.triangles)
            for (const std::uint32_t corner : t) ++around[corner];
        for (const Triangle& t : markers.triangles)
            for (const std::uint32_t corner : t) near[corner] += around[t[0]] + around[t[1]] + around[t[2]];
        if (!near.empty()) places_ = *std::max_element(near.begin(), near.end());
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
        if (out.texels * places_ > kMaxPlaceSteps) return Error{ErrorCode::limit_exceeded, "the model's markers are joined too densely for so large a map"};
        out.map = model::detail_domain(model_, mask.width, mask.height, mask.set);
        for (const std::uint32_t place : out.map.place) out.rank.push_back(number[place]);
        out.mask = std::move(mask);
        return &domains_.emplace(hash, std::move(out)).first->second;
    }

    Result<void> add_map(const Layer& layer, const char* name, int channels, model::PolynomialMap& map, model::DomainMap& domain_map) {
        if (factors_.terms == 0 || map.texels > 0) return damaged("model manifest's layers do not build on each other");
        if (layer.blobs.size() < 2) return damaged("model manifest names too few blobs for a layer");
        const Bytes *mask_bytes = find_(layer.blobs[0]), *map_bytes = find_(layer.blobs[1]);
        if (!mask_bytes || !map_bytes) return {};
        MIEN_TRY(coded, coding::decode_map(*map_bytes));
        const auto order = model::PolynomialOrder(coded.head.order);
        const int terms = model::term_count(order);
        if (coded.head.channels != channels || terms > factors_.terms || layer.blobs.size() > 1 + std::size_t(coded.head.stages))
            return Error{ErrorCode::damaged, std::string("the ") + name + " map does not fit the model"};
        MIEN_TRY(on, domain(layer.blobs[0], *mask_bytes));
        if (domain_map.size() > 0 && domain_map.place != on->map.place) return damaged("fine and albedo maps cover different texels");
        const std::uint64_t planes = std::uint64_t(channels) * std::uint64_t(terms);
        if (!plausible(on->texels * planes, coded.first.coded.size())) return Error{ErrorCode::limit_exceeded, std::string("the ") + name + " map announces more texels than it can hold"};

        const coding::MaskedWavelet wavelet(on->mask);
        coding::CoefficientPlanes values(wavelet, int(planes));
        std::array<std::int8_t, 2> lift = coded.first.lift;
        if (!values.decode(coded.first.coded)) return Error{ErrorCode::damaged, std::string("the ") + name + " map does not decode"};
        int below = coded.head.stages - 1;
        for (std::size_t stage = 1; stage + 1 < layer.blobs.size(); ++stage) {
            const Bytes* bytes = find_(layer.blobs[stage + 1]);
            if (!bytes) break;
            MIEN_TRY(refinement, coding::decode_refinement(*bytes, int(stage)));
            if (!values.decode(refinement.coded)) return Error{ErrorCode::damaged, std::string("a refinement of the ") + name + " map does not decode"};
            lift = refinement.lift;
            --below;
        }
        map = floats(values, wavelet, coded.head, lift, below, *on);
        model::from_trained_basis(map, on->map, model_.marker_triangles, factors_);
        if (!std::all_of(map.planes.begin(), map.planes.end(), [](float c) { return std::isfinite(c); }))
            return Error{ErrorCode::damaged, std::string("the ") + name + " map is not finite"};
        domain_map = on->map;
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
    std::uint64_t places_ = 0;
    std::map<Hash, Domain> domains_;
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
