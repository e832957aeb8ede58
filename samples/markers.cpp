#include "samples/markers.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "samples/noise.hpp"

namespace mien::samples {
namespace {

using Line = Landmarks::Line;

/// Which vertices can be seen from the front or half from a side: a depth picture of every surface from each direction.
std::vector<bool> visible_vertices(const Mesh& mesh) {
    constexpr int kSize = 360;
    std::vector<bool> visible(mesh.vertex_count(), false);
    for (float angle : {0.f, 0.8f, -0.8f}) {
        const Points turned = mesh.positions * Eigen::AngleAxisf(angle, Vec3::UnitY()).toRotationMatrix().transpose();
        const Eigen::RowVector3f low = turned.colwise().minCoeff(), high = turned.colwise().maxCoeff();
        const float scale = (kSize - 2) / std::max(high.x() - low.x(), high.y() - low.y());
        std::vector<float> depth(kSize * kSize, -std::numeric_limits<float>::max());
        const auto place = [&](std::uint32_t v) {
            return Vec3((turned(v, 0) - low.x()) * scale, (turned(v, 1) - low.y()) * scale, turned(v, 2));
        };
        for (const Triangle& t : mesh.triangles) {
            const Vec3 a = place(t[0]), b = place(t[1]), c = place(t[2]);
            const float area = (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
            if (std::abs(area) < 1e-9f) continue;
            const int y_end = int(std::max({a.y(), b.y(), c.y()})), x_end = int(std::max({a.x(), b.x(), c.x()}));
            for (int y = int(std::ceil(std::min({a.y(), b.y(), c.y()}))); y <= y_end; ++y)
                for (int x = int(std::ceil(std::min({a.x(), b.x(), c.x()}))); x <= x_end; ++x) {
                    const float wb = ((float(x) - a.x()) * (c.y() - a.y()) - (float(y) - a.y()) * (c.x() - a.x())) / area;
                    const float wc = ((b.x() - a.x()) * (float(y) - a.y()) - (b.y() - a.y()) * (float(x) - a.x())) / area;
                    if (wb < 0 || wc < 0 || wb + wc > 1) continue;
                    float& nearest = depth[std::size_t(y * kSize + x)];
                    nearest = std::max(nearest, a.z() + wb * (b.z() - a.z()) + wc * (c.z() - a.z()));
                }
        }
        const Points normals = vertex_normals(turned, mesh.triangles);
        for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
            const Vec3 p = place(v);
            const int x = int(p.x() + .5f), y = int(p.y() + .5f);
            if (normals(v, 2) > 0.35f && p.z() > depth[std::size_t(y * kSize + x)] - 1.0f) visible[v] = true;
        }
    }
    return visible;
}

/// Where a marker may sit.
std::vector<std::uint32_t> face_front(const Actor& actor) {
    const Mesh& mesh = actor.neutral();
    const Landmarks& marks = actor.landmarks();
    std::vector<bool> skin(mesh.vertex_count(), false);
    const auto surfaces = mesh.triangle_surfaces();
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (std::uint32_t v : mesh.triangles[t])
            if (surfaces[t] == Surface::skin) skin[v] = true;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (std::uint32_t v : mesh.triangles[t])
            if (surfaces[t] != Surface::skin) skin[v] = false;  // rims of eyes and mouth
    const std::vector<bool> visible = visible_vertices(mesh);
    const float half_width = 0.5f * (marks.ear[1].x() - marks.ear[0].x());
    const float top = marks.glabella.y() + 0.85f * (marks.glabella.y() - marks.nose_tip.y());
    const float bottom = marks.chin.y() - 0.3f * (marks.nose_tip.y() - marks.chin.y());
    const float back = marks.ear[0].z() + 0.25f * (marks.cheek[0].z() - marks.ear[0].z());
    const auto open = [](const Vec3& p, const Line& upper, const Line& lower) {
        // Inside the opening between two lines that share their ends, seen from the front.
        const auto height = [&](const Line& line) {
            for (std::size_t i = 0; i + 1 < line.size(); ++i) {
                const Vec3 &a = line[i], &b = line[i + 1];
                if ((p.x() - a.x()) * (p.x() - b.x()) <= 0 && a.x() != b.x())
                    return a.y() + (b.y() - a.y()) * (p.x() - a.x()) / (b.x() - a.x());
            }
            return std::numeric_limits<float>::quiet_NaN();
        };
        return p.y() < height(upper) + 0.4f && p.y() > height(lower) - 0.4f;
    };
    std::vector<std::uint32_t> front;
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
        const Vec3 p = mesh.positions.row(v).transpose();
        if (!skin[v] || !visible[v] || p.y() > top || p.y() < bottom || p.z() < back || std::abs(p.x()) > 0.93f * half_width) continue;
        if (open(p, marks.upper_lip_line, marks.lower_lip_line) || open(p, marks.upper_lid[0], marks.lower_lid[0]) ||
            open(p, marks.upper_lid[1], marks.lower_lid[1]))
            continue;
        front.push_back(v);
    }
    return front;
}

Vec3 along(const Line& line, float s) {
    float length = 0;
    for (std::size_t i = 0; i + 1 < line.size(); ++i) length += (line[i + 1] - line[i]).norm();
    float left = s * length;
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
        const float step = (line[i + 1] - line[i]).norm();
        if (left <= step && step > 0) return line[i] + left / step * (line[i + 1] - line[i]);
        left -= step;
    }
    return line.back();
}

