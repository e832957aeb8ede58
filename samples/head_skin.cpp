#include <map>

#include "samples/head_mesh.hpp"

namespace mien::samples {
namespace {

using Corner = HeadMeshBuilder::Corner;

constexpr double kArc = 72;  // mm of chart per radian of phi on the front

/// The one texture chart of the skin: an unrolled cylinder, the front at full size, the back of the head and
/// the neck smaller, narrowing towards the crown and the neck's end so that the small charts fit into the
/// corners.
Vec2d skin_chart(double phi, double t) {
    const double s = kArc * std::abs(phi), turn = 92, behind = 0.36;
    const double across =
        (std::min(s, turn) + behind * std::max(s - turn, 0.0)) / (turn + behind * (pi * kArc - turn));
    static const Spline up({-190, -160, -125, -100, 0, 60, 110, 160},
                           {0.012, 0.05, 0.115, 0.20, 0.57, 0.785, 0.88, 0.925});
    const double narrow = mix(1, 0.38, smooth_step(-99, -150, t)) * mix(1, 0.28, smooth_step(40, 135, t));
    return {0.5 + std::copysign(0.488 * across * narrow, phi), up(t)};
}

struct Rect {
    int i0, i1, j0, j1;
    bool strictly_inside(int i, int j) const { return i > i0 && i < i1 && j > j0 && j < j1; }
    bool cell(int i, int j) const { return i >= i0 && i < i1 && j >= j0 && j < j1; }
};

class SkinGrid {
public:
    SkinGrid(const HeadSurface& surface, HeadMeshBuilder& builder) : surface_(surface), builder_(builder) {
        columns_ = {0};
        for (const auto& [until, step] : {std::pair{22.0, 2.2}, {84.0, 3.9}, {pi * kArc, 7.4}}) {
            const double from = columns_.back();
            const int n = static_cast<int>(std::ceil((until - from) / step - 1e-9));
            for (int i = 1; i <= n; ++i) columns_.push_back(from + (until - from) * i / n);
        }
        half_ = static_cast<int>(columns_.size()) - 1;
        rows_ = {HeadSurface::kBottom};
        for (const auto& [until, step] : {std::pair{-150.0, 7.2},
                                          {-112.0, 4.6},
                                          {-50.0, 3.5},
                                          {-32.0, 1.65},
                                          {36.0, 3.5},
                                          {60.0, 4.8},
                                          {146.0, 7.2},
                                          {154.0, 4.0}}) {
            const double from = rows_.back();
            const int n = static_cast<int>(std::ceil((until - from) / step - 1e-9));
            for (int i = 1; i <= n; ++i) rows_.push_back(from + (until - from) * i / n);
        }
    }

    int columns() const { return 2 * half_; }
    int rows() const { return static_cast<int>(rows_.size()); }
    int middle() const { return half_; }
    double phi(int i) const { return i < half_ ? -columns_[half_ - i] / kArc : columns_[i - half_] / kArc; }
    double t(int j) const { return rows_[j]; }
    /// The first row and column (from the midline to the left) at or beyond a place.
    int column_at(double s) const {
        return half_ + int(std::lower_bound(columns_.begin(), columns_.end(), s) - columns_.begin());
    }
    int row_at(double t) const {
        return int(std::lower_bound(rows_.begin(), rows_.end(), t) - rows_.begin());
    }
    Rect mirrored(const Rect& r) const { return {2 * half_ - r.i1, 2 * half_ - r.i0, r.j0, r.j1}; }

