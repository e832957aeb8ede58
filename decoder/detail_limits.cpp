#include "decoder/detail_limits.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace mien::decoder {
namespace {

constexpr std::uint64_t kMaxShellValues = 1u << 25;   // vertices x markers: 100 000 x 300
constexpr std::uint64_t kMaxShellFaces = 1u << 26;    // triangles x markers
constexpr std::uint64_t kMaxStarPairs = 1u << 26;     // squares of the vertices' triangle counts: a hub of 8000
constexpr std::int64_t kMaxHandles = 256;             // and holes, of one piece of skin; scans have some dozens
constexpr std::uint64_t kMaxCovered = 1u << 28;       // texels in the boxes of all texture triangles: 16 times a 4096 map
constexpr std::uint64_t kMaxPlaceSteps = 1u << 31;    // texels x marker triangles
constexpr std::uint64_t kMaxMapValues = 1u << 26;     // texels x planes: 18 planes of a 2048 map that is two thirds full
constexpr std::uint64_t kValuesPerByte = 1u << 14;    // chances stay above 24 / 65536, so none costs less than 1 / 1900 bit

Error exceeded(const char* why) { return {ErrorCode::limit_exceeded, std::string("the detail model is refused: ") + why}; }

}  // namespace

Result<void> check_skin(const Mesh& mesh, std::size_t markers) {
    const std::uint32_t V = mesh.vertex_count();
    if (std::uint64_t(V) * markers > kMaxShellValues || mesh.triangles.size() * markers > kMaxShellFaces) return exceeded("its mesh is too large for so many markers");
    const std::vector<Surface> surfaces = mesh.triangle_surfaces();
    std::vector<std::uint64_t> edges;
    std::vector<std::uint32_t> valence(V, 0), piece(V);
    std::iota(piece.begin(), piece.end(), 0u);
    const auto root = [&](std::uint32_t v) {
        while (piece[v] != v) v = piece[v] = piece[piece[v]];
        return v;
    };
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        if (surfaces[t] != Surface::skin) continue;
        const Triangle& corners = mesh.triangles[t];
        for (int i = 0; i < 3; ++i) {
            const std::uint32_t a = corners[i], b = corners[(i + 1) % 3];
            ++valence[a];
            edges.push_back(std::uint64_t(std::min(a, b)) << 32 | std::max(a, b));
            piece[root(a)] = root(b);
        }
    }
    std::uint64_t pairs = 0;
    for (const std::uint32_t v : valence) pairs += std::uint64_t(v) * v;
    if (pairs > kMaxStarPairs) return exceeded("too many triangles of its skin meet in one vertex");

    // Euler's characteristic of every piece, V - E + F; an edge of three triangles or more counts against it.
    std::vector<std::int64_t> twice(V, 0);  // of the piece with this root
    for (std::uint32_t v = 0; v < V; ++v)
        if (valence[v] > 0) twice[root(v)] += 2;
    std::sort(edges.begin(), edges.end());
    for (std::size_t i = 0, j; i < edges.size(); i = j) {
        for (j = i; j < edges.size() && edges[j] == edges[i];) ++j;
        twice[root(std::uint32_t(edges[i] >> 32))] -= j - i > 2 ? 2 * std::int64_t(j - i) : 2;
    }
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        if (surfaces[t] == Surface::skin) twice[root(mesh.triangles[t][0])] += 2;
    for (const std::int64_t c : twice)
        if (c < -2 * 2 * kMaxHandles) return exceeded("its skin is no surface but a tangle");
    return {};
}

Result<void> check_domain(const Mesh& mesh, const std::vector<Triangle>& marker_triangles, std::size_t markers, int width, int height, std::uint64_t texels) {
    double covered = 0;
    for (const Triangle& t : mesh.texcoord_triangles) {
        Vec2 low = mesh.texcoords[t[0]], high = low;
        for (int i = 1; i < 3; ++i) low = low.cwiseMin(mesh.texcoords[t[i]]), high = high.cwiseMax(mesh.texcoords[t[i]]);
        const Vec2 size = high.cwiseMin(1.0f) - low.cwiseMax(0.0f);
        if (size.minCoeff() >= 0) covered += double(size.x()) * width * double(size.y()) * height;
    }
    if (!(covered <= double(kMaxCovered))) return exceeded("its texture triangles lie upon each other");
    // Triangles within two edges of a marker, at most.
    std::vector<std::uint64_t> around(markers, 0), near(markers, 0);
    for (const Triangle& t : marker_triangles)
        for (const std::uint32_t corner : t) ++around[corner];
    for (const Triangle& t : marker_triangles)
        for (const std::uint32_t corner : t) near[corner] += around[t[0]] + around[t[1]] + around[t[2]];
    const std::uint64_t most = near.empty() ? 0 : *std::max_element(near.begin(), near.end());
    const std::uint64_t all = std::accumulate(near.begin(), near.end(), std::uint64_t(0));
    if (texels * most > kMaxPlaceSteps || all > kMaxPlaceSteps / 64) return exceeded("its markers are joined too densely");
    return {};
}

bool plausible(std::uint64_t values, std::size_t bytes) { return values <= kMaxMapValues && values <= kValuesPerByte * (bytes + 64); }

}  // namespace mien::decoder
