#include "encoder/model_remap.hpp"

#include <algorithm>
#include <set>

#include "coding/detail_code.hpp"
#include "encoder/head_layers.hpp"
#include "protocol/messages.hpp"

namespace mien::encoder {

using protocol::BlobKind;
using protocol::Layer;
using protocol::LayerKind;

Result<EncodedModel> remap_markers(const EncodedModel& model, const std::vector<Site>& sites, PointsRef rest) {
    const auto refuse = [](const std::string& why) { return Error{ErrorCode::invalid, "the model cannot be driven by these markers: " + why}; };
    const auto* shell = std::get_if<model::ShellBase>(&model.model.base);
    if (!shell || !model.model.detail) return refuse("it has no thin shell; only models of mien train do");
    if (sites.size() < 4 || sites.size() > coding::kMaxDetailMarkers) return refuse("there must be 4 to 4096");
    if (rest.rows() != Eigen::Index(sites.size())) return refuse("not every one has a place");
    coding::DrivingMarkers driving{sites, rest};
    for (std::size_t m = 0; m < sites.size(); ++m) driving.rest_offsets.row(Eigen::Index(m)) -= sites[m].position(model.model.neutral.positions).transpose();
    if (!driving.rest_offsets.allFinite() || driving.rest_offsets.cwiseAbs().maxCoeff() > coding::kMaxRestOffset) return refuse("one lies more than 100 mm from the face");

    const auto blob_of = [&](const Hash& hash) -> const protocol::StaticBlob& {
        return *std::find_if(model.blobs.begin(), model.blobs.end(), [&](const auto& blob) { return blob.hash == hash; });
    };
    MIEN_TRY(manifest, protocol::parse_manifest(blob_of(model.manifest).bytes));
    ModelParts parts;
    parts.manifest.actor = manifest.actor;
    parts.model.neutral = model.model.neutral;
    const std::vector<std::uint32_t>& fixed = model.model.detail->model().fixed;
    for (Layer& layer : manifest.layers) {
        if (layer.kind == LayerKind::blend) {
            MIEN_CHECK(add_blend(parts.model.neutral, sites, fixed, true, parts));
            continue;
        }
        if (layer.kind == LayerKind::thin_shell) {
            layer.blobs.resize(1);
            layer.blobs.push_back(parts.list.add(BlobKind::driving_markers, coding::encode_driving_markers(driving)));
        }
        parts.manifest.layers.push_back(std::move(layer));
    }

    // Fetching order: manifest, what is new (it forms the shape), then what the model had, less what it no longer names.
    EncodedModel out;
    const Bytes bytes = protocol::encode_manifest(parts.manifest);
    out.manifest = sha256(bytes);
    out.blobs.push_back({out.manifest, BlobKind::manifest, bytes});
    for (protocol::StaticBlob& blob : parts.list.blobs()) out.blobs.push_back(std::move(blob));
    std::set<Hash> named;
    for (const Layer& layer : parts.manifest.layers) named.insert(layer.blobs.begin(), layer.blobs.end());
    for (const protocol::StaticBlob& blob : model.blobs)
        if (named.contains(blob.hash) && std::none_of(out.blobs.begin(), out.blobs.end(), [&](const auto& b) { return b.hash == blob.hash; })) out.blobs.push_back(blob);

    // As a decoder will have it.
    out.model = model.model;
    MIEN_TRY(stored, coding::decode_driving_markers(coding::encode_driving_markers(driving), out.model.neutral.vertex_count()));
    out.model.base = model::make_shell_base(out.model.neutral, std::move(stored.sites), stored.rest_offsets, fixed, std::get_if<model::BlendBase>(&parts.model.base));
    return out;
}

}  // namespace mien::encoder
