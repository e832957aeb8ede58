#include "decoder/model_decoder.hpp"

#include <optional>

#include "coding/detail_code.hpp"
#include "coding/layer_code.hpp"
#include "decoder/detail_decoder.hpp"
#include "decoder/detail_limits.hpp"
#include "decoder/mesh_blobs.hpp"
#include "protocol/messages.hpp"

namespace mien::decoder {
namespace {

using protocol::Layer;
using protocol::LayerKind;

class Unpacker {
public:
    Unpacker(const FindBlob& find, std::unique_ptr<DetailDecoder>* growing) : find_(find), growing_(growing) {}

    Result<model::FaceModel> run(const Hash& manifest_hash) {
        MIEN_TRY(bytes, needed_blob(find_, manifest_hash));
        MIEN_TRY(manifest, protocol::parse_manifest(*bytes));
        model_.actor = manifest.actor;
        for (const Layer& layer : manifest.layers) MIEN_CHECK(add(layer));
        if (detailed_) {
            MIEN_TRY(detail, decode_maps(manifest_hash));
            if (shell_ && (!has_base_ || std::holds_alternative<model::BlendBase>(model_.base))) {
                MIEN_TRY(driving, driving_markers(detail));
                const auto* beside = std::get_if<model::BlendBase>(&model_.base);
                if (beside && beside->sites.size() != driving.sites.size())
                    return Error{ErrorCode::damaged, "the model's blend coefficients and its thin shell have other markers"};
                model_.base = model::make_shell_base(detail.neutral, std::move(driving.sites), driving.rest_offsets, detail.fixed, beside);
            }
            model_.detail = std::make_shared<model::DetailLayers>(std::move(detail));
        } else if (shell_) {
            return Error{ErrorCode::damaged, "the model manifest has a thin shell without its marker domain"};
        }
        for (model::Lid& lid : lids_) model::add_lid(model_, std::move(lid));
        return std::move(model_);
    }

private:
    Result<const Bytes*> blob(const Layer& layer, std::size_t i) const { return needed_blob(find_, layer, i); }

    Result<model::DetailModel> decode_maps(const Hash& manifest_hash) const {
        MIEN_TRY(decoder, DetailDecoder::open(manifest_hash, find_));
        MIEN_CHECK(decoder.update(find_));
        if (!growing_ || decoder.complete()) return decoder.take();
        *growing_ = std::make_unique<DetailDecoder>(std::move(decoder));
        return (*growing_)->model();
    }

    /// Those of the detail model, or others that were put in their place.
    Result<coding::DrivingMarkers> driving_markers(const model::DetailModel& detail) const {
        if (shell_->blobs.size() < 2) return coding::DrivingMarkers{detail.sites, Points::Zero(Eigen::Index(detail.sites.size()), 3)};
        MIEN_TRY(bytes, blob(*shell_, 1));
        MIEN_TRY(markers, coding::decode_driving_markers(*bytes, detail.neutral.vertex_count()));
        MIEN_CHECK(check_skin(detail.neutral, markers.sites.size()));
        return markers;
    }

    /// Layers build on those before them: one shape, then at most one base shape, then what lies on it.
    Result<void> place(LayerKind kind) {
        const bool shape = kind == LayerKind::shape;
        const bool base = kind == LayerKind::vertex_basis || kind == LayerKind::blend || kind == LayerKind::blendshapes || kind == LayerKind::points;
        const bool mesh_wanted = kind == LayerKind::vertex_basis || kind == LayerKind::blend || kind == LayerKind::eyes || kind == LayerKind::contact ||
                                 kind == LayerKind::lid;
        if ((shape && (has_shape_ || has_base_)) || (base && has_base_) || (kind == LayerKind::points && has_shape_) || (mesh_wanted && !has_shape_) ||
            (kind == LayerKind::contact && model_.contacts.size() == kMostSlits) || (kind == LayerKind::lid && lids_.size() == kMostSlits))
            return Error{ErrorCode::damaged, "the model manifest's layers do not build on each other"};
        has_shape_ |= shape;
        has_base_ |= base;
        return {};
    }

