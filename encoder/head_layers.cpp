#include "encoder/head_layers.hpp"

#include <algorithm>
#include <set>

#include "coding/layer_code.hpp"
#include "encoder/blend_coefficients.hpp"
#include "encoder/contacts.hpp"
#include "encoder/lids.hpp"
#include "media/picture.hpp"

namespace mien::encoder {

using protocol::BlobKind;
using protocol::LayerKind;

std::array<std::vector<std::uint32_t>, 2> eye_vertices(const Mesh& mesh) {
    std::array<std::set<std::uint32_t>, 2> eyes;
    const float middle = (mesh.positions.col(0).minCoeff() + mesh.positions.col(0).maxCoeff()) / 2;
    const std::vector<Surface> surfaces = mesh.triangle_surfaces();
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        if (surfaces[t] == Surface::eye)
            for (const std::uint32_t v : mesh.triangles[t]) eyes[mesh.positions(v, 0) > middle].insert(v);
    return {std::vector<std::uint32_t>(eyes[0].begin(), eyes[0].end()), std::vector<std::uint32_t>(eyes[1].begin(), eyes[1].end())};
}

void add_eyes(ModelParts& parts) {
    const auto balls = eye_vertices(parts.model.neutral);
    if (balls[0].empty() && balls[1].empty()) return;
    std::array<std::optional<coding::Ball>, 2> eyes;
    const Points& positions = parts.model.neutral.positions;
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
        eyes[side] = coding::Ball{centre, balls[side]};
        parts.model.eyes[side] = model::Eyeball{centre, balls[side]};
    }
    parts.layer(LayerKind::eyes, {parts.list.add(BlobKind::eyes, coding::encode_eyes(eyes))});
}

Result<void> add_lids(const Mesh& neutral, ModelParts& parts) {
    const std::vector<Site>* sites = model::driving_sites(parts.model);
    if (!sites) return {};
    for (const model::Lid& found : find_lids(neutral, *sites)) {
        coding::Lid lid{found.centre, {}};
        for (const auto& member : found.members) lid.members.push_back({member.vertex, member.share, member.weight, member.hold});
        Bytes bytes = coding::encode_lid(lid);
        MIEN_TRY(stored, coding::decode_lid(bytes, neutral.vertex_count()));
        model::Lid kept{stored.centre, {}};
        for (const auto& member : stored.members) kept.members.push_back({member.vertex, member.share, member.weight, member.hold});
        model::add_lid(parts.model, std::move(kept));
        parts.layer(LayerKind::lid, {parts.list.add(BlobKind::lid, std::move(bytes))});
    }
    return {};
}

Result<void> add_contacts(const Mesh& neutral, ModelParts& parts) {
    for (const model::Contact& found : find_contacts(neutral)) {
        coding::Contact contact{found.pairs, {}};
        for (const auto& member : found.members) contact.members.push_back({member.vertex, member.hold});
        Bytes bytes = coding::encode_contact(contact);
        MIEN_TRY(stored, coding::decode_contact(bytes, neutral.vertex_count()));
        auto& kept = parts.model.contacts.emplace_back();
        kept.pairs = std::move(stored.pairs);
        for (const auto& member : stored.members) kept.members.push_back({member.vertex, member.hold});
        parts.layer(LayerKind::contact, {parts.list.add(BlobKind::contact, std::move(bytes))});
    }
    return {};
}

Result<void> add_blend(const Mesh& neutral, const std::vector<Site>& sites, const std::vector<std::uint32_t>& rigid, bool beside_shell, ModelParts& parts) {
    MIEN_TRY(base, blend_coefficients(neutral, sites, rigid));
    std::vector<std::uint8_t> left_out(neutral.vertex_count(), 0);
    const std::vector<Surface> surfaces = neutral.triangle_surfaces();
    for (std::size_t t = 0; beside_shell && t < neutral.triangles.size(); ++t)
        if (surfaces[t] == Surface::skin)
            for (const std::uint32_t v : neutral.triangles[t]) left_out[v] = 1;
    coding::SparseRows rows;
    rows.row_start = {0};
    for (std::uint32_t v = 0; v < neutral.vertex_count(); ++v) {
        for (std::uint32_t i = base.row_start[v]; i < base.row_start[v + 1] && !left_out[v]; ++i) rows.terms.push_back({base.terms[i].marker, base.terms[i].weight});
        rows.row_start.push_back(std::uint32_t(rows.terms.size()));
    }
    Bytes bytes = coding::encode_blend(base.sites, rows);
    MIEN_TRY(stored, coding::decode_blend(bytes, neutral.vertex_count()));
    base.row_start = stored.rows.row_start;
    base.terms.clear();
    for (const auto& term : stored.rows.terms) base.terms.push_back({term.column, term.share});
    for (std::size_t m = 0; m < base.sites.size(); ++m)
        base.markers.row(Eigen::Index(m)) = base.sites[m].position(parts.model.neutral.positions).transpose();
    parts.layer(LayerKind::blend, {parts.list.add(BlobKind::blend, std::move(bytes))});
    parts.model.base = std::move(base);
    return {};
}

Result<void> add_picture(const Image& picture, ModelParts& parts) {
    MIEN_TRY(bytes, media::encode_jpeg(picture));
    parts.layer(LayerKind::static_albedo, {parts.list.add(BlobKind::texture, std::move(bytes))});
    parts.model.static_albedo = picture;
    return {};
}

}  // namespace mien::encoder
