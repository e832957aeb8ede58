#include "samples/ict_actor_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace mien::samples::ict {
namespace {

/// Square of the atlas that a texture tile of the file goes to: corner and side.
struct Place {
    float u, v, side;
};
struct PartRule {
    const char* name;
    Surface surface;
    Place place;
};

// The face takes nine sixteenths of the atlas. Iris shells lie inside the eyeballs, so they share what is left over.
constexpr PartRule kParts[] = {
    {"face", Surface::skin, {0, .25f, .75f}},
    {"back_head", Surface::skin, {.75f, .75f, .25f}},
    {"mouth_socket", Surface::mouth, {.75f, .75f, .25f}},  // on the same tile as the back of the head, beside it
    {"eye_sockets", Surface::mouth, {.75f, .75f, .25f}},
    {"gums_tongue", Surface::mouth, {.75f, .5f, .25f}},
    {"teeth", Surface::teeth, {.75f, .25f, .25f}},
    {"sclera_left", Surface::eye, {.25f, 0, .25f}},
    {"iris_left", Surface::eye, {.5f, 0, .125f}},
    {"sclera_right", Surface::eye, {0, 0, .25f}},
    {"iris_right", Surface::eye, {.625f, 0, .125f}},
    {"lacrimal_fluid", Surface::cornea, {.5f, .125f, .125f}},
};

/// Index into kParts, or -1 for a sheet that is not drawn. `material`: of the file.
int part_of(const std::string& material, const Triangle& triangle) {
    const auto rule = [](std::string_view name) {
        return int(std::find_if(std::begin(kParts), std::end(kParts), [&](const PartRule& p) { return name == p.name; }) -
                   std::begin(kParts));
    };
    static const std::map<std::string, int> by_material = {
        {"M_Face", rule("face")},           {"M_GumsTongue", rule("gums_tongue")},   {"M_Teeth", rule("teeth")},
        {"M_ScleraLeft", rule("sclera_left")}, {"M_IrisLeft", rule("iris_left")},    {"M_ScleraRight", rule("sclera_right")},
        {"M_IrisRight", rule("iris_right")}, {"M_LacrimalFluid", rule("lacrimal_fluid")},
    };
    if (material == "M_BackHead") {
        const std::uint32_t last = *std::max_element(triangle.begin(), triangle.end());
        return last < kSkinEnd ? rule("back_head") : last < kMouthSocketEnd ? rule("mouth_socket") : rule("eye_sockets");
    }
    const auto found = by_material.find(material);
    return found == by_material.end() ? -1 : found->second;
}

}  // namespace

Result<Mesh> arrange(const Mesh& file) {
    if (file.vertex_count() != kVertices)
        return Error{ErrorCode::mismatch,
                     fmt::format("the neutral mesh has {} vertices, not the {} of ICT-FaceKit", file.vertex_count(), kVertices)};
    if (!file.has_texcoords())
        return Error{ErrorCode::mismatch, "the neutral mesh of ICT-FaceKit has lost its texture coordinates"};
    Mesh mesh;
    mesh.positions = 10 * file.positions;
    std::vector<std::vector<std::uint32_t>> of_part(std::size(kParts));
    for (const MeshPart& part : file.parts)
        for (std::uint32_t t = part.first; t < part.first + part.count; ++t)
            if (const int p = part_of(part.name, file.triangles[t]); p >= 0) of_part[std::size_t(p)].push_back(t);
    for (std::size_t p = 0; p < std::size(kParts); ++p) {
        const PartRule& rule = kParts[p];
        if (of_part[p].empty())
            return Error{ErrorCode::mismatch, fmt::format("the neutral mesh has no part '{}' of ICT-FaceKit", rule.name)};
        mesh.parts.push_back({rule.name, rule.surface, std::uint32_t(mesh.triangles.size()), std::uint32_t(of_part[p].size())});
        std::map<std::uint32_t, std::uint32_t> moved;
        for (std::uint32_t t : of_part[p]) {
            mesh.triangles.push_back(file.triangles[t]);
            Triangle uv{};
            for (int c = 0; c < 3; ++c) {
                const std::uint32_t from = file.texcoord_triangles[t][std::size_t(c)];
                const auto [at, is_new] = moved.try_emplace(from, std::uint32_t(mesh.texcoords.size()));
                if (is_new) {
                    // Tiles lie side by side in the file; lacrimal fluid spreads over two and is squeezed into one.
                    const Vec2 in = file.texcoords[from];
                    const float u = rule.surface == Surface::cornea ? (in.x() - 4) / 2 : in.x() - std::floor(in.x());
                    mesh.texcoords.push_back({rule.place.u + rule.place.side * u, rule.place.v + rule.place.side * in.y()});
                }
                uv[std::size_t(c)] = at->second;
            }
            mesh.texcoord_triangles.push_back(uv);
        }
    }
    return mesh;
}

}  // namespace mien::samples::ict