    Result<void> add(const Layer& layer) {
        MIEN_CHECK(place(layer.kind));
        const std::uint32_t V = model_.neutral.vertex_count();
        switch (layer.kind) {
            case LayerKind::shape: {
                MIEN_TRY(mesh, mesh_of(find_, layer));
                model_.neutral = std::move(mesh);
                break;
            }
            case LayerKind::vertex_basis: model_.base = model::VertexBase{}; break;
            case LayerKind::blend: {
                MIEN_TRY(bytes, blob(layer, 0));
                MIEN_TRY(stored, coding::decode_blend(*bytes, V));
                model::BlendBase base;
                base.markers.resize(Eigen::Index(stored.sites.size()), 3);
                for (std::size_t m = 0; m < stored.sites.size(); ++m)
                    base.markers.row(Eigen::Index(m)) = stored.sites[m].position(model_.neutral.positions).transpose();
                base.sites = std::move(stored.sites);
                base.row_start = std::move(stored.rows.row_start);
                for (const auto& term : stored.rows.terms) base.terms.push_back({term.column, term.share});
                model_.base = std::move(base);
                break;
            }
            case LayerKind::blendshapes: {
                model::BlendshapeBase base;
                if (!layer.blobs.empty()) {
                    MIEN_TRY(bytes, blob(layer, 0));
                    MIEN_TRY(targets, coding::decode_blendshapes(*bytes, V, model_.neutral.triangles));
                    base.targets = std::move(targets);
                }
                model_.base = std::move(base);
                break;
            }
            case LayerKind::points: {
                MIEN_TRY(mesh, mesh_of(find_, layer));
                model_.base = model::PointBase{std::move(mesh.positions), std::move(mesh.triangles)};
                break;
            }
            case LayerKind::eyes: {
                MIEN_TRY(bytes, blob(layer, 0));
                MIEN_TRY(eyes, coding::decode_eyes(*bytes, V));
                for (std::size_t side = 0; side < 2; ++side)
                    if (eyes[side]) model_.eyes[side] = model::Eyeball{eyes[side]->centre, eyes[side]->vertices};
                break;
            }
            case LayerKind::contact: {
                MIEN_TRY(bytes, blob(layer, 0));
                MIEN_TRY(stored, coding::decode_contact(*bytes, V));
                auto& contact = model_.contacts.emplace_back();
                contact.pairs = std::move(stored.pairs);
                for (const auto& member : stored.members) contact.members.push_back({member.vertex, member.hold});
                break;
            }
            case LayerKind::lid: {
                MIEN_TRY(bytes, blob(layer, 0));
                MIEN_TRY(stored, coding::decode_lid(*bytes, V));
                auto& lid = lids_.emplace_back(model::Lid{stored.centre, {}});
                in_lid_.resize(V, false);
                for (const auto& member : stored.members) {
                    if (in_lid_[member.vertex]) return Error{ErrorCode::damaged, "two lids of the model share a vertex"};
                    in_lid_[member.vertex] = true;
                    lid.members.push_back({member.vertex, member.share, member.weight, member.hold});
                }
                break;
            }
            case LayerKind::static_albedo:
                // Pictures need a codec: whoever has one unpacks layer.blobs[0] (decoder_av's decode_picture).
                MIEN_CHECK(blob(layer, 0));
                break;
            case LayerKind::video_albedo: model_.video_albedo = true; break;
            case LayerKind::thin_shell: shell_ = layer; break;
            case LayerKind::marker_domain: detailed_ = true; break;
            case LayerKind::medium:
            case LayerKind::fine:
            case LayerKind::albedo_map:
                break;  // of the detail model: decode_detail
        }
        return {};
    }

    static constexpr std::size_t kMostSlits = 8;  // contacts, and lids

    const FindBlob& find_;
    std::unique_ptr<DetailDecoder>* growing_;
    model::FaceModel model_;
    bool has_shape_ = false, has_base_ = false;
    std::vector<bool> in_lid_;      // V, or empty before the first lid
    std::vector<model::Lid> lids_;  // the base shape that they change may come last
    std::optional<Layer> shell_;   // the thin shell, when one was named
    bool detailed_ = false;        // a marker domain was named
};

}  // namespace

Result<model::FaceModel> decode_model(const Hash& manifest, const FindBlob& find, std::unique_ptr<DetailDecoder>* growing) {
    if (growing) growing->reset();
    return Unpacker(find, growing).run(manifest);
}

bool fits(const model::FaceModel& model, const protocol::MotionInfo& info) {
    using protocol::MotionKind;
    if (std::holds_alternative<model::VertexBase>(model.base))
        return info.kind == MotionKind::vertices && info.count == model.neutral.vertex_count();
    if (const Points* markers = model::driving_markers(model)) return info.kind == MotionKind::markers && Eigen::Index(info.count) == markers->rows();
    const auto& shapes = std::get<model::BlendshapeBase>(model.base);
    return info.kind == MotionKind::weights && (shapes.targets.empty() || shapes.targets.size() == info.count);
}

}  // namespace mien::decoder
