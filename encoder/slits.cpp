#include "encoder/slits.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <unordered_map>

namespace mien::encoder {
namespace {

/// Vertices by cells of `size` mm, to find those near a place.
class Cells {
public:
    Cells(const Points& points, const std::vector<std::uint32_t>& vertices, float size) : points_(points), size_(size) {
        for (const std::uint32_t v : vertices) cells_[key(points.row(v).transpose())].push_back(v);
    }
    template <class Visit>
    void near(const Vec3& place, Visit visit) const {
        for (int dx = -1; dx <= 1; ++dx)
            for (int dy = -1; dy <= 1; ++dy)
                for (int dz = -1; dz <= 1; ++dz) {
                    const auto cell = cells_.find(key(place + size_ * Vec3(float(dx), float(dy), float(dz))));
                    if (cell == cells_.end()) continue;
                    for (const std::uint32_t v : cell->second)
                        if ((points_.row(v).transpose() - place).norm() < size_) visit(v);
                }
    }

private:
    std::int64_t key(const Vec3& p) const {
        const auto cell = [&](float x) { return std::int64_t(std::floor(x / size_)) + (1 << 19); };
        return cell(p.x()) << 40 | cell(p.y()) << 20 | cell(p.z());
    }
    const Points& points_;
    float size_;
    std::unordered_map<std::int64_t, std::vector<std::uint32_t>> cells_;
};

constexpr float kLipGap = 3.5f;        // mm between lips that count as closed
constexpr float kLipDetour = 9.0f;     // mm along the skin that make the two lips two
constexpr float kClusterGap = 6.0f;    // mm between neighbouring places of one slit
constexpr float kNarrowestMouth = 25;  // mm; the narrowest adult mouths are about 40

/// Midpoints of pairs of skin vertices that nearly touch though the way along the skin is long: lips, but also folds
/// of ears and nostrils.
std::vector<Vec3> touching_places(const Mesh& mesh, const SurfaceDistance& skin, const std::vector<std::uint32_t>& vertices) {
    const Cells cells(mesh.positions, vertices, kLipGap);
    std::vector<Vec3> places;
    std::vector<char> near_along(mesh.vertex_count());
    for (const std::uint32_t u : vertices) {
        const Vec3 p = mesh.positions.row(u).transpose();
        const auto reached = skin.from({{u, 0.0f}}, kLipDetour);
        for (const auto& r : reached) near_along[r.vertex] = 1;
        cells.near(p, [&](std::uint32_t v) {
            if (v > u && !near_along[v]) places.push_back((p + mesh.positions.row(v).transpose()) / 2);
        });
        for (const auto& r : reached) near_along[r.vertex] = 0;
    }
    return places;
}

/// The widest cluster of places that crosses the middle of the face, as a line of one place per 2 mm of x.
std::optional<std::vector<Vec3>> mouth_line(std::vector<Vec3> places, float middle) {
    // One place per cubic millimetre is plenty and keeps the clustering below quick on dense meshes.
    const auto cell = [](const Vec3& p) { return std::array{std::lround(p.x()), std::lround(p.y()), std::lround(p.z())}; };
    std::sort(places.begin(), places.end(), [&](const Vec3& a, const Vec3& b) { return cell(a) < cell(b); });
    places.erase(std::unique(places.begin(), places.end(), [&](const Vec3& a, const Vec3& b) { return cell(a) == cell(b); }), places.end());
    std::vector<int> cluster(places.size(), -1);
    std::vector<Vec3> best;
    float best_width = kNarrowestMouth;
    for (std::size_t seed = 0; seed < places.size(); ++seed) {
        if (cluster[seed] >= 0) continue;
        std::vector<std::size_t> members{seed};
        cluster[seed] = int(seed);
        for (std::size_t i = 0; i < members.size(); ++i)
            for (std::size_t j = 0; j < places.size(); ++j)
                if (cluster[j] < 0 && (places[j] - places[members[i]]).norm() < kClusterGap) {
                    cluster[j] = int(seed);
                    members.push_back(j);
                }
        float low = 1e9f, high = -1e9f;
        for (const std::size_t i : members) {
            low = std::min(low, places[i].x());
            high = std::max(high, places[i].x());
        }
        if (low < middle && high > middle && high - low > best_width) {
            best_width = high - low;
            best.clear();
            for (const std::size_t i : members) best.push_back(places[i]);
        }
    }
    if (best.empty()) return std::nullopt;
    std::sort(best.begin(), best.end(), [](const Vec3& a, const Vec3& b) { return a.x() < b.x(); });
    std::vector<Vec3> line;
    for (std::size_t i = 0; i < best.size();) {
        // The front of the contact is the seam one sees; behind it lies the vestibule.
        float front = -1e9f;
        std::size_t end = i;
        for (; end < best.size() && best[end].x() < best[i].x() + 2; ++end) front = std::max(front, best[end].z());
        Vec3 mean = Vec3::Zero();
        int count = 0;
        for (; i < end; ++i)
            if (best[i].z() > front - 2) {
                mean += best[i];
                ++count;
            }
        line.push_back(mean / float(count));
    }
    // Near the corners the way round is short and no pair is found: the slit goes on a little.
    const Vec3 right = line.front(), left = line.back();
    line.insert(line.begin(), right - Vec3(4, 0, 1));
    line.push_back(left + Vec3(4, 0, -1));
    return line;
}

float line_y(const std::vector<Vec3>& line, float x) {
    const auto after = std::find_if(line.begin(), line.end(), [&](const Vec3& p) { return p.x() >= x; });
    if (after == line.begin()) return line.front().y();
    if (after == line.end()) return line.back().y();
    const Vec3 &a = *(after - 1), &b = *after;
    const float t = (x - a.x()) / std::max(1e-6f, b.x() - a.x());
    return a.y() + t * (b.y() - a.y());
}

/// Side of every vertex by its height over the line.
std::vector<Side> sides_by_height(const Mesh& mesh, const std::vector<Vec3>& line) {
    std::vector<Side> sides(mesh.vertex_count(), Side::beside);
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
        const Vec3 p = mesh.positions.row(v).transpose();
        if (p.x() < line.front().x() || p.x() > line.back().x()) continue;
        sides[v] = p.y() >= line_y(line, p.x()) ? Side::above : Side::below;
    }
    return sides;
}

float foremost(const std::vector<Vec3>& line) {
    return std::max_element(line.begin(), line.end(), [](const Vec3& a, const Vec3& b) { return a.z() < b.z(); })->z();
}

constexpr float kBehind = 25;  // mm behind the front of a slit: what lies deeper is no rim

/// Lids roll inward, where height says little: the nearest skin further out decides, along the skin.
std::vector<Side> label_lids(const Mesh& mesh, const SurfaceDistance& skin, const std::vector<Vec3>& line, float roll) {
    std::vector<Side> sides = sides_by_height(mesh, line);
    std::vector<std::pair<std::uint32_t, float>> above, below;
    std::vector<std::uint32_t> undecided;
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
        const Vec3 p = mesh.positions.row(v).transpose();
        if (sides[v] == Side::beside || !skin.carries(v) || p.z() < foremost(line) - kBehind) continue;
        const float height = p.y() - line_y(line, p.x());
        if (std::abs(height) < roll) undecided.push_back(v);
        else if (std::abs(height) < 2.5f * roll) (height > 0 ? above : below).emplace_back(v, 0.0f);
    }
    std::vector<float> to_above(mesh.vertex_count(), 1e9f), to_below(mesh.vertex_count(), 1e9f);
    for (const auto& r : skin.from(above)) to_above[r.vertex] = r.distance;
    for (const auto& r : skin.from(below)) to_below[r.vertex] = r.distance;
    for (const std::uint32_t v : undecided)
        if (to_above[v] != to_below[v]) sides[v] = to_above[v] < to_below[v] ? Side::above : Side::below;
    return sides;
}