struct Row {
    Line line;
    float share;  // markers of it in a set of kMarkerCount
    Vec3 off;     // the row runs beside the line
};

std::vector<Row> rows_of(const Landmarks& marks) {
    std::vector<Row> rows = {{marks.upper_lip_outline, 11, {0, 0.8f, 0}}, {marks.lower_lip_outline, 11, {0, -0.8f, 0}}};
    for (int side : {0, 1}) {
        const float out = side == 0 ? -1.f : 1.f;
        rows.push_back({marks.upper_lid[side], 6, {0, 3.5f, 0}});
        rows.push_back({marks.lower_lid[side], 6, {0, -3.5f, 0}});
        rows.push_back({marks.brow[side], 6, {0, 0, 0}});
        const Vec3 corner = side == 0 ? marks.upper_lip_outline.front() : marks.upper_lip_outline.back();
        const Vec3 wing = marks.nostril[side] + Vec3(out * 9, 5, -6);
        rows.push_back({{wing, 0.55f * wing + 0.45f * corner + Vec3(out * 8, 1, -2), corner + Vec3(out * 9, -4, -4)}, 6, Vec3::Zero()});
        rows.push_back({{marks.nostril[side] + Vec3(out * 1, -2, 0), marks.nostril[side] + Vec3(out * 7, 2, -2)}, 2, Vec3::Zero()});
    }
    return rows;
}

}  // namespace

std::vector<Site> place_markers(const Actor& actor, int count, std::uint64_t seed) {
    const Points& points = actor.neutral().positions;
    const std::vector<std::uint32_t> front = face_front(actor);
    const auto want = std::min(std::size_t(std::max(count, 0)), front.size());
    std::vector<float> distance(front.size(), std::numeric_limits<float>::max());  // squared, to the nearest marker
    std::vector<Site> sites;
    const auto put = [&](std::size_t i) {
        sites.push_back(Site::at_vertex(front[i]));
        for (std::size_t k = 0; k < front.size(); ++k)
            distance[k] = std::min(distance[k], (points.row(front[k]) - points.row(front[i])).squaredNorm());
    };
    const float closest = 9.f * kMarkerCount / float(std::max(count, 1));  // markers keep apart: 3 mm in a set of 182
    for (const Row& row : rows_of(actor.landmarks())) {
        const int n = int(std::lround(row.share * float(count) / kMarkerCount));
        for (int i = 0; i < n && sites.size() < want; ++i) {
            const Vec3 wanted = along(row.line, n == 1 ? 0.5f : float(i) / float(n - 1)) + row.off;
            std::size_t nearest = front.size();
            float best = 36;  // within 6 mm
            for (std::size_t k = 0; k < front.size(); ++k) {
                const float d = (points.row(front[k]).transpose() - wanted).squaredNorm();
                if (d < best && distance[k] > closest) best = d, nearest = k;
            }
            if (nearest < front.size()) put(nearest);
        }
    }
    if (sites.empty() && want > 0) put(std::size_t(Random(seed).bits() % front.size()));
    // The seed decides between places that are about as far.
    std::vector<float> taste(front.size());
    Random random(seed);
    for (float& t : taste) t = random.uniform(0.9f, 1.0f);
    while (sites.size() < want) {
        std::size_t farthest = 0;
        for (std::size_t k = 1; k < front.size(); ++k)
            if (taste[k] * distance[k] > taste[farthest] * distance[farthest]) farthest = k;
        put(farthest);
    }
    return sites;
}

void add_faults(PointSequence& markers, const MarkerFaults& faults, Rational frame_rate, std::uint64_t seed) {
    const auto stream = [&](std::uint64_t kind, std::int64_t n) { return Random((seed * 2 + kind) * 0x9e3779b97f4a7c15ull + std::uint64_t(n) * 0xd1b54a32d192ed03ull); };
    if (faults.noise > 0)
        for (std::int64_t f = 0; f < markers.frames; ++f) {
            Random random = stream(0, f);
            for (std::int64_t i = 0; i < 3 * markers.points; ++i)
                markers.xyz[std::size_t(f * markers.points * 3 + i)] += float(faults.noise) * random.normal();
        }
    if (faults.missing > 0) {
        // A chain of two states; `leave` and `enter` are chances per frame whose balance is the share asked for.
        const double share = std::min(faults.missing, 0.9);
        const double leave = std::min(1.0, 1 / (0.15 * frame_rate.value())) * std::min(1.0, (1 - share) / share);
        const double enter = leave * share / (1 - share);
        for (std::int64_t m = 0; m < markers.points; ++m) {
            Random random = stream(1, m);
            bool lost = random.uniform() < share;
            for (std::int64_t f = 0; f < markers.frames; ++f) {
                if (lost) markers.frame(f).row(m).setConstant(std::numeric_limits<float>::quiet_NaN());
                lost = lost ? random.uniform() >= leave : random.uniform() < enter;
            }
        }
    }
}

}  // namespace mien::samples
