#include "encoder/model_encoder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "coding/layer_code.hpp"
#include "encoder/blend_coefficients.hpp"
#include "encoder/lip_contact.hpp"
#include "encoder/marker_triangulation.hpp"
#include "encoder/mesh_blobs.hpp"
#include "encoder/reference_points.hpp"
#include "media/picture.hpp"
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
        if (gaze_turns_eyes()) add_eyes();
        MIEN_CHECK(add_albedo());
        const Bytes bytes = protocol::encode_manifest(manifest_);
        out_.manifest = sha256(bytes);
        out_.blobs = std::move(list_.blobs());
        out_.blobs.insert(out_.blobs.begin(), {out_.manifest, BlobKind::manifest, bytes});
        return std::move(out_);
    }

private:
    Hash blob(BlobKind kind, Bytes bytes) { return list_.add(kind, std::move(bytes)); }
    void layer(LayerKind kind, std::vector<Hash> blobs) { manifest_.layers.push_back({kind, std::move(blobs)}); }

    Result<void> add_shape() {
        MIEN_TRY(stored, store_mesh(*clip_.neutral, options_.step, true, list_));
        out_.model.neutral = std::move(stored.mesh);
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
            MIEN_TRY(stored, store_mesh(std::move(mesh), options_.step, false, list_));
            layer(LayerKind::points, std::move(stored.blobs));
            base.markers = std::move(stored.mesh.positions);
            base.triangulation = std::move(stored.mesh.triangles);
            out_.model.base = std::move(base);
            return {};
        }
        std::vector<std::uint32_t> rigid = clip_.vertices ? clip_.rigid : std::vector<std::uint32_t>{};
        MIEN_TRY(base, blend_coefficients(*clip_.neutral, clip_.marker_sites, rigid));
        coding::SparseRows rows;
        rows.row_start = base.row_start;
        for (const auto& term : base.terms) rows.terms.push_back({term.marker, term.weight});
        Bytes bytes = coding::encode_blend(base.sites, rows);
        MIEN_TRY(stored, coding::decode_blend(bytes, clip_.neutral->vertex_count()));
        base.row_start = stored.rows.row_start;
        base.terms.clear();
        for (const auto& term : stored.rows.terms) base.terms.push_back({term.column, term.share});
        for (std::size_t m = 0; m < base.sites.size(); ++m)
            base.markers.row(Eigen::Index(m)) = base.sites[m].position(out_.model.neutral.positions).transpose();
        layer(LayerKind::blend, {blob(BlobKind::blend, std::move(bytes))});
        out_.model.base = std::move(base);
        return add_contact();
    }

    /// Weights that are linear in the markers know nothing of lips that stop each other.
    Result<void> add_contact() {
        const auto contact = lip_contact(*clip_.neutral);
        if (!contact) return {};
        coding::LipContact lips{contact->pairs, {}};
        for (const auto& member : contact->members) lips.members.push_back({member.vertex, member.hold});
        Bytes bytes = coding::encode_contact(lips);
        MIEN_TRY(stored, coding::decode_contact(bytes, clip_.neutral->vertex_count()));
        auto& kept = out_.model.contact.emplace();
        kept.pairs = std::move(stored.pairs);
        for (const auto& member : stored.members) kept.members.push_back({member.vertex, member.hold});
        layer(LayerKind::contact, {blob(BlobKind::contact, std::move(bytes))});
        return {};
    }

    Result<void> add_blendshapes() {
        model::BlendshapeBase base;
        std::vector<Hash> blobs;
        if (clip_.neutral && !clip_.blendshapes.empty()) {
            constexpr float kStep = 1.0f / 64;  // mm: two hundred targets at weight 1 would add up to 0.1 mm
            blobs.push_back(blob(BlobKind::blendshapes, coding::encode_blendshapes(clip_.blendshapes, clip_.neutral->triangles, kStep)));
            MIEN_TRY(stored, coding::decode_blendshapes(list_.bytes_of(blobs[0]), clip_.neutral->vertex_count(), clip_.neutral->triangles));
            base.targets = std::move(stored);
        }
        layer(LayerKind::blendshapes, std::move(blobs));
        out_.model.base = std::move(base);
        return {};
    }

    /// Vertices of the eyeballs, the actor's right and left. Tear film and the like stay with the lids.
    std::array<std::set<std::uint32_t>, 2> eye_vertices() const {
        std::array<std::set<std::uint32_t>, 2> eyes;
        const Mesh& mesh = *clip_.neutral;
        const float middle = (mesh.positions.col(0).minCoeff() + mesh.positions.col(0).maxCoeff()) / 2;
        const std::vector<Surface> surfaces = mesh.triangle_surfaces();
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
            if (surfaces[t] == Surface::eye)
                for (const std::uint32_t v : mesh.triangles[t]) eyes[mesh.positions(v, 0) > middle].insert(v);
        return eyes;
    }

    /// Only where nothing else turns them: vertex motion carries its eyes, and so do blendshapes that move an eyeball.
    bool gaze_turns_eyes() const {
        if (!clip_.neutral || clip_.gaze.empty() || options_.kind == MotionKind::vertices) return false;
        const auto eyes = eye_vertices();
        if (eyes[0].empty() && eyes[1].empty()) return false;
        if (options_.kind == MotionKind::weights)
            for (const Blendshape& target : clip_.blendshapes)
                for (const auto& eye : eyes)
                    for (const std::uint32_t v : eye)
                        if (target.offsets.row(v).norm() > 0.05f) return false;
        return true;
    }

    void add_eyes() {
        const auto balls = eye_vertices();
        std::array<std::optional<coding::Ball>, 2> eyes;
        const Points& positions = out_.model.neutral.positions;
        for (std::size_t side = 0; side < 2; ++side) {
            if (balls[side].empty()) continue;
            Vec3 low = Vec3::Constant(1e9f), high = -low;
            for (const std::uint32_t v : balls[side]) {
                low = low.cwiseMin(positions.row(v).transpose());
                high = high.cwiseMax(positions.row(v).transpose());
            }
            // Height and width are the ball's; its depth may be open behind or bulge in front.
            Vec3 centre = (low + high) / 2;
            centre.z() = std::max(centre.z(), high.z() - (high.y() - low.y()) / 2);
            eyes[side] = coding::Ball{centre, {balls[side].begin(), balls[side].end()}};
            out_.model.eyes[side] = model::Eyeball{centre, eyes[side]->vertices};
        }
        layer(LayerKind::eyes, {blob(BlobKind::eyes, coding::encode_eyes(eyes))});
    }

    Result<void> add_albedo() {
        if (!clip_.texture || options_.albedo == Albedo::none) return {};
        if (options_.albedo == Albedo::video) {
            out_.model.video_albedo = true;
            layer(LayerKind::video_albedo, {});
            return {};
        }
        MIEN_TRY(picture, clip_.texture->read(0));
        MIEN_TRY(bytes, media::encode_jpeg(picture));
        layer(LayerKind::static_albedo, {blob(BlobKind::texture, std::move(bytes))});
        out_.model.static_albedo = std::move(picture);
        return {};
    }

    const Clip& clip_;
    const ModelOptions& options_;
    protocol::Manifest manifest_;
    BlobList list_;
    EncodedModel out_;
};

}  // namespace

float shape_step(double rms_mm) {
    // A grid of step s leaves s / 2 of 3-D RMS error: (s / 2)^2 <= 0.1 rms^2.
    const double step = std::exp2(std::floor(std::log2(2 * std::sqrt(0.1) * rms_mm)));
    return float(std::clamp(step, 1.0 / 4096, 1.0 / 4));
}

Result<EncodedModel> encode_model(const Clip& clip, const ModelOptions& options) { return Packer(clip, options).run(); }

}  // namespace mien::encoder