/// Lips that touch may lie a little beyond the line of the mouth: there the upper one looks down and the lower one up.
std::vector<Side> label_lips(const Mesh& mesh, const SurfaceDistance& skin, const std::vector<Vec3>& line) {
    constexpr float kLevel = 0.4f;  // sine of the slope from which a surface counts as looking up or down
    std::vector<Side> sides = sides_by_height(mesh, line);
    const Points normals = vertex_normals(mesh.positions, mesh.triangles);
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
        const Vec3 p = mesh.positions.row(v).transpose();
        if (sides[v] == Side::beside || !skin.carries(v) || p.z() < foremost(line) - kBehind) continue;
        const float from_corner = std::min(p.x() - line.front().x(), line.back().x() - p.x());
        const float roll = std::min(2.0f, 0.5f + 0.1f * from_corner);  // mm; lips thin out towards the corners
        if (std::abs(p.y() - line_y(line, p.x())) < roll && std::abs(normals(v, 1)) > kLevel)
            sides[v] = normals(v, 1) < 0 ? Side::above : Side::below;
    }
    return sides;
}

struct Ball {
    Vec3 centre;
    float radius;
};

/// Eyeballs: vertices of Surface::eye left and right of the middle; a box around them gives the ball.
std::vector<Ball> eyeballs(const Mesh& mesh, float middle) {
    const std::vector<Surface> surface_of = mesh.triangle_surfaces();
    Vec3 low[2], high[2];
    int count[2] = {0, 0};
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        if (surface_of[t] != Surface::eye) continue;
        for (const std::uint32_t v : mesh.triangles[t]) {
            const Vec3 p = mesh.positions.row(v).transpose();
            const int side = p.x() > middle;
            low[side] = count[side] ? Vec3(low[side].cwiseMin(p)) : p;
            high[side] = count[side] ? Vec3(high[side].cwiseMax(p)) : p;
            ++count[side];
        }
    }
    std::vector<Ball> balls;
    for (int side = 0; side < 2; ++side)
        if (count[side]) balls.push_back({(low[side] + high[side]) / 2, (high[side] - low[side]).y() / 2});
    return balls;
}

}  // namespace

