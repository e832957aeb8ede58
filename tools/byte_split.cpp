#include "tools/byte_split.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace mien::tools {
namespace {

using protocol::BlobKind;
using protocol::LayerKind;
using protocol::TrackKind;

/// Shares of coefficients and pose in the motion objects, by ideal code lengths of a decode.
Result<double> pose_share(const StoredStream& stream) {
    MIEN_TRY(model, stream.model());
    MIEN_TRY(decoder, stream.motion_decoder(model));
    // What is damaged counts for nothing.
    MIEN_CHECK(stream.visit_motion(decoder, [](const model::Motion&) -> Result<void> { return {}; }, [](const auto&, const Error&) {}));
    const auto split = decoder.split();
    const double all = split.coefficients + split.pose;
    return all > 0 ? split.pose / all : 0.0;
}

const char* name_of(LayerKind kind) {
    switch (kind) {
        case LayerKind::shape: return "shape";
        case LayerKind::vertex_basis: return "vertex basis";
        case LayerKind::blend: return "blend";
        case LayerKind::blendshapes: return "blendshapes";
        case LayerKind::points: return "points";
        case LayerKind::eyes: return "eyes";
        case LayerKind::static_albedo: return "picture";
        case LayerKind::video_albedo: return "video";
        case LayerKind::contact: return "contact";
        case LayerKind::thin_shell: return "thin shell";
        case LayerKind::marker_domain: return "marker domain";
        case LayerKind::medium: return "medium";
        case LayerKind::fine: return "fine";
        case LayerKind::albedo_map: return "albedo";
        case LayerKind::lid: return "lid";
    }
    return "";
}

}  // namespace

Result<std::vector<LayerBytes>> split_model(const StoredStream& stream) {
    MIEN_TRY(account, stream.reader().account());
    std::map<Hash, std::uint64_t> left;
    for (const auto& blob : account.blobs) left.emplace(blob.info.hash, blob.stored);
    std::vector<LayerBytes> layers;
    std::uint64_t framing = account.total;
    for (const protocol::Layer& layer : stream.reader().manifest().layers) {
        LayerBytes& entry = layers.emplace_back(LayerBytes{name_of(layer.kind), layer.blobs.size(), 0});
        for (const Hash& hash : layer.blobs)
            if (const auto blob = left.extract(hash)) entry.bytes += blob.mapped();
        framing -= entry.bytes;
    }
    layers.push_back({"framing", 1, framing});
    return layers;
}

Result<ByteSplit> split_bytes(const StoredStream& stream) {
    MIEN_TRY(account, stream.reader().account());
    ByteSplit split;
    split.total = account.total;
    for (const auto& blob : account.blobs) {
        switch (blob.info.kind) {
            case BlobKind::manifest: break;  // hashes and names: framing
            case BlobKind::shape:
            case BlobKind::blend:
            case BlobKind::blendshapes:
            case BlobKind::eyes:
            case BlobKind::contact:
            case BlobKind::shell:
            case BlobKind::driving_markers:
            case BlobKind::lid: split.shape += blob.stored; break;
            case BlobKind::marker_domain:
            case BlobKind::texel_mask:
            case BlobKind::detail_map:
            case BlobKind::refinement: split.detail += blob.stored; break;
            case BlobKind::connectivity:
            case BlobKind::texcoords: split.connectivity += blob.stored; break;
            case BlobKind::texture: split.texture += blob.stored; break;
            case BlobKind::motion_basis: {
                const Bytes* bytes = stream.blob(blob.info.hash);
                MIEN_TRY(parts, decoder::split_basis(*bytes));
                const double share = double(parts.probabilities) / std::max<double>(1, double(parts.basis + parts.probabilities));
                const auto probabilities = std::uint64_t(std::llround(share * double(blob.stored)));
                split.probabilities += probabilities;
                split.basis += blob.stored - probabilities;
                break;
            }
        }
    }
    for (const protocol::Track& track : stream.header().tracks)
        for (const protocol::Rung& rung : track.rungs) {
            const auto slot = account.slots.find(rung.slot);
            const std::uint64_t payload = slot == account.slots.end() ? 0 : slot->second.payload;
            if (track.kind == TrackKind::texture) split.texture += payload;
            if (track.kind == TrackKind::sound) split.sound += payload;
            if (track.kind == TrackKind::motion) split.coefficients += payload;
        }
    if (stream.track(TrackKind::motion)) {
        MIEN_TRY(share, pose_share(stream));
        split.pose = std::uint64_t(std::llround(share * double(split.coefficients)));
        split.coefficients -= split.pose;
    }
    split.framing = split.total - (split.shape + split.detail + split.connectivity + split.basis + split.probabilities + split.coefficients + split.pose + split.texture + split.sound);
    return split;
}

}  // namespace mien::tools
