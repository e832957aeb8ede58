#include "decoder/detail_decoder.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <optional>

#include "coding/texel_mask.hpp"
#include "core/parallel.hpp"
#include "decoder/detail_layer.hpp"
#include "decoder/detail_limits.hpp"
#include "decoder/mesh_blobs.hpp"
#include "protocol/messages.hpp"
#include "protocol/stream_file.hpp"

namespace mien::decoder {

using protocol::Layer;
using protocol::LayerKind;

namespace {

Error damaged(const std::string& what) { return {ErrorCode::damaged, "the " + what}; }

constexpr const char* kMisplaced = "model manifest's layers do not build on each other";

}  // namespace

class DetailDecoder::Unpacker {
public:
    Result<void> open(const Hash& manifest_hash, const FindBlob& find) {
        MIEN_TRY(bytes, needed_blob(find, manifest_hash));
        MIEN_TRY(manifest, protocol::parse_manifest(*bytes));
        for (const Layer& layer : manifest.layers) MIEN_CHECK(add(layer, find));
        if (factors_.terms == 0) return Error{ErrorCode::invalid, "the model has no marker domain, so it has no detail"};
        return {};
    }

    Result<Changed> update(const FindBlob& find) {
        std::array<std::vector<coding::MapStage>, 3> stages;
        for (Slot& slot : slots_) {
            auto& fresh = stages[std::size_t(&slot - slots_.data())];
            if (!slot.begun) MIEN_CHECK(begin(slot, find, fresh));
            if (!slot.begun) continue;
            for (std::size_t stage = std::size_t(slot.begun->stages()) + fresh.size(); stage + 1 < slot.layer.blobs.size(); ++stage) {
                const Bytes* bytes = find(slot.layer.blobs[stage + 1]);
                if (!bytes) break;
                MIEN_TRY(refinement, coding::decode_refinement(*bytes, int(stage)));
                fresh.push_back(std::move(refinement));
            }
        }
        std::array<std::optional<Error>, 3> errors;
        std::array<std::optional<model::PolynomialMap>, 3> maps;
        parallel_for(3, [&](std::int64_t s) {
            auto done = take(slots_[std::size_t(s)], stages[std::size_t(s)]);
            if (!done.ok()) errors[std::size_t(s)] = done.error();
            else maps[std::size_t(s)] = std::move(*done);
        });
        for (const auto& error : errors)
            if (error) return *error;
        for (std::size_t s = 0; s < 3; ++s)
            if (maps[s]) {
                model_.*slots_[s].map = std::move(*maps[s]);
                model_.*slots_[s].domain = slots_[s].begun->domain().map;
            }
        return Changed{maps[0].has_value(), maps[1].has_value(), maps[2].has_value()};
    }

    bool complete() const {
        return std::all_of(slots_.begin(), slots_.end(), [](const Slot& slot) { return slot.layer.blobs.empty() || (slot.begun && slot.begun->complete()); });
    }
    model::DetailModel& model() { return model_; }

private:
    struct Slot {
        const char* name;
        LayerKind kind;
        int channels;
        model::PolynomialMap model::DetailModel::* map;
        model::DomainMap model::DetailModel::* domain;
        Layer layer{};
        std::optional<DetailLayer> begun{};
    };

    Result<void> add(const Layer& layer, const FindBlob& find) {
        if (seen_[std::size_t(layer.kind)] && (layer.kind == LayerKind::shape || (layer.kind >= LayerKind::thin_shell && layer.kind != LayerKind::lid))) return damaged(kMisplaced);
        seen_[std::size_t(layer.kind)] = true;
        switch (layer.kind) {
            case LayerKind::shape: {
                MIEN_TRY(mesh, mesh_of(find, layer));
                model_.neutral = std::move(mesh);
                return {};
            }
            case LayerKind::thin_shell: return add_shell(layer, find);
            case LayerKind::marker_domain: return add_marker_domain(layer, find);
            case LayerKind::medium:
            case LayerKind::fine:
            case LayerKind::albedo_map:
                if (factors_.terms == 0) return damaged(kMisplaced);
                if (layer.blobs.size() < 2) return damaged("model manifest names too few blobs for a layer");
                std::find_if(slots_.begin(), slots_.end(), [&](const Slot& slot) { return slot.kind == layer.kind; })->layer = layer;
                return {};
            default: return {};
        }
    }

    Result<void> add_shell(const Layer& layer, const FindBlob& find) {
        if (!model_.neutral.has_texcoords()) return damaged(kMisplaced);
        MIEN_TRY(bytes, needed_blob(find, layer, 0));
        MIEN_TRY(shell, coding::decode_shell(*bytes, model_.neutral.vertex_count()));
        MIEN_CHECK(check_skin(model_.neutral, shell.sites.size()));
        model_.sites = std::move(shell.sites);
        model_.fixed = std::move(shell.fixed);
        return {};
    }

    Result<void> add_marker_domain(const Layer& layer, const FindBlob& find) {
        if (model_.sites.empty()) return damaged(kMisplaced);
        MIEN_TRY(bytes, needed_blob(find, layer, 0));
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
        model_.axes.extents = Eigen::Map<const Eigen::VectorXf>(markers.extents.data(), Eigen::Index(markers.extents.size()));
        model_.marker_triangles = std::move(markers.triangles);
        factors_ = {markers.terms, std::move(markers.factors)};
        return {};
    }

