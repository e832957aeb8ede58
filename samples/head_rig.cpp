#include "samples/head_rig.hpp"

namespace mien::samples {
namespace {

const Vec3 kHinge(0, -14, 2);  // axis through both jaw joints, just before the ear openings
constexpr double kJawAngle = 0.30;  // rad at JawOpen 1: about 32 mm between the incisors

}  // namespace

HeadRig::HeadRig(const HeadSurface& surface, const HeadMesh& head) : head_(head) {
    add_jaw_weights(surface);
    find_rigid();
}

void HeadRig::add_jaw_weights(const HeadSurface& surface) {
    const Points& rest = head_.mesh.positions;
    const std::uint32_t V = head_.mesh.vertex_count();
    jaw_ = Eigen::VectorXf::Zero(V);
    const double w = surface.mouth_half_width();
    std::vector<char> lip(V, 0);  // +1 upper, 2 lower
    const int n = head_.mouth.size();
    for (const auto& ring : head_.mouth.rings)
        for (int k = 0; k < n; ++k) lip[ring[k]] = k % (n / 2) == 0 ? 0 : k < n / 2 ? 1 : 2;
    for (std::uint32_t v = 0; v < V; ++v) {
        const double x = std::abs(rest(v, 0)), y = rest(v, 1), z = rest(v, 2);
        const double q = std::pow(std::min(x / w, 1.0), 2.5), corner = 0.46;
        // The line that parts the moving from the still: between the lips, then from the mouth's corner to the joint.
        const double line = x < w ? surface.lip_line(x) : mix(surface.lip_line(w), -16, std::pow(std::clamp((88 - z) / 86, 0.0, 1.0), 1.3));
        const double above = y - line;
        const bool upper = lip[v] ? lip[v] == 1 : above > 0;
        double jaw = upper ? mix(0.03, corner, q) * smooth_step(mix(18, 42, q), 0, above)
                           : mix(mix(1, corner, q), 1, smooth_step(0, mix(12, 40, q), -above));
        jaw *= smooth_step(-32, 6, z);
        // The throat follows a little, the neck not at all.
        jaw *= smooth_step(-150, -100, y + 0.35 * std::max(z, 0.0) * smooth_step(-100, -116, y) - 15);
        jaw_[v] = float(jaw);
    }
    // The bag is divided by its height around the loop, less and less towards the throat.
    const int rings = static_cast<int>(head_.mouth.rings.size());
    for (int r = HeadMesh::kInnerLip + 1; r < rings; ++r)
        for (int k = 0; k < n; ++k) {
            const double s = std::sin(2 * pi * k / n), deep = double(r - HeadMesh::kInnerLip) / (rings - HeadMesh::kInnerLip);
            jaw_[head_.mouth.rings[r][k]] = float(mix(smooth_step(0.5, -0.5, s), 0.5, 0.6 * deep * deep));
        }
    jaw_[head_.mouth.rings.back().back() + 1] = 0.5f;
    smooth(jaw_, lip);
    for (const Loops* loops : {&head_.ears[0], &head_.ears[1]})
        for (std::size_t r = 1; r < loops->rings.size(); ++r)
            for (const std::uint32_t v : loops->rings[r]) jaw_[v] = 0;
    const auto fill = [&](const VertexRange& range, float value) { jaw_.segment(range.first, range.count).setConstant(value); };
    for (const VertexRange& eye : head_.eyeballs) fill(eye, 0);
    fill(head_.upper_teeth, 0);
    fill(head_.lower_teeth, 1);
    fill(head_.tongue, 1);
}

/// Evens a field over the mesh; vertices marked in `kept` stay.
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

void HeadRig::find_rigid() {
    for (std::uint32_t v = 0; v < head_.mesh.vertex_count(); ++v) {
        const Vec3 p = head_.mesh.positions.row(v).transpose();
        const bool skull = p.y() > 62 || (p.z() < -36 && p.y() > -25);
        bool eye = head_.eyeballs[0].contains(v) || head_.eyeballs[1].contains(v);
        if (!eye && (skull || head_.upper_teeth.contains(v))) rigid_.push_back(v);
    }
    for (const Loops& ear : head_.ears)
        for (std::size_t r = 1; r < ear.rings.size(); ++r)
            for (const std::uint32_t v : ear.rings[r])
                if (head_.mesh.positions(v, 2) >= -36) rigid_.push_back(v);
    std::sort(rigid_.begin(), rigid_.end());
    rigid_.erase(std::unique(rigid_.begin(), rigid_.end()), rigid_.end());
}

Points HeadRig::deform(const Instant& instant) const {
    static const int jaw_open = arkit_index("JawOpen");
    const float open = std::clamp(instant.weights[jaw_open], 0.f, 1.2f);
    Points out = head_.mesh.positions;
    const float angle = float(kJawAngle) * open;
    for (std::uint32_t v = 0; v < head_.mesh.vertex_count(); ++v) {
        if (jaw_[v] == 0) continue;
        const Vec3 r = out.row(v).transpose() - kHinge;
        out.row(v) = (kHinge + Eigen::AngleAxisf(angle * jaw_[v], Vec3::UnitX()) * r + Vec3(0, 0, 3 * open * jaw_[v])).transpose();
    }
    for (int side = 0; side < 2; ++side) {
        const Vec3 eye = head_.landmarks.eye_centre[side];
        const Eigen::Matrix3f turn = (Eigen::AngleAxisf(instant.gaze.yaw[side], Vec3::UnitY()) *
                                      Eigen::AngleAxisf(-instant.gaze.pitch[side], Vec3::UnitX())).toRotationMatrix();
        const VertexRange& ball = head_.eyeballs[side];
        for (std::uint32_t v = ball.first; v < ball.first + ball.count; ++v)
            out.row(v) = (eye + turn * (out.row(v).transpose() - eye)).transpose();
    }
    return out;
}

}  // namespace mien::samples