std::vector<Slit> find_slits(const Mesh& neutral, const SurfaceDistance& skin) {
    std::vector<Slit> slits;
    std::vector<std::uint32_t> vertices;
    for (std::uint32_t v = 0; v < neutral.vertex_count(); ++v)
        if (skin.carries(v)) vertices.push_back(v);
    if (vertices.empty()) return slits;
    const float middle = (neutral.positions.col(0).minCoeff() + neutral.positions.col(0).maxCoeff()) / 2;

    constexpr float kLidReach = 1.25f;  // corners of the lids, in eyeball radii from its centre
    for (const Ball& eye : eyeballs(neutral, middle)) {
        Slit slit;
        slit.centre = eye.centre, slit.radius = eye.radius;
        const Vec3 front = eye.centre + Vec3(0, 0, eye.radius);
        slit.line = {front - Vec3(kLidReach * eye.radius, 0, 0), front, front + Vec3(kLidReach * eye.radius, 0, 0)};
        slit.sides = label_lids(neutral, skin, slit.line, eye.radius * 0.6f);
        slits.push_back(std::move(slit));
    }
    // The mouth lies in the lower front of the head; ears and nostrils do not cross the middle there.
    std::vector<std::uint32_t> front;
    const float eye_level = slits.empty() ? neutral.positions.col(1).maxCoeff() : slits.front().line.front().y();
    for (const std::uint32_t v : vertices)
        if (std::abs(neutral.positions(v, 0) - middle) < 45 && neutral.positions(v, 1) < eye_level - 15) front.push_back(v);
    if (auto line = mouth_line(touching_places(neutral, skin, front), middle)) {
        Slit slit;
        slit.mouth = true;
        slit.line = std::move(*line);
        slit.sides = label_lips(neutral, skin, slit.line);
        slits.push_back(std::move(slit));
    }
    return slits;
}

}  // namespace mien::encoder
