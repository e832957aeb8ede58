#include "samples/head_rig.hpp"

namespace mien::samples {
namespace {

const Vec3 kHinge(0, -14, 2);       // axis through both jaw joints, just before the ear openings
constexpr float kJawAngle = 0.30f;  // rad at JawOpen 1: about 32 mm between the incisors
constexpr float kJawGlide = 3.0f;   // mm the joints slide forward meanwhile
constexpr float kReach = 15.0f;    // mm: no point of the skin is pulled farther by muscles, however many pull
constexpr float kLipGap = 0.10f;   // mm between closed lips
constexpr float kLidGap = 0.012f;  // rad between closed lid margins
constexpr float kTear = 0.2f;      // mm between lids and eyeball

float at(const std::array<float, kArkitCount>& weights, int shape) {
    return std::clamp(weights[shape], 0.f, 1.25f);
}

}  // namespace

HeadRig::HeadRig(const HeadSurface& surface, const HeadMesh& head) : head_(head) {
    const std::vector<MouthPlace> places = mouth_places(surface, head);
    muscles_ = make_muscles(head, places);
    find_jaw(surface, places);
    find_lids();
    find_rigid();
}

void HeadRig::find_jaw(const HeadSurface& surface, const std::vector<MouthPlace>& places) {
    const Points& rest = head_.mesh.positions;
    const std::uint32_t V = head_.mesh.vertex_count();
    const double w = surface.mouth_half_width(), corner = 0.46;
    std::vector<char> kept(V, 0);  // lips keep their edge, ears stay
    const int n = head_.mouth.size(), rings = static_cast<int>(head_.mouth.rings.size());
    for (int r = 3; r < rings; ++r)
        for (const std::uint32_t v : head_.mouth.rings[r]) kept[v] = 1;
    for (const bool closed : {false, true}) {
        Eigen::VectorXf& field = closed ? jaw_closed_ : jaw_;
        field = Eigen::VectorXf::Zero(V);
        for (std::uint32_t v = 0; v < V; ++v) {
            const double x = std::abs(rest(v, 0)), y = rest(v, 1), z = rest(v, 2), above = places[v].above;
            const double q = std::pow(std::min(x / w, 1.0), 2.5), shut = closed ? 0.62 : 0;
            const double upper = mix(mix(0.03, corner, q), shut, closed),
                         lower = mix(mix(1, corner, q), shut, closed);
            // Upper lips stay and lower lips go; beyond the corners the cheek stretches evenly between the
            // two.
            double jaw = places[v].upper > 0.5 || (places[v].upper == 0.5 && above > 0)
                             ? upper * smooth_step(mix(18, 42, q) + 8 * closed, 8 * closed, above)
                             : mix(lower, 1, smooth_step(9 * closed, mix(12, 40, q) + 9 * closed, -above));
            jaw *= smooth_step(-32, 6, z);
            // The throat follows a little, the neck not at all.
            jaw *= smooth_step(-150, -100, y + 0.35 * std::max(z, 0.0) * smooth_step(-100, -116, y) - 15);
            field[v] = float(jaw);
        }
        // The bag is divided by its height around the loop, less and less towards the throat.
        for (int r = HeadMesh::kInnerLip + 1; r < rings; ++r)
            for (int k = 0; k < n; ++k) {
                const double s = std::sin(2 * pi * k / n),
                             deep = double(r - HeadMesh::kInnerLip) / (rings - HeadMesh::kInnerLip);
                field[head_.mouth.rings[r][k]] =
                    float(mix(smooth_step(0.5, -0.5, s), 0.5, 0.6 * deep * deep));
            }
        field[head_.mouth.rings.back().back() + 1] = 0.5f;
        for (const Loops& ear : head_.ears)
            for (std::size_t r = 1; r < ear.rings.size(); ++r)
                for (const std::uint32_t v : ear.rings[r]) field[v] = 0, kept[v] = 1;
        smooth(field, kept);
        const auto fill = [&](const VertexRange& range, float value) {
            field.segment(range.first, range.count).setConstant(value);
        };
        for (const VertexRange& eye : head_.eyeballs) fill(eye, 0);
        for (const auto& lashes : head_.lashes)
            for (const HeadMesh::Lash& lash : lashes) field[lash.vertex] = 0;
        fill(head_.upper_teeth, 0);
        fill(head_.lower_teeth, 1);
        fill(head_.tongue, 1);
    }
}

void HeadRig::smooth(Eigen::VectorXf& field, const std::vector<char>& kept) const {
    const auto neighbours = vertex_neighbours(head_.mesh.vertex_count(), head_.mesh.triangles);
    for (int pass = 0; pass < 12; ++pass) {
        const Eigen::VectorXf before = field;
        for (std::size_t v = 0; v < neighbours.size(); ++v) {
            if (kept[v] || neighbours[v].empty()) continue;
            float sum = 0;
            for (const std::uint32_t u : neighbours[v]) sum += before[u];
            field[v] = 0.4f * before[v] + 0.6f * sum / float(neighbours[v].size());
        }
    }
}

void HeadRig::find_lids() {
    const Points& rest = head_.mesh.positions;
    for (int side = 0; side < 2; ++side) {
        const auto& rings = head_.lids[side].rings;
        const int n = head_.lids[side].size(), half = n / 2;
        const Vec3 eye = head_.landmarks.eye_centre[side];
        const auto angle = [&](std::uint32_t v) {
            return std::atan2(rest(v, 1) - eye.y(), rest(v, 2) - eye.z());
        };
        const auto radius = [&](std::uint32_t v) {
            return std::hypot(rest(v, 1) - eye.y(), rest(v, 2) - eye.z());
        };
        lid_columns_[side].resize(half + 1);
        for (int k = 0; k <= half; ++k)
            lid_columns_[side][k] = {
                angle(rings[HeadMesh::kLidMargin][k]), angle(rings[HeadMesh::kLidMargin][(n - k) % n]),
                radius(rings[HeadMesh::kLidMargin][k]), radius(rings[HeadMesh::kLidMargin][(n - k) % n]),
                float(std::pow(std::max(std::sin(pi * k / half), 0.0), 0.7))};
        for (std::size_t r = 1; r < rings.size(); ++r)
            for (int k = 0; k < n; ++k) {
                const bool upper = k <= half;
                const double f = std::min(double(r) / HeadMesh::kLidMargin, 1.0);
                lids_[side].push_back({rings[r][k], upper ? k : n - k, upper,
                                       float(smooth_step(0.3, 1, f) * (k % half == 0 ? 0 : 1))});
            }
        for (const HeadMesh::Lash& lash : head_.lashes[side])
            lids_[side].push_back({lash.vertex, lash.column, lash.upper, 1});
    }
}

void HeadRig::find_rigid() {
    for (std::uint32_t v = 0; v < head_.mesh.vertex_count(); ++v) {
        const Vec3 p = head_.mesh.positions.row(v).transpose();
        const bool skull = p.y() > 85 || (p.z() < -36 && p.y() > -25);
        const bool eye = head_.eyeballs[0].contains(v) || head_.eyeballs[1].contains(v);
        if (!eye && (skull || head_.upper_teeth.contains(v))) rigid_.push_back(v);
    }
    for (const Loops& ear : head_.ears)
        for (std::size_t r = 1; r < ear.rings.size(); ++r)
            rigid_.insert(rigid_.end(), ear.rings[r].begin(), ear.rings[r].end());
    std::sort(rigid_.begin(), rigid_.end());
    rigid_.erase(std::unique(rigid_.begin(), rigid_.end()), rigid_.end());
}

void HeadRig::move_muscles(const Weights& weights, Points& points) const {
    Points pull = Points::Zero(points.rows(), 3);
    for (int shape = 0; shape < kArkitCount; ++shape) {
        const float weight = at(weights, shape);
        if (weight == 0) continue;
        const Muscle& muscle = muscles_[shape];
        for (std::size_t i = 0; i < muscle.vertices.size(); ++i)
            pull.row(muscle.vertices[i]) += weight * muscle.offsets[i].transpose();
    }
    for (Eigen::Index v = 0; v < points.rows(); ++v) {
        const float length = pull.row(v).norm();
        if (length == 0) continue;
        const bool inside = head_.tongue.contains(std::uint32_t(v));
        points.row(v) +=
            pull.row(v) * (inside || length < 1e-3f ? 1.f : kReach * std::tanh(length / kReach) / length);
    }
}

namespace {

/// Where the weights put the lower jaw: turned about its hinge and slid.
struct JawPose {
    float angle = 0;
    Vec3 slide = Vec3::Zero();