    void build(const std::vector<Rect>& holes) {
        const int C = columns(), R = rows();
        corners_.assign(std::size_t(C + 1) * R, Corner{~0u, ~0u});
        for (int j = 0; j < R; ++j)
            for (int i = 0; i <= C; ++i) {
                if (std::any_of(holes.begin(), holes.end(),
                                [&](const Rect& r) { return r.strictly_inside(i, j); }))
                    continue;
                Vec3d p = surface_.skin(std::abs(phi(i)), t(j));
                if (i == half_ || i == 0 || i == C) p.x() = 0;
                if (i < half_) p.x() = -p.x();
                const std::uint32_t v = i == C ? at(0, j).first : builder_.vertex(with_hair(p));
                corners_[std::size_t(j) * (C + 1) + i] = {v, builder_.texcoord(skin_chart(phi(i), t(j)))};
            }
        for (int j = 0; j + 1 < R; ++j)
            for (int i = 0; i < C; ++i)
                if (std::none_of(holes.begin(), holes.end(), [&](const Rect& r) { return r.cell(i, j); }))
                    quad(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
        const std::uint32_t crown = builder_.vertex(with_hair(surface_.loft(0, HeadSurface::kTop)));
        for (int i = 0; i < C; ++i) {
            const double between = (phi(i) + phi(i + 1)) / 2;
            builder_.triangle(Surface::hair, at(i, R - 1), at(i + 1, R - 1),
                              {crown, builder_.texcoord(skin_chart(between, HeadSurface::kTop))});
        }
    }

    /// The hole's border, counter-clockwise seen from outside, starting in the middle of the side of greatest
    /// column; `mirror`: the mirror image of that loop.
    std::vector<Corner> border(Rect r, bool mirror) const {
        std::vector<Corner> loop;
        const Rect side = mirror ? mirrored(r) : r;
        const int jm = (side.j0 + side.j1) / 2;
        const auto add = [&](int i, int j) { loop.push_back(at(mirror ? 2 * half_ - i : i, j)); };
        for (int j = jm; j < side.j1; ++j) add(side.i1, j);
        for (int i = side.i1; i > side.i0; --i) add(i, side.j1);
        for (int j = side.j1; j > side.j0; --j) add(side.i0, j);
        for (int i = side.i0; i < side.i1; ++i) add(i, side.j0);
        for (int j = side.j0; j < jm; ++j) add(side.i1, j);
        return loop;
    }

    /// A place of the skin with the hair that grows there: the scalp itself is lifted.
    Vec3d with_hair(const Vec3d& p) {
        const double lift = hair_lift(p);
        if (lift == 0) return p;
        bare_.emplace(builder_.vertex_count(), p);
        // Out from an axis through the head; over the forehead up and back, as it is combed.
        const double down = smooth_step(70, -20, p.y());
        return p + lift * Vec3d(p.x(), (1 - down) * (p.y() - 5), 0.75 * (p.z() + 13)).normalized();
    }
    /// A quad of skin, or of hair where any of its corners is lifted.
    void quad(Corner a, Corner b, Corner c, Corner d) {
        const bool hair = bare_.contains(a.first) || bare_.contains(b.first) || bare_.contains(c.first) ||
                          bare_.contains(d.first);
        builder_.quad(hair ? Surface::hair : Surface::skin, a, b, c, d);
    }

    /// Stitches loop `inner` into loop `outer`.
    void band(Surface surface, const std::vector<Corner>& outer, const std::vector<Corner>& inner,
              bool mirror) {
        const int n = static_cast<int>(outer.size());
        for (int k = 0; k < n; ++k) {
            const int l = (k + 1) % n;
            const Corner &a = outer[mirror ? l : k], &b = outer[mirror ? k : l], &c = inner[mirror ? k : l],
                         &d = inner[mirror ? l : k];
            if (surface == Surface::skin)
                quad(a, b, c, d);
            else
                builder_.quad(surface, a, b, c, d);
        }
    }
    void cap(Surface surface, const std::vector<Corner>& loop, Corner centre, bool mirror) {
        const int n = static_cast<int>(loop.size());
        for (int k = 0; k < n; ++k) {
            const int l = (k + 1) % n;
            if (mirror)
                builder_.triangle(surface, loop[l], loop[k], centre);
            else
                builder_.triangle(surface, loop[k], loop[l], centre);
        }
    }
    Vec3d bare(const Corner& c) const {
        const auto found = bare_.find(c.first);
        return found == bare_.end() ? builder_.position(c.first) : found->second;
    }
    const Corner& at(int i, int j) const { return corners_[std::size_t(j) * (columns() + 1) + i]; }

private:
    const HeadSurface& surface_;
    HeadMeshBuilder& builder_;
    std::vector<double> columns_, rows_;  // s >= 0 of the left half; t
    int half_ = 0;
    std::vector<Corner> corners_;
    std::map<std::uint32_t, Vec3d> bare_;  // where vertices that hair lifts were
};

Vec3d flip(const Vec3d& p, bool mirror) {
    return mirror ? Vec3d(-p.x(), p.y(), p.z()) : p;
}

void remember(Loops& loops, const std::vector<Corner>& ring) {
    loops.rings.emplace_back();
    for (const Corner& c : ring) loops.rings.back().push_back(c.first);
}

/// Chart of a frontal place; x may be negative.
Vec2d chart_of_front(const HeadSurface& surface, double x, double y) {
    const Vec2d at = surface.from_front(std::abs(x), y);
    return skin_chart(std::copysign(at[0], x), at[1]);
}

/// How far along a half loop (0 .. 1 for k of n/2) from one corner to the other: evenly, a little closer at
/// the corners.
double along(double f) {
    return mix(f, 0.5 - 0.5 * std::cos(pi * f), 0.45);
}

/// Paths from the skin grid to the rim of an opening that arrive at right angles to it.
struct Path {
    Vec2d from, control, to;
    Vec2d at(double w) const { return square(1 - w) * from + 2 * w * (1 - w) * control + w * w * to; }
};

std::vector<Path> paths(const std::vector<Vec2d>& from, const std::vector<Vec2d>& to, double bend) {
    const int n = static_cast<int>(from.size());
    std::vector<Path> result(n);
    for (int k = 0; k < n; ++k) {
        const Vec2d back = (to[k] - to[(k + n - 1) % n]).normalized(),
                    on = (to[(k + 1) % n] - to[k]).normalized();
        const Vec2d tangent =
            (back + on).normalized();  // counter-clockwise, so the outside lies to its right
        result[k] = {from[k], to[k] + bend * (from[k] - to[k]).norm() * Vec2d(tangent.y(), -tangent.x()),
                     to[k]};
    }
    return result;
}

void add_lids(const HeadSurface& surface, SkinGrid& grid, HeadMeshBuilder& builder, const Rect& rect,
              int side, HeadMesh& head) {
    const bool mirror = side == 0;
    std::vector<Corner> outer = grid.border(rect, mirror);
    const int n = static_cast<int>(outer.size());
    Loops& loops = head.lids[side];
    remember(loops, outer);
    const Vec3d eye = surface.eye_centre();
    std::vector<Vec2d> from(n), to(n), chart(n);
    for (int k = 0; k < n; ++k) {
        // Frontal place on the loft: the sculpted grid is moved only in depth around the eyes.
        const Vec3d p = builder.position(outer[k].first);
        from[k] = {std::abs(p.x()), p.y()};
        const bool upper = k <= n / 2;
        const double f = upper ? k / (n / 2.0) : (n - k) / (n / 2.0);
        to[k] = surface.lid_margin(upper, 1 - along(f));
        chart[k] = chart_of_front(surface, mirror ? -to[k].x() : to[k].x(), to[k].y());
    }
    const std::vector<Path> path = paths(from, to, 0.4);
    const Vec2d middle = chart_of_front(surface, mirror ? -31 : 31, 0);
    std::vector<Vec3d> margin(n);
    for (int r = 1; r <= HeadMesh::kLidMargin + 3; ++r) {
        std::vector<Corner> ring(n);
        for (int k = 0; k < n; ++k) {
            if (r <= HeadMesh::kLidMargin) {
                const Vec2d xy = path[k].at(double(r) / HeadMesh::kLidMargin);
                margin[k] = surface.front(xy.x(), xy.y());
                ring[k] = builder.corner(flip(margin[k], mirror),
                                         chart_of_front(surface, mirror ? -xy.x() : xy.x(), xy.y()));
                continue;
            }
            const int under = r - HeadMesh::kLidMargin;
            const Vec3d d = margin[k] - eye;
            const double radius = d.norm(), skim = surface.proportions().eye_radius + 0.25;
            const double polar = std::acos(std::clamp(d.z() / radius, -1.0, 1.0)) + (under == 1   ? -0.02
                                                                                     : under == 2 ? 0.12
                                                                                                  : 0.4);
            const double reach = under == 1 ? std::max(skim, radius - 1.6) : skim + (under == 3 ? 0.35 : 0.1);
            const double xy = std::hypot(d.x(), d.y());
            const Vec3d p = eye + reach * Vec3d(d.x() / xy * std::sin(polar), d.y() / xy * std::sin(polar),
                                                std::cos(polar));
            ring[k] = builder.corner(flip(p, mirror), chart[k] + (middle - chart[k]) * (0.16 * under));
        }
        grid.band(Surface::skin, outer, ring, mirror);
        remember(loops, ring);
        outer = ring;
    }
}

void add_nostril(SkinGrid& grid, HeadMeshBuilder& builder, const Rect& rect, int side, HeadMesh& head) {
    const bool mirror = side == 0;
    std::vector<Corner> outer = grid.border(rect, mirror);
    remember(head.nostrils[side], outer);
    Vec3d centre = Vec3d::Zero();
    Vec2d middle = Vec2d::Zero();
    for (const Corner& c : outer) {
        centre += builder.position(c.first) / double(outer.size());
        middle += builder.uv(c.second) / double(outer.size());
    }
    const std::vector<Corner> border = outer;
    // From the grid's rectangle to an oval, then up into the nose.
    const Vec3d across =
        (builder.position(border[0].first) - builder.position(border[border.size() / 2].first)).normalized();
    const Vec3d up(0, 0.93, -0.36);
    Vec3d deep = (builder.position(border[border.size() / 4].first) -
                  builder.position(border[3 * border.size() / 4].first));
    deep = (deep - deep.dot(across) * across).normalized();
    // Longer than wide, their front ends nearer to each other.
    constexpr double kTurn = 0.42;
    const Vec3d wide = std::cos(kTurn) * across + std::sin(kTurn) * deep, ahead = std::cos(kTurn) * deep - std::sin(kTurn) * across;
    constexpr double kRound[] = {0.75, 1, 1, 1}, kScale[] = {1.0, 0.9, 0.8, 0.6}, kOnSkin[] = {1, 0.8, 0.4, 0},
                     kDepth[] = {0.1, 1.0, 3.8, 6.5}, kChart[] = {0.8, 0.64, 0.48, 0.3};
    for (int r = 0; r < 4; ++r) {
        std::vector<Corner> ring;
        for (const Corner& c : border) {
            const Vec3d off = builder.position(c.first) - centre, flat = off.dot(across) * across + off.dot(deep) * deep;
            const double a = std::atan2(off.dot(ahead) / 5.0, off.dot(wide) / 3.3);
            const Vec3d oval = 2.5 * std::cos(a) * wide + 4.1 * std::sin(a) * ahead;
            const Vec3d p = centre + kScale[r] * (0.85 * (1 - kRound[r]) * flat + kRound[r] * oval) +
                            kOnSkin[r] * (off - flat) + kDepth[r] * up;
            ring.push_back(builder.corner(p, middle + kChart[r] * (builder.uv(c.second) - middle)));
        }
        grid.band(Surface::skin, outer, ring, mirror);
        remember(head.nostrils[side], ring);
        outer = ring;
    }
    grid.cap(Surface::skin, outer, builder.corner(centre + 7.0 * up, middle), mirror);
}

void add_ear(const HeadSurface& surface, SkinGrid& grid, HeadMeshBuilder& builder, const Rect& rect, int side,
             HeadMesh& head) {
    // The actor's left ear seen from outside has the face on its left: its loop starts at the greatest
    // column, which is the back; the loop of ear_point starts in front.
    const bool mirror = side == 0;
    std::vector<Corner> outer = grid.border(rect, mirror);
    const int n = static_cast<int>(outer.size());
    remember(head.ears[side], outer);
    Vec2d middle = Vec2d::Zero();
    for (const Corner& c : outer) middle += builder.uv(c.second) / n;
    const std::vector<Corner> border = outer;
    // Where each of the grid's vertices around the ear is, before its hair.
    std::vector<Vec3d> bare(n);
    for (int k = 0; k < n; ++k) bare[k] = flip(grid.bare(border[k]), mirror);
    const auto chart = [&](int k, double shrink) -> Vec2d {
        return middle + shrink * (builder.uv(border[k].second) - middle);
    };
    const auto place = [&](int r, int k) {
        // Ring by ring from the direction of the grid's vertex to an even spread.
        const double even = pi - 2 * pi * k / n, turn = std::remainder(ear_angle(bare[k]) - even, 2 * pi);
        return ear_point(surface, r, even + turn * std::max(1 - r / 5.0, 0.0));
    };
    constexpr int kAround = 3;  // rings of scalp and cheek between the grid and the ear
    constexpr double kEarChart = 0.70;
    for (int r = 1; r < kAround; ++r) {
        std::vector<Corner> ring;
        const double w = double(r) / kAround;
        for (int k = 0; k < n; ++k) {
            const Vec3d foot = place(0, k);
            const Vec3d p = surface.side(mix(bare[k].y(), foot.y(), w), mix(bare[k].z(), foot.z(), w));
            ring.push_back(builder.corner(grid.with_hair(flip(p, mirror)), chart(k, mix(1, kEarChart, w))));
        }
        grid.band(Surface::skin, outer, ring, mirror);
        outer = ring;
    }
    for (int r = 0; r < kEarRings; ++r) {
        std::vector<Corner> ring;
        for (int k = 0; k < n; ++k)
            ring.push_back(builder.corner(flip(place(r, k), mirror), chart(k, kEarChart * (1 - 0.94 * r / kEarRings))));
        grid.band(Surface::skin, outer, ring, mirror);
        remember(head.ears[side], ring);
        outer = ring;
    }
    Vec3d centre = Vec3d::Zero();
    for (const Corner& c : outer) centre += builder.position(c.first) / n;
    grid.cap(Surface::skin, outer, builder.corner(centre, middle), mirror);
}

void add_mouth(const HeadSurface& surface, SkinGrid& grid, HeadMeshBuilder& builder, const Rect& rect,
               HeadMesh& head) {
    std::vector<Corner> outer = grid.border(rect, false);
    const int n = static_cast<int>(outer.size()), half = n / 2;
    remember(head.mouth, outer);
    const double w = surface.mouth_half_width(), lips = surface.proportions().lips;
    struct Profile {
        Vec2d from, border;    // frontal
        double x, sign, full;  // place along the lips, +1 upper, -1 lower; 0 at the corners, 1 in the middle
    };
    std::vector<Profile> profiles(n);
    for (int k = 0; k < n; ++k) {
        const Vec3d p = builder.position(outer[k].first);
        const bool upper = k <= half;
        const double f = upper ? double(k) / half : double(n - k) / half;
        double x = w * (1 - 2 * along(f));
        if (k == n / 4 || k == n - n / 4) x = 0;
        const double a = std::min(std::abs(x), w);
        const double y = k % half == 0 ? surface.lip_line(w)
                         : upper       ? surface.upper_border(a)
                                       : surface.lower_border(a);
        profiles[k] = {{p.x(), p.y()},
                       {std::copysign(a + (k % half == 0 ? 0.8 : 0.0), x), y},
                       x,
                       k % half == 0 ? 0.0
                       : upper       ? 1.0
                                     : -1.0,
                       std::pow(std::max(1 - square(a / w), 0.0), 0.8)};
    }
    std::vector<Vec2d> from, to;
    for (const Profile& q : profiles) from.push_back(q.from), to.push_back(q.border);
    const std::vector<Path> path = paths(from, to, 0.35);
    for (int r = 1; r <= HeadMesh::kInnerLip; ++r) {
        std::vector<Corner> ring(n);
        for (int k = 0; k < n; ++k) {
            const Profile& q = profiles[k];
            const auto front = [&](double x, double y) { return flip(surface.front(std::abs(x), y), x < 0); };
            if (r <= HeadMesh::kLipBorder) {
                const Vec2d xy = path[k].at(double(r) / HeadMesh::kLipBorder);
                ring[k] = builder.corner(front(xy.x(), xy.y()), chart_of_front(surface, xy.x(), xy.y()));
                continue;
            }
            // Over the lip: from the border it swells and rolls in to the line where the lips meet, then
            // behind it.
            const Vec3d edge = front(q.border.x(), q.border.y());
            const double line = surface.lip_line(std::abs(q.x)), line_z = front(q.x, line).z();
            const double f =
                double(r - HeadMesh::kLipBorder) / (HeadMesh::kLipContact - HeadMesh::kLipBorder);
            const double height = q.border.y() - line;
            Vec3d p;
            const double swell = (q.sign > 0 ? 2.0 : 3.6) * lips * q.full, recess = mix(0.2, 2.4, q.full);
            if (f <= 1) {
                // First forward and on, last straight in, behind the fullest part of the lip.
                const double y = line + height * (1 - std::pow(f, 1.25)) + q.sign * 0.06 * f;
                const double z = mix(edge.z(), line_z, f) + swell * std::sin(pi * std::pow(f, 0.8)) -
                                 recess * std::pow(f, 3);
                p = {mix(q.border.x(), q.x, f), y, z};
            } else {
                const double in = 5 * (f - 1);  // 1, 2
                p = {q.x * (1 - 0.02 * in), line + q.sign * (0.06 + (0.5 * in * in) * std::max(q.full, 0.15)),
                     line_z - recess - 1.6 * in};
            }
            // The chart opens the line into a slit.
            const double open = std::abs(height) * (0.28 * std::min(f, 1.0) - 0.2 * std::max(f - 1, 0.0));
            ring[k] = builder.corner(
                p, chart_of_front(
                       surface,
                       mix(q.border.x(), q.x, std::min(f, 1.4) * (q.sign == 0 ? 0.5 : std::min(1 / f, 1.0))),
                       (f < 1 ? p.y() : line) + q.sign * open));
        }
        grid.band(Surface::skin, outer, ring, false);
        remember(head.mouth, ring);
        outer = ring;
    }
    // The bag: out around the teeth, then to the throat. A chart of its own, a disc.
    builder.part("mouth");
    const Vec2d disc(0.062, 0.062);
    const double radius = 0.048;
    // off: how far outside the upper teeth's arch the wall stands, mm; in front of `deepest` it is not.
    constexpr struct {
        double width, up, down, off, front, chart;
    } kBag[] = {{30, 8, 8, 3.0, 97.5, 0.88}, {33, 18, 17, 5.0, 94, 0.76}, {36, 24, 24, 9, 81, 0.62},
                {36, 23, 26, 9, 62, 0.46},   {28, 18, 20, 0, 45, 0.3},    {14, 9, 10, 0, 36, 0.15}};
    const auto angle = [&](int k) { return 2 * pi * k / n; };
    for (Corner& c : outer) {
        const int k = static_cast<int>(&c - outer.data());
        c.second = builder.texcoord(disc + radius * Vec2d(std::cos(angle(k)), std::sin(angle(k))));
    }
    const std::vector<Corner> lip = outer;
    for (const auto& b : kBag) {
        std::vector<Corner> ring;
        for (int k = 0; k < n; ++k) {
            const double c = std::cos(angle(k)), s = std::sin(angle(k));
            // The dental arch bends back towards the sides, and the bag with it.
            const double z = b.front < 60 ? b.front : b.front - (kUpperArch.z(0, b.off) - kUpperArch.z(b.width * c, b.off)) * smooth_step(30, 80, b.front);
            Vec3d p(b.width * c, -71 + (s > 0 ? b.up : b.down) * s, z);
            if (k == n / 4 || k == n - n / 4) p.x() = 0;
            ring.push_back(builder.corner(p, disc + radius * b.chart * Vec2d(c, s)));
        }
        grid.band(Surface::mouth, outer, ring, false);
        remember(head.mouth, ring);
        outer = ring;
    }
    grid.cap(Surface::mouth, outer, builder.corner({0, -72, 33}, disc), false);
}

}  // namespace

void add_skin(const HeadSurface& surface, HeadMeshBuilder& builder, HeadMesh& head) {
    SkinGrid grid(surface, builder);
    const auto even = [](int a, int b) { return (b - a) % 2 == 0 ? b : b + 1; };
    // Mouth: about the midline, an even number of rows so that the corners of the mouth have a vertex.
    const int mi = grid.column_at(38) - grid.middle();
    const Rect mouth{grid.middle() - mi, grid.middle() + mi, grid.row_at(-93),
                     even(grid.row_at(-93), grid.row_at(-53))};
    const double e = HeadProportions{}.eye_x;
    const Rect eye{grid.column_at(e - 21), grid.column_at(e + 22), grid.row_at(-19),
                   even(grid.row_at(-19), grid.row_at(17))};
    const Rect nostril{grid.column_at(3.2), grid.column_at(10.9), grid.row_at(-45.5),
                       even(grid.row_at(-45.5), grid.row_at(-40.7))};
    const Rect ear{grid.column_at(100), grid.column_at(148), grid.row_at(-98),
                   even(grid.row_at(-98), grid.row_at(20))};
    builder.part("skin");
    grid.build({mouth, eye, grid.mirrored(eye), nostril, grid.mirrored(nostril), ear, grid.mirrored(ear)});
    for (int side = 0; side < 2; ++side) {
        add_lids(surface, grid, builder, side ? eye : grid.mirrored(eye), side, head);
        add_nostril(grid, builder, side ? nostril : grid.mirrored(nostril), side, head);
        add_ear(surface, grid, builder, side ? ear : grid.mirrored(ear), side, head);
    }
    add_mouth(surface, grid, builder, mouth, head);
}

}  // namespace mien::samples