    /// The mask blob's texels, found once for all layers that share it; `planes` over it are in so many bytes.
    Result<std::shared_ptr<const DetailDomain>> domain(const Hash& hash, const Bytes& bytes, int planes, std::size_t plane_bytes) {
        const auto refuse = [&](std::uint64_t texels) { return !plausible(texels * std::uint64_t(planes), plane_bytes); };
        const Error too_large{ErrorCode::limit_exceeded, "a detail map announces more coefficients than it can hold"};
        if (const auto known = domains_.find(hash); known != domains_.end()) {
            if (refuse(known->second->texels)) return too_large;
            return known->second;
        }
        MIEN_TRY(mask, coding::decode_mask(bytes));
        auto out = std::make_shared<DetailDomain>();
        std::vector<std::uint32_t> number(mask.set.size());
        for (std::size_t i = 0; i < mask.set.size(); ++i)
            if (mask.set[i]) number[i] = out->texels++;
        if (refuse(out->texels)) return too_large;
        MIEN_CHECK(check_domain(model_.neutral, model_.marker_triangles, model_.sites.size(), mask.width, mask.height, out->texels));
        out->map = model::detail_domain(model_, mask.width, mask.height, mask.set);
        for (const std::uint32_t place : out->map.place) out->rank.push_back(number[place]);
        out->wavelet.emplace(mask);
        domains_[hash] = out;
        return std::shared_ptr<const DetailDomain>(std::move(out));
    }

    /// Begins a map whose mask and first stage are there.
    Result<void> begin(Slot& slot, const FindBlob& find, std::vector<coding::MapStage>& stages) {
        if (slot.layer.blobs.empty()) return {};
        const Bytes *mask_bytes = find(slot.layer.blobs[0]), *map_bytes = find(slot.layer.blobs[1]);
        if (!mask_bytes || !map_bytes) return {};
        MIEN_TRY(coded, coding::decode_map(*map_bytes));
        const int terms = model::term_count(model::PolynomialOrder(coded.head.order));
        if (coded.head.channels != slot.channels || terms > factors_.terms || slot.layer.blobs.size() > 1 + std::size_t(coded.head.stages))
            return damaged(std::string(slot.name) + " map does not fit the model");
        for (const Slot& other : slots_)
            if (other.domain == slot.domain && !other.layer.blobs.empty() && other.layer.blobs[0] != slot.layer.blobs[0]) return damaged("fine and albedo maps cover different texels");
        MIEN_TRY(on, domain(slot.layer.blobs[0], *mask_bytes, slot.channels * terms, coded.first.coded.size()));
        slot.begun.emplace(slot.name, std::move(on), coded.head);
        stages.push_back(std::move(coded.first));
        return {};
    }

    /// The map with more stages; none when there are none.
    Result<std::optional<model::PolynomialMap>> take(Slot& slot, const std::vector<coding::MapStage>& stages) const {
        if (stages.empty()) return std::optional<model::PolynomialMap>{};
        for (const coding::MapStage& stage : stages) MIEN_CHECK(slot.begun->take(stage));
        MIEN_TRY(map, slot.begun->map(model_.marker_triangles, factors_));
        return std::optional<model::PolynomialMap>{std::move(map)};
    }

    model::DetailModel model_;
    model::TermFactors factors_;
    std::array<bool, 256> seen_{};  // layers of each kind
    std::map<Hash, std::shared_ptr<const DetailDomain>> domains_;
    std::array<Slot, 3> slots_ = {{{"medium", LayerKind::medium, 3, &model::DetailModel::medium, &model::DetailModel::medium_domain},
                                   {"fine", LayerKind::fine, 1, &model::DetailModel::fine, &model::DetailModel::fine_domain},
                                   {"albedo", LayerKind::albedo_map, 3, &model::DetailModel::albedo, &model::DetailModel::fine_domain}}};
};

DetailDecoder::DetailDecoder(std::unique_ptr<Unpacker> unpacker) : unpacker_(std::move(unpacker)) {}
DetailDecoder::DetailDecoder(DetailDecoder&&) noexcept = default;
DetailDecoder& DetailDecoder::operator=(DetailDecoder&&) noexcept = default;
DetailDecoder::~DetailDecoder() = default;

Result<DetailDecoder> DetailDecoder::open(const Hash& manifest, const FindBlob& find) {
    auto unpacker = std::make_unique<Unpacker>();
    MIEN_CHECK(unpacker->open(manifest, find));
    return DetailDecoder(std::move(unpacker));
}

Result<DetailDecoder::Changed> DetailDecoder::update(const FindBlob& find) { return unpacker_->update(find); }
bool DetailDecoder::complete() const { return unpacker_->complete(); }
const model::DetailModel& DetailDecoder::model() const { return unpacker_->model(); }
model::DetailModel DetailDecoder::take() { return std::move(unpacker_->model()); }

Result<model::DetailModel> decode_detail(const Hash& manifest, const FindBlob& find) {
    MIEN_TRY(decoder, DetailDecoder::open(manifest, find));
    MIEN_CHECK(decoder.update(find));
    return decoder.take();
}

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