    explicit JawPose(const std::array<float, kArkitCount>& weights) {
        static const int open_shape = arkit_index("JawOpen"), forward = arkit_index("JawForward"),
                         left = arkit_index("JawLeft"), right = arkit_index("JawRight");
        const float open = at(weights, open_shape), aside = at(weights, left) - at(weights, right);
        angle = kJawAngle * open;
        slide = Vec3(5.5f * aside, -0.8f * at(weights, forward), 5.0f * at(weights, forward) + kJawGlide * open);
    }
    bool still() const { return angle == 0 && slide.isZero(); }
    /// p as it moves with `share` of the jaw.
    Vec3 moved(const Vec3& p, float share) const {
        const float c = std::cos(angle * share), s = std::sin(angle * share);
        const float y = p.y() - kHinge.y(), z = p.z() - kHinge.z();
        return Vec3(p.x() + slide.x() * share, kHinge.y() + c * y - s * z + slide.y() * share,
                    kHinge.z() + s * y + c * z + slide.z() * share);
    }
    /// Where a point that moved with the whole jaw was.
    Vec3 back(const Vec3& p) const {
        const float c = std::cos(angle), s = std::sin(angle);
        const float y = p.y() - kHinge.y() - slide.y(), z = p.z() - kHinge.z() - slide.z();
        return Vec3(p.x() - slide.x(), kHinge.y() + c * y + s * z, kHinge.z() - s * y + c * z);
    }
};

}  // namespace

void HeadRig::move_jaw(const Weights& weights, Points& points) const {
    static const int open_shape = arkit_index("JawOpen"), close_shape = arkit_index("MouthClose");
    const JawPose jaw(weights);
    if (jaw.still()) return;
    // MouthClose answers JawOpen: as much of it as there is opening keeps the lips together.
    const float open = at(weights, open_shape), closed = open > 0 ? std::min(at(weights, close_shape) / open, 1.f) : 0.f;
    for (Eigen::Index v = 0; v < points.rows(); ++v) {
        const float share = jaw_[v] + closed * (jaw_closed_[v] - jaw_[v]);
        if (share != 0) points.row(v) = jaw.moved(points.row(v).transpose(), share).transpose();
    }
}

void HeadRig::stop_at_teeth(const Weights& weights, Points& points) const {
    constexpr float kThick = 1.7f;  // mm from the arch line to a crown's outer side, and some saliva
    constexpr float kSlope = 4;     // past the biting edge there is ever more room behind
    const JawPose jaw(weights);
    const auto room = [](const DentalArch& arch, const Vec3& p, float past_edge) {
        return p.z() - float(arch.z(p.x(), kThick)) + kSlope * std::max(past_edge, 0.f);
    };
    for (int r = HeadMesh::kLipBorder; r <= HeadMesh::kInnerLip; ++r)
        for (const std::uint32_t v : head_.mouth.rings[r]) {
            Vec3 p = points.row(v).transpose();
            p.z() -= std::min(room(kUpperArch, p, float(kUpperEdge) - p.y()), 0.f);
            Vec3 q = jaw.back(p);
            q.z() -= std::min(room(kLowerArch, q, q.y() - float(kLowerEdge)), 0.f);
            points.row(v) = jaw.moved(q, 1).transpose();
        }
}

void HeadRig::part_lips(Points& points) const {
    const int n = head_.mouth.size(), half = n / 2;
    const auto& rings = head_.mouth.rings;
    // How much of a push at the contact line each ring from the border inwards takes part in.
    static constexpr float kShare[] = {0.25f, 0.4f, 0.6f, 0.8f, 0.92f, 1, 1, 1, 0.6f};
    for (int k = 1; k < half; ++k) {
        const std::uint32_t up = rings[HeadMesh::kLipContact][k], down = rings[HeadMesh::kLipContact][n - k];
        float overlap = kLipGap - (points(up, 1) - points(down, 1));
        for (int r = HeadMesh::kLipContact + 1; r <= HeadMesh::kInnerLip; ++r)
            overlap = std::max(overlap, kLipGap - (points(rings[r][k], 1) - points(rings[r][n - k], 1)));
        if (overlap <= 0) continue;
        for (int i = 0; i < int(std::size(kShare)); ++i) {
            const int r = HeadMesh::kLipBorder + i;
            points(rings[r][k], 1) += 0.5f * overlap * kShare[i];
            points(rings[r][n - k], 1) -= 0.5f * overlap * kShare[i];
        }
    }
}

void HeadRig::roll_lids(const Weights& weights, const Gaze& gaze, Points& points) const {
    static const std::array<std::array<int, 4>, 2> shapes = {
        {{arkit_index("EyeBlinkRight"), arkit_index("EyeSquintRight"), arkit_index("EyeWideRight"),
          arkit_index("CheekSquintRight")},
         {arkit_index("EyeBlinkLeft"), arkit_index("EyeSquintLeft"), arkit_index("EyeWideLeft"),
          arkit_index("CheekSquintLeft")}}};
    for (int side = 0; side < 2; ++side) {
        const float blink = at(weights, shapes[side][0]), squint = at(weights, shapes[side][1]),
                    wide = at(weights, shapes[side][2]), cheek = at(weights, shapes[side][3]),
                    pitch = std::clamp(gaze.pitch[side], -0.8f, 0.8f);
        const std::size_t columns = lid_columns_[side].size();
        std::vector<float> up(columns), down(columns), shut(columns);
        for (std::size_t k = 0; k < columns; ++k) {
            const LidColumn& c = lid_columns_[side][k];
            const float gap = c.upper - c.lower;
            // The upper lid does most of a blink and follows the gaze; the lower lid squints.
            float upper = c.upper - gap * (0.88f * blink + 0.16f * squint) +
                          c.shape * (0.14f * wide + (pitch > 0 ? 0.35f : 0.74f) * pitch);
            float lower = c.lower + gap * (0.12f * blink + 0.24f * squint + 0.12f * cheek) +
                          c.shape * ((pitch > 0 ? 0.12f : 0.40f) * pitch - 0.03f * wide);
            if (upper < lower + kLidGap * c.shape) {
                // They meet low, where a lid's weight puts them.
                const float meet = std::clamp(0.12f * upper + 0.88f * lower, c.lower - 0.12f * c.shape,
                                              c.lower + 0.4f * gap);
                upper = meet + 0.5f * kLidGap * c.shape;
                lower = meet - 0.5f * kLidGap * c.shape;
            }
            up[k] = upper - c.upper;
            down[k] = lower - c.lower;
            shut[k] = gap > 0 ? std::clamp(1 - (upper - lower) / gap, 0.f, 1.f) : 0.f;
        }
        const Vec3 eye = head_.landmarks.eye_centre[side];
        const float skim = head_.landmarks.eye_radius + kTear;
        for (const LidVertex& lid : lids_[side]) {
            const float angle = lid.share * (lid.upper ? up[lid.column] : down[lid.column]),
                        c = std::cos(angle), s = std::sin(angle);
            Vec3 r = points.row(lid.vertex).transpose() - eye;
            // Margins that meet lie at the same depth.
            const LidColumn& column = lid_columns_[side][lid.column];
            const float own = lid.upper ? column.upper_radius : column.lower_radius,
                        other = lid.upper ? column.lower_radius : column.upper_radius;
            const float depth = 1 + lid.share * shut[lid.column] * (0.5f * (own + other) / own - 1);
            r = Vec3(r.x(), depth * (c * r.y() + s * r.z()), depth * (c * r.z() - s * r.y()));
            const float length = r.norm();
            if (length < skim) r *= skim / length;
            points.row(lid.vertex) = (eye + r).transpose();
        }
    }
}

void HeadRig::turn_eyeballs(const Gaze& gaze, Points& points) const {
    for (int side = 0; side < 2; ++side) {
        const Vec3 eye = head_.landmarks.eye_centre[side];
        const Eigen::Matrix3f turn = (Eigen::AngleAxisf(gaze.yaw[side], Vec3::UnitY()) *
                                      Eigen::AngleAxisf(-gaze.pitch[side], Vec3::UnitX()))
                                         .toRotationMatrix();
        const VertexRange& ball = head_.eyeballs[side];
        for (std::uint32_t v = ball.first; v < ball.first + ball.count; ++v)
            points.row(v) = (eye + turn * (points.row(v).transpose() - eye)).transpose();
    }
}

Points HeadRig::deform(const Instant& instant) const {
    Gaze gaze = instant.gaze;
    if (gaze.yaw[0] == 0 && gaze.yaw[1] == 0 && gaze.pitch[0] == 0 && gaze.pitch[1] == 0) {
        static const int left_eye[] = {arkit_index("EyeLookOutLeft"), arkit_index("EyeLookInLeft"),
                                       arkit_index("EyeLookUpLeft"), arkit_index("EyeLookDownLeft")};
        static const int right_eye[] = {arkit_index("EyeLookInRight"), arkit_index("EyeLookOutRight"),
                                        arkit_index("EyeLookUpRight"), arkit_index("EyeLookDownRight")};
        for (int side = 0; side < 2; ++side) {
            const int* look = side == 1 ? left_eye : right_eye;
            gaze.yaw[side] = 0.55f * (at(instant.weights, look[0]) - at(instant.weights, look[1]));
            gaze.pitch[side] = 0.42f * at(instant.weights, look[2]) - 0.50f * at(instant.weights, look[3]);
        }
    }
    Points points = head_.mesh.positions;
    move_muscles(instant.weights, points);
    move_jaw(instant.weights, points);
    stop_at_teeth(instant.weights, points);
    part_lips(points);
    roll_lids(instant.weights, gaze, points);
    turn_eyeballs(gaze, points);
    return points;
}

}  // namespace mien::samples
