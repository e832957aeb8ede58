#include "samples/head_muscles.hpp"

#include <functional>

namespace mien::samples {
namespace {

/// One shape of the actor's left half or of both: p with x as it is on the left, place likewise. The right
/// half of a pair is its mirror image.
using Field = std::function<Vec3d(const Vec3d& p, const MouthPlace& m)>;

/// Full on the left, none on the right, soft across the midline.
double left(double x, double soft = 9) {
    return smooth_step(-soft, soft, x);
}
double gauss(double x, double width) {
    return std::exp(-0.5 * square(x / width));
}

/// The pull of the muscles that end in the left corner of the mouth: strongest there, spreading into lips and
/// cheek.
double corner(const MouthPlace& m, double reach = 17) {
    const double on = std::pow(std::clamp(m.along, 0.0, 1.0), 1.7);
    const double beyond = gauss(std::max(m.x - 25, 0.0), reach);
    return on * beyond * gauss(m.above, reach) * left(m.x, 12);
}
/// All skin around the mouth.
double around(const MouthPlace& m, double reach) {
    return gauss(m.distance, reach);
}
/// Upper or lower lip with the skin next to it, fading over `reach` mm.
double upper_lip(const MouthPlace& m, double reach) {
    return m.upper * gauss(std::max(m.above, 0.0), reach) * smooth_step(1.06, 0.4, m.along);
}
double lower_lip(const MouthPlace& m, double reach) {
    return (1 - m.upper) * gauss(std::max(-m.above, 0.0), reach) * smooth_step(1.06, 0.4, m.along);
}
/// Middle of the left half of a lip.
double left_lip(const MouthPlace& m) {
    return left(m.x, 10) * mix(1, 0.55, gauss(m.along, 0.25));
}

Vec3d smile(const Vec3d& p, const MouthPlace& m) {
    const double cheek = bell(p.x(), p.y(), 41, -36, 13, 12), pull = corner(m);
    // The cheek is pushed up and forward and folds over a furrow that runs down from the nose's wing.
    const double furrow_x = mix(20, 35, smooth_step(-40, -72, p.y()));
    const double furrow =
        bell(p.x(), furrow_x, 3.2) * smooth_step(-38, -48, p.y()) * smooth_step(-80, -66, p.y());
    return pull * Vec3d(6.5, 7.0, -5.0) + cheek * Vec3d(0.8, 3.6, 3.4) - furrow * Vec3d(0, 0, 1.3) +
           0.9 * around(m, 8) * left(m.x) * Vec3d(0, 0.5, -0.9);
}

/// Lips pulled towards and around the line between them by share t of their height.
Vec3d thin(const MouthPlace& m, double t) {
    const double lips = gauss(std::max(std::abs(m.above) - 7, 0.0), 3) * smooth_step(1.3, 0.7, m.along);
    return lips * Vec3d(0, -t * m.above, -1.6 * t * (1 - m.lip));
}

/// A lip turned in between the teeth.
Vec3d roll(const MouthPlace& m, double share, double depth) {
    const double lips = gauss(std::max(std::abs(m.above) - 6, 0.0), 3.5) * smooth_step(1.15, 0.6, m.along);
    return share * lips * Vec3d(0, -0.45 * m.above, -depth * mix(0.55, 1, m.lip));
}

struct Named {
    const char* name;
    bool both;  ///< one field for both halves (as it stands), or a Left/Right pair
    Field field;
};

std::vector<Named> fields() {
    return {
        {"MouthSmile", false, smile},
        {"MouthFrown", false,
         [](const Vec3d& p, const MouthPlace& m) -> Vec3d {
             return corner(m) * Vec3d(0.8, -7.5, -1.5) +
                    left(p.x()) * bell(p.x(), p.y(), 6, -97, 11, 7) * Vec3d(0, 1.5, 1.0);
         }},
        {"MouthDimple", false,
         [](const Vec3d&, const MouthPlace& m) -> Vec3d { return corner(m, 11) * Vec3d(4.0, 1.0, -4.6); }},
        {"MouthStretch", false,
         [](const Vec3d& p, const MouthPlace& m) -> Vec3d {
             return corner(m, 19) * Vec3d(7.5, -3.0, -5.5) + left(p.x()) * thin(m, 0.12);
         }},
        {"MouthPress", false,
         [](const Vec3d& p, const MouthPlace& m) -> Vec3d {
             return left(p.x()) * (thin(m, 0.26) + corner(m, 9) * Vec3d(0, 0.6, -1.2));
         }},
        {"MouthLowerDown", false,
         [](const Vec3d&, const MouthPlace& m) -> Vec3d {
             return left_lip(m) * lower_lip(m, 11) * Vec3d(0.9, -6.0, -0.8);
         }},
        {"MouthUpperUp", false,
         [](const Vec3d& p, const MouthPlace& m) -> Vec3d {
             return left_lip(m) * upper_lip(m, 12) * Vec3d(0.6, 5.4, -0.6) +
                    bell(p.x(), p.y(), 22, -46, 9, 9) * Vec3d(0.4, 2.2, 1.2);
         }},
        {"BrowDown", false,
         [](const Vec3d& p, const MouthPlace&) -> Vec3d {
             const double fall = p.y() > 17 ? gauss(p.y() - 17, 11) : gauss(p.y() - 17, 6.5);
             const double inner = bell(p.x(), 14, 11), outer = bell(p.x(), 40, 12);
             const double knit = bell(p.x(), p.y(), 8, 17, 3.0, 9) - 0.8 * bell(p.x(), p.y(), 2, 18, 3.0, 9);
             return left(p.x(), 6) *
                    (fall * (inner * Vec3d(-2.6, -5.0, 1.2) + outer * Vec3d(-0.6, -3.4, 0.6)) +
                     knit * Vec3d(0, 0, 1.1));
         }},
        {"BrowOuterUp", false,
         [](const Vec3d& p, const MouthPlace&) -> Vec3d {
             const double fall = p.y() > 22 ? gauss(p.y() - 22, 17) : gauss(p.y() - 22, 7.5);
             return left(p.x()) * fall * bell(p.x(), 43, 14) * Vec3d(0.5, 6.4, -0.6);
         }},
        {"BrowInnerUp", true,
         [](const Vec3d& p, const MouthPlace&) -> Vec3d {
             const double fall = p.y() > 22 ? gauss(p.y() - 22, 17) : gauss(p.y() - 22, 8);
             return fall * bell(std::abs(p.x()), 8, 14) * Vec3d(0.0, 6.5, 0.2);
         }},
        {"CheekSquint", false,
         [](const Vec3d& p, const MouthPlace&) -> Vec3d {
             const double crow = bell(p.x(), p.y(), 53, -2, 6, 8);
             return left(p.x()) *
                    (bell(p.x(), p.y(), 38, -26, 13, 9) * Vec3d(0.5, 4.2, 1.8) + crow * Vec3d(-1.2, 0, 0.4));
         }},
        {"EyeSquint", false,
         [](const Vec3d& p, const MouthPlace&) -> Vec3d {
             return left(p.x()) * (bell(p.x(), p.y(), 36, -19, 13, 6) * Vec3d(0, 1.8, 0.8) +
                                   bell(p.x(), p.y(), 36, 15, 14, 5) * Vec3d(0, -1.3, 0));
         }},
        {"EyeWide", false,
         [](const Vec3d& p, const MouthPlace&) -> Vec3d {
             return left(p.x()) * bell(p.x(), p.y(), 33, 18, 14, 7) * Vec3d(0, 1.4, 0);
         }},
        {"NoseSneer", false,
         [](const Vec3d& p, const MouthPlace& m) -> Vec3d {
             const double wing = bell(p.x(), p.y(), 15, -38, 6, 7);
             const double crease = bell(p.x(), p.y(), 10, -8, 7, 10);
             const double rows = std::cos((p.y() + 8) * 0.75);  // folds across the side of the nose
             return left(p.x(), 7) * (wing * Vec3d(1.0, 3.4, 0.2) +
                                      crease * (Vec3d(0, 2.2, 0.5) + 0.35 * rows * Vec3d(0.5, 0, 0.8)) +
                                      upper_lip(m, 11) * bell(m.along, 0.45, 0.3) * Vec3d(0.2, 2.2, 0) +
                                      bell(p.x(), p.y(), 12, 15, 9, 6) * Vec3d(-0.6, -1.8, 0.3));
         }},
        {"MouthFunnel", true,
         [](const Vec3d&, const MouthPlace& m) -> Vec3d {
             const double near = around(m, 13), side = std::copysign(std::min(std::abs(m.x), 30.0), m.x);
             return near * Vec3d(-0.27 * side, 0, 4.6) + upper_lip(m, 9) * Vec3d(0, 3.4, 2.2) +
                    lower_lip(m, 9) * Vec3d(0, -4.4, 2.4);
         }},
        {"MouthPucker", true,
         [](const Vec3d&, const MouthPlace& m) -> Vec3d {
             const double near = around(m, 14), side = std::copysign(std::min(std::abs(m.x), 32.0), m.x);
             const double lips = around(m, 7);
             return near * Vec3d(-0.40 * side, 0, 3.6) +
                    lips * Vec3d(0, 0.10 * m.above, 5.0 * smooth_step(1.1, 0.1, m.along));
         }},
        {"MouthLeft", true,
         [](const Vec3d&, const MouthPlace& m) -> Vec3d {
             const double near = around(m, 16), shift = 7.5 * near;
             return {shift, 0, -0.011 * (square(m.x + shift) - square(m.x))};
         }},
        {"MouthRollLower", true,
         [](const Vec3d&, const MouthPlace& m) -> Vec3d { return roll(m, 1 - m.upper, 4.6); }},
        {"MouthRollUpper", true,
         [](const Vec3d&, const MouthPlace& m) -> Vec3d { return roll(m, m.upper, 4.2); }},
        {"MouthShrugLower", true,
         [](const Vec3d& p, const MouthPlace& m) -> Vec3d {
             return lower_lip(m, 14) * Vec3d(0, 4.6, 1.6) +
                    bell(p.x(), p.y(), 0, -98, 14, 9) * Vec3d(0, 3.2, 1.4);
         }},
        {"MouthShrugUpper", true,
         [](const Vec3d&, const MouthPlace& m) -> Vec3d {
             return upper_lip(m, 12) * Vec3d(0, 3.2, 1.4) + lower_lip(m, 6) * Vec3d(0, 2.2, 0.4);
         }},
        {"CheekPuff", true,
         [](const Vec3d& p, const MouthPlace& m) -> Vec3d {
             const double side = std::copysign(1.0, p.x()), x = std::abs(p.x());
             const double lips = 0.5 * around(m, 6) * smooth_step(1.2, 0.3, m.along);
             return bell(x, p.y(), 46, -60, 12, 14) * smooth_step(12, 45, p.z()) * Vec3d(6.8 * side, 0, 5.6) +
                    bell(p.x(), p.y(), 0, -56, 16, 5) * Vec3d(0, 0, 1.8) +
                    lips * Vec3d(-0.06 * m.x, -0.12 * m.above, 0.5);
         }},
    };
}

}  // namespace

std::vector<MouthPlace> mouth_places(const HeadSurface& surface, const HeadMesh& head) {
    const Points& rest = head.mesh.positions;
    const std::uint32_t V = head.mesh.vertex_count();
    const double w = surface.mouth_half_width();
    std::vector<MouthPlace> places(V);
    for (std::uint32_t v = 0; v < V; ++v) {
        MouthPlace& m = places[v];
        const double x = std::abs(rest(v, 0)), y = rest(v, 1), z = rest(v, 2);
        const double line =
            x < w ? surface.lip_line(x)
                  : mix(surface.lip_line(w), -16, std::pow(std::clamp((88 - z) / 86, 0.0, 1.0), 1.3));
        m.x = rest(v, 0);
        m.along = x / w;
        m.above = y - line;
        m.distance = std::hypot(std::max(x - w, 0.0), m.above);
        const double blur = 8 * smooth_step(0.9, 1.5, m.along) + 1e-3;
        m.upper = smooth_step(-blur, blur, m.above);
        if (z < 40) m.falloff = smooth_step(15, 40, z);
    }
    const int n = head.mouth.size(), rings = static_cast<int>(head.mouth.rings.size());
    for (int r = 0; r < rings; ++r)
        for (int k = 0; k < n; ++k) {
            const bool end = k % (n / 2) == 0;
            MouthPlace& m = places[head.mouth.rings[r][k]];
            if (r >= 2) m.upper = end ? 0.5 : k < n / 2 ? 1 : 0;
            if (r > HeadMesh::kLipBorder)
                m.lip = std::min(
                    double(r - HeadMesh::kLipBorder) / (HeadMesh::kLipContact - HeadMesh::kLipBorder), 1.0);
            if (r > HeadMesh::kInnerLip) {
                // The bag goes where the lip goes, ever less.
                const double deep = double(r - HeadMesh::kInnerLip) / 3;
                m = places[head.mouth.rings[HeadMesh::kInnerLip][k]];
                m.falloff = std::max(1 - deep, 0.0);
            }
        }
    places[head.mouth.rings.back().back() + 1].falloff = 0;
    for (const VertexRange& part :
         {head.eyeballs[0], head.eyeballs[1], head.upper_teeth, head.lower_teeth, head.tongue})
        for (std::uint32_t v = part.first; v < part.first + part.count; ++v) places[v].falloff = 0;
    for (const auto& lashes : head.lashes)
        for (const HeadMesh::Lash& lash : lashes) places[lash.vertex].falloff = 0;
    for (const Loops& ear : head.ears)
        for (std::size_t r = 1; r < ear.rings.size(); ++r)
            for (const std::uint32_t v : ear.rings[r]) places[v].falloff = 0;
    return places;
}

std::vector<Muscle> make_muscles(const HeadMesh& head, const std::vector<MouthPlace>& places) {
    const Points& rest = head.mesh.positions;
    // Lid skin belongs to the lids: it takes no part in what brows and cheeks do.
    std::vector<double> share(places.size());
    for (std::size_t v = 0; v < places.size(); ++v) share[v] = places[v].falloff;
    for (const Loops& lid : head.lids)
        for (std::size_t r = 1; r < lid.rings.size(); ++r)
            for (const std::uint32_t v : lid.rings[r])
                share[v] *= smooth_step(HeadMesh::kLidMargin - 1, 1, double(r));
    std::vector<Muscle> muscles(kArkitCount);
    const auto add = [&](int shape, const Field& field, bool mirror) {
        Muscle& muscle = muscles[shape];
        for (std::uint32_t v = 0; v < places.size(); ++v) {
            if (share[v] <= 0) continue;
            Vec3d p = rest.row(v).cast<double>().transpose();
            MouthPlace m = places[v];
            if (mirror) p.x() = -p.x(), m.x = -m.x;
            Vec3d d = share[v] * field(p, m);
            if (mirror) d.x() = -d.x();
            if (d.squaredNorm() < 1e-6) continue;
            muscle.vertices.push_back(v);
            muscle.offsets.push_back(d.cast<float>());
        }
    };
    for (const Named& f : fields()) {
        const std::string name = f.name;
        if (name == "MouthLeft") {
            add(arkit_index("MouthLeft"), f.field, false);
            add(arkit_index("MouthRight"), f.field, true);
        } else if (f.both) {
            add(arkit_index(name), f.field, false);
        } else {
            add(arkit_index(name + "Left"), f.field, false);
            add(arkit_index(name + "Right"), f.field, true);
        }
    }
    // The tongue's front comes up over the lower teeth and out.
    Muscle& tongue = muscles[arkit_index("TongueOut")];
    for (std::uint32_t v = head.tongue.first; v < head.tongue.first + head.tongue.count; ++v) {
        const double f = smooth_step(48, 86, rest(v, 2));
        tongue.vertices.push_back(v);
        tongue.offsets.push_back(
            Vec3(0, float(8.5 * std::sin(pi / 2 * std::min(1.6 * f, 1.0))), float(24 * f)));
    }

    return muscles;
}

}  // namespace mien::samples
