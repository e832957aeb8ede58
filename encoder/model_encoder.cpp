#include "encoder/model_encoder.hpp"

#include <algorithm>
#include <cmath>

#include "coding/layer_code.hpp"
#include "encoder/head_layers.hpp"
#include "encoder/marker_triangulation.hpp"
#include "encoder/mesh_blobs.hpp"
#include "encoder/reference_points.hpp"
#include "protocol/messages.hpp"

namespace mien::encoder {
namespace {

using protocol::BlobKind;
using protocol::LayerKind;
using protocol::MotionKind;

class Packer {
public:
    Packer(const Clip& clip, const ModelOptions& options) : clip_(clip), options_(options) {}

    Result<EncodedModel> run() {
        if (clip_.neutral) MIEN_CHECK(add_shape());
        switch (options_.kind) {
            case MotionKind::vertices:
                if (!clip_.neutral) return Error{ErrorCode::missing, "vertices need a neutral mesh: the clip has none"};
                layer(LayerKind::vertex_basis, {});
                break;
            case MotionKind::markers: MIEN_CHECK(add_markers()); break;
            case MotionKind::weights: MIEN_CHECK(add_blendshapes()); break;
        }
        if (gaze_turns_eyes()) add_eyes(parts_);
        MIEN_CHECK(add_albedo());
        EncodedModel out;
        const Bytes bytes = protocol::encode_manifest(parts_.manifest);
        out.manifest = sha256(bytes);
        out.blobs = std::move(parts_.list.blobs());
        out.blobs.insert(out.blobs.begin(), {out.manifest, BlobKind::manifest, bytes});
        out.model = std::move(parts_.model);
        return out;
    }

private:
    Hash blob(BlobKind kind, Bytes bytes) { return parts_.list.add(kind, std::move(bytes)); }
    void layer(LayerKind kind, std::vector<Hash> blobs) { parts_.layer(kind, std::move(blobs)); }

    Result<void> add_shape() {
        MIEN_TRY(stored, store_mesh(*clip_.neutral, options_.step, true, parts_.list));
        parts_.model.neutral = std::move(stored.mesh);
        layer(LayerKind::shape, std::move(stored.blobs));
        return {};
    }

    Result<void> add_markers() {
        if (clip_.neutral && clip_.marker_sites.empty())
            return Error{ErrorCode::missing, "the clip has a neutral mesh but no marker_sites: where on the mesh the markers sit is needed to move it"};
        if (!clip_.neutral) {
            model::PointBase base;
            Mesh mesh;
            mesh.positions = reference_points(clip_, MotionKind::markers);
            mesh.triangles = triangulate_markers(mesh.positions);
            MIEN_TRY(stored, store_mesh(std::move(mesh), options_.step, false, parts_.list));
            layer(LayerKind::points, std::move(stored.blobs));
            base.markers = std::move(stored.mesh.positions);
            base.triangulation = std::move(stored.mesh.triangles);
            parts_.model.base = std::move(base);
            return {};
        }
        const std::vector<std::uint32_t> rigid = clip_.vertices ? clip_.rigid : std::vector<std::uint32_t>{};
        MIEN_CHECK(add_blend(*clip_.neutral, clip_.marker_sites, rigid, false, parts_));
        MIEN_CHECK(add_lids(*clip_.neutral, parts_));
        // Weights that are linear in the markers know nothing of lips that stop each other.
        return add_contacts(*clip_.neutral, parts_);
    }

    Result<void> add_blendshapes() {
        model::BlendshapeBase base;
        std::vector<Hash> blobs;
        if (clip_.neutral && !clip_.blendshapes.empty()) {
            constexpr float kStep = 1.0f / 64;  // mm: two hundred targets at weight 1 would add up to 0.1 mm
            blobs.push_back(blob(BlobKind::blendshapes, coding::encode_blendshapes(clip_.blendshapes, clip_.neutral->triangles, kStep)));
            MIEN_TRY(stored, coding::decode_blendshapes(parts_.list.bytes_of(blobs[0]), clip_.neutral->vertex_count(), clip_.neutral->triangles));
            base.targets = std::move(stored);
        }
        layer(LayerKind::blendshapes, std::move(blobs));
        parts_.model.base = std::move(base);
        return {};
    }

    /// Only where nothing else turns them: vertex motion carries its eyes, and so do blendshapes that move an eyeball.
    bool gaze_turns_eyes() const {
        if (!clip_.neutral || clip_.gaze.empty() || options_.kind == MotionKind::vertices) return false;
        const auto eyes = eye_vertices(*clip_.neutral);
        if (eyes[0].empty() && eyes[1].empty()) return false;
        if (options_.kind == MotionKind::weights)
            for (const Blendshape& target : clip_.blendshapes)
                for (const auto& eye : eyes)
                    for (const std::uint32_t v : eye)
                        if (target.offsets.row(v).norm() > 0.05f) return false;
        return true;
    }

    Result<void> add_albedo() {
        if (!clip_.texture || options_.albedo == Albedo::none) return {};
        if (options_.albedo == Albedo::video) {
            parts_.model.video_albedo = true;
            layer(LayerKind::video_albedo, {});
            return {};
        }
        MIEN_TRY(picture, clip_.texture->read(0));
        return add_picture(picture, parts_);
    }

    const Clip& clip_;
    const ModelOptions& options_;
    ModelParts parts_;
};

}  // namespace

float shape_step(double rms_mm) {
    // A grid of step s leaves s / 2 of 3-D RMS error: (s / 2)^2 <= 0.1 rms^2.
    const double step = std::exp2(std::floor(std::log2(2 * std::sqrt(0.1) * rms_mm)));
    return float(std::clamp(step, 1.0 / 4096, 1.0 / 4));
}

Result<EncodedModel> encode_model(const Clip& clip, const ModelOptions& options) { return Packer(clip, options).run(); }

}  // namespace mien::encoder
