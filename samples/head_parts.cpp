#include <array>

#include "samples/head_mesh.hpp"

namespace mien::samples {
namespace {

using Corner = HeadMeshBuilder::Corner;

/// Rows of corners, every row with the same count; stitched with the outside to the left of increasing column
/// seen with rows going down.
void sheet(HeadMeshBuilder& builder, const std::vector<std::vector<Corner>>& rows,
           const std::vector<Surface>& surfaces, bool closed) {
    for (std::size_t r = 0; r + 1 < rows.size(); ++r) {
        const std::size_t n = rows[r].size() - (closed ? 0 : 1);
        for (std::size_t i = 0; i < n; ++i) {
            const std::size_t j = (i + 1) % rows[r].size();
            builder.quad(surfaces[r], rows[r + 1][i], rows[r + 1][j], rows[r][j], rows[r][i]);
        }
    }
}

/// Mesiodistal crown widths, mm, from the central incisor back (Wheeler's Dental Anatomy, rounded).
constexpr std::array kUpperCrowns = {8.5, 6.5, 7.5, 7.0, 7.0, 10.0, 9.0};
constexpr std::array kLowerCrowns = {5.4, 6.0, 7.0, 7.0, 7.0, 11.0, 10.5};

struct Row {
    double out, y;   ///< off the arch line, mm; height from the biting edge, mm, > 0 towards the gum
    double between;  ///< how far out sinks between two teeth
    double scallop;  ///< how far y moves towards the edge between two teeth
};

void add_arch(HeadMeshBuilder& builder, VertexRange& range, bool upper) {
    const DentalArch arch = upper ? kUpperArch : kLowerArch;
    const double edge = upper ? kUpperEdge : kLowerEdge, sign = upper ? 1 : -1;
    const auto& crowns = upper ? kUpperCrowns : kLowerCrowns;
    // Arc length along half the arch, from the midline.
    std::vector<double> length = {0}, angle = {0};
    for (int i = 1; i <= 900; ++i) {
        const double a = pi / 2 * i / 900;
        length.push_back(length.back() + (arch.at(a) - arch.at(angle.back())).norm());
        angle.push_back(a);
    }
    double total = 0;
    for (const double c : crowns) total += c;
    struct Column {
        double angle, in_tooth;  // in_tooth: -1 .. 1 across the crown
        int tooth;
    };
    std::vector<Column> columns;
    double start = 0;
    for (std::size_t tooth = 0; tooth + 1 < crowns.size(); ++tooth) {  // nobody sees the last molar
        for (const double w : {-0.93, -0.5, 0.5, 0.93}) {
            const double at = std::min((start + crowns[tooth] * (w + 1) / 2) * 0.985 * length.back() / total,
                                       length.back());
            const std::size_t i = std::clamp<std::size_t>(
                std::lower_bound(length.begin(), length.end(), at) - length.begin(), 1, 900);
            columns.push_back(
                {mix(angle[i - 1], angle[i], (at - length[i - 1]) / (length[i] - length[i - 1])), w,
                 int(tooth)});
        }
        start += crowns[tooth];
    }
    constexpr std::array<Row, 11> kRows = {{{-0.6, 18.5, 0.0, 0.0},
                                            {0.9, 13.5, 0.25, 0.2},
                                            {1.0, 11.0, 0.35, 1.0},
                                            {0.45, 10.0, 0.5, 1.9},
                                            {0.95, 7.8, 0.75, 1.2},
                                            {1.1, 4.0, 0.85, 0.2},
                                            {0.7, 0.9, 0.9, 0},
                                            {0.05, 0.0, 0.7, -0.5},
                                            {-1.1, 0.5, -0.2, -0.5},
                                            {-3.8, 7.2, -0.5, 0},
                                            {-5.2, 16, 0, 0}}};
    const Vec2d chart = upper ? Vec2d(0.19, 0.945) : Vec2d(0.51, 0.945);
    const Vec2d chart_size(0.30, 0.045);
    std::vector<std::vector<Corner>> rows;
    std::vector<Surface> surfaces;
    range.first = builder.vertex_count();
    for (std::size_t r = 0; r < kRows.size(); ++r) {
        std::vector<Corner> row;
        const int n = static_cast<int>(columns.size());
        for (int i = -n; i < n; ++i) {
            const Column& c = columns[i < 0 ? -i - 1 : i];
            const double side = i < 0 ? -1 : 1;
            const double gap = std::pow(std::abs(c.in_tooth), 5);
            // Canines and premolars are pointed, molars blunt; lateral incisors a little shorter.
            const double molar = smooth_step(2, 5, c.tooth), point = c.tooth == 2                   ? 0.9
                                                                     : c.tooth == 3 || c.tooth == 4 ? 0.5
                                                                                                    : 0;
            double y = kRows[r].y - kRows[r].scallop * gap;
            if (r >= 5 && r <= 8)
                y += (c.tooth == 1 ? 0.7 : 0.0) * (upper ? 1 : 0.3) -
                     point * (1 - std::abs(c.in_tooth)) * 0.8 + 0.6 * molar;
            if (!upper) y *= 0.93;
            double out = kRows[r].out - kRows[r].between * gap;
            if (r >= 8) out -= 3.5 * molar * (r == 8 ? 1.3 : 1);
            // Teeth lean forward in front.
            const Vec2d on = arch.at(c.angle), out_of = arch.normal(c.angle);
            const Vec3d normal(out_of.x(), 0, out_of.y());
            const double lean = 0.10 * std::cos(c.angle) * (8 - y);
            const Vec3d p = Vec3d(on.x(), edge + sign * y, on.y()) + (out + lean) * normal;
            const double u = 0.5 + side * (std::abs(double(i < 0 ? -i - 1 : i)) + 0.5) / (2.0 * n);
            row.push_back(builder.corner(
                {side * p.x(), p.y(), p.z()},
                chart + Vec2d(chart_size.x() * u, chart_size.y() * (upper ? 1 - r / 10.0 : r / 10.0))));
        }
        rows.push_back(row);
        surfaces.push_back(r < 3 || r > 8 ? Surface::mouth : Surface::teeth);
    }
    if (!upper) {
        std::reverse(rows.begin(), rows.end());
        surfaces.pop_back();
        std::reverse(surfaces.begin(), surfaces.end());
    }
    sheet(builder, rows, surfaces, false);
    range.count = builder.vertex_count() - range.first;
}

}  // namespace

void add_eyeballs(const HeadSurface& surface, HeadMeshBuilder& builder, HeadMesh& head) {
    for (int side = 0; side < 2; ++side) {
        builder.part(side ? "eye_left" : "eye_right");
        VertexRange& range = head.eyeballs[side];
        range.first = builder.vertex_count();
        const double sign = side ? 1 : -1, radius = surface.proportions().eye_radius;
        const Vec3d eye(sign * surface.eye_centre().x(), surface.eye_centre().y(), surface.eye_centre().z());
        const Vec2d disc(side ? 0.912 : 0.088, 0.912);
        constexpr int kAround = 32, kRings = 17;
        const auto chart = [&](double polar) { return 0.076 * std::pow(polar / 2.4, 0.58); };
        std::vector<std::vector<Corner>> rows;
        for (int r = 1; r <= kRings; ++r) {
            const double polar = 2.4 * std::pow(double(r) / kRings, 1.15);
            std::vector<Corner> row;
            for (int i = 0; i < kAround; ++i) {
                const double a = 2 * pi * (side ? i : -i) / kAround;
                row.push_back(builder.corner(
                    eye + radius * Vec3d(sign * std::cos(side ? a : -a) * std::sin(polar),
                                         std::sin(side ? a : -a) * std::sin(polar), std::cos(polar)),
                    disc + chart(polar) * Vec2d(sign * std::cos(a), std::sin(side ? a : -a))));
            }
            rows.push_back(row);
        }
        const Corner pole = builder.corner(eye + Vec3d(0, 0, radius), disc);
        const auto turn = [&](Corner a, Corner b, Corner c, Corner d) {
            if (side)
                builder.quad(Surface::eye, a, b, c, d);
            else
                builder.quad(Surface::eye, d, c, b, a);
        };
        for (int r = 0; r + 1 < kRings; ++r)
            for (int i = 0; i < kAround; ++i)
                turn(rows[r][i], rows[r + 1][i], rows[r + 1][(i + 1) % kAround], rows[r][(i + 1) % kAround]);
        for (int i = 0; i < kAround; ++i) {
            const Corner a = rows[0][i], b = rows[0][(i + 1) % kAround];
            if (side)
                builder.triangle(Surface::eye, pole, a, b);
            else
                builder.triangle(Surface::eye, pole, b, a);
        }
        range.count = builder.vertex_count() - range.first;
    }
}

void add_teeth(const HeadSurface&, HeadMeshBuilder& builder, HeadMesh& head) {
    builder.part("upper_teeth");
    add_arch(builder, head.upper_teeth, true);
    builder.part("lower_teeth");
    add_arch(builder, head.lower_teeth, false);
    builder.part("tongue");
    head.tongue.first = builder.vertex_count();
    const Vec2d disc(0.945, 0.055);
    constexpr int kAround = 20, kRings = 12;
    std::vector<std::vector<Corner>> rows;
    const auto place = [](double polar, double a) {
        // An egg lying from the throat to behind the lower incisors, grooved along its middle.
        const double f = std::cos(polar), s = std::sin(polar);
        const double x = 19.0 * std::pow(s, 0.8) * std::cos(a), up = std::sin(a);
        return Vec3d(
            x, -78.0 + 6.5 * s * up - 3 * square(1 - f) * 0.5 + (up > 1e-9 ? -1.4 * bell(x, 0, 3) * s : 0.0),
            65 + 23 * f);
    };
    for (int r = 1; r < kRings; ++r) {
        const double polar = pi * r / kRings;
        std::vector<Corner> row;
        for (int i = 0; i < kAround; ++i) {
            const double a = 2 * pi * i / kAround;
            row.push_back(builder.corner(
                place(polar, a), disc + 0.042 * (r / double(kRings)) * Vec2d(std::cos(a), std::sin(a))));
        }
        rows.push_back(row);
    }
    const Corner tip = builder.corner(place(0, 0), disc), root = builder.corner(place(pi, 0), disc);
    for (std::size_t r = 0; r + 1 < rows.size(); ++r)
        for (int i = 0; i < kAround; ++i)
            builder.quad(Surface::mouth, rows[r][i], rows[r + 1][i], rows[r + 1][(i + 1) % kAround],
                         rows[r][(i + 1) % kAround]);
    for (int i = 0; i < kAround; ++i) {
        builder.triangle(Surface::mouth, tip, rows.front()[i], rows.front()[(i + 1) % kAround]);
        const double a = 2 * pi * (i + 0.5) / kAround;
        const Corner end{root.first, builder.texcoord(disc + 0.042 * Vec2d(std::cos(a), std::sin(a)))};
        builder.triangle(Surface::mouth, rows.back()[(i + 1) % kAround], rows.back()[i], end);
    }
    head.tongue.count = builder.vertex_count() - head.tongue.first;
}

}  // namespace mien::samples
