#include "encoder/lid_margins.hpp"

#include <algorithm>
#include <cmath>

namespace mien::encoder {
namespace {

constexpr float kColumn = 1.5f;        // mm of x in which the outermost vertex of a lid is of its margin
constexpr float kStep = 0.7f;          // mm that a margin's vertex may stand back behind both its neighbours: else it is of the lid, and the margin has none there
constexpr float kOverEyeball = 4.5f;   // mm: a margin is no thicker
constexpr float kOpen = 1.0f;          // mm between margins that are two
constexpr float kDetour = 1.2f;        // times the straight way: where skin leads from lid to lid by less there is no slit
constexpr float kFacing = 0.3f;        // cosine to the eyeball's radius: skin that looks outward, not the edge or the lid's inside

}  // namespace

std::vector<std::array<std::uint32_t, 2>> lid_margins(const Mesh& neutral, const SurfaceDistance& skin, const Slit& eye) {
    const Points normals = vertex_normals(neutral.positions, neutral.triangles);
    const auto x = [&](std::uint32_t v) { return neutral.positions(v, 0); };
    const auto y = [&](std::uint32_t v) { return neutral.positions(v, 1); };
    const float first = eye.line.front().x(), last = eye.line.back().x();
    constexpr std::uint32_t kNone = 0xffffffffu;
    std::vector<std::uint32_t> margins[2];  // upper, lower
    for (auto& margin : margins) margin.assign(std::size_t(std::max(0.0f, std::ceil((last - first) / kColumn))), kNone);
    const auto beyond = [&](std::uint32_t a, float height, int lower) { return lower ? y(a) - height : height - y(a); };
    for (std::uint32_t v = 0; v < neutral.vertex_count(); ++v) {
        const Vec3 from_centre = neutral.positions.row(v).transpose() - eye.centre;
        const float distance = from_centre.norm();
        if (!skin.carries(v) || eye.sides[v] == Side::beside || from_centre.z() < 0 || x(v) < first || x(v) >= last) continue;
        if (distance < eye.radius || distance > eye.radius + kOverEyeball || normals.row(v).dot(from_centre.transpose()) < kFacing * distance) continue;
        const int lower = eye.sides[v] == Side::below;
        std::uint32_t& outermost = margins[lower][std::min(margins[lower].size() - 1, std::size_t((x(v) - first) / kColumn))];
        if (outermost == kNone || beyond(v, y(outermost), lower) > 0) outermost = v;
    }
    for (int lower = 0; lower < 2; ++lower) {
        auto& margin = margins[lower];
        std::erase(margin, kNone);
        for (std::size_t i = 1; i + 1 < margin.size();) {
            if (std::max(beyond(margin[i], y(margin[i - 1]), lower), beyond(margin[i], y(margin[i + 1]), lower)) > -kStep) ++i;
            else margin.erase(margin.begin() + long(i)), i = std::max<std::size_t>(1, i - 1);
        }
    }
    std::vector<std::array<std::uint32_t, 2>> pairs;
    std::size_t joined = 0;
    if (margins[1].empty()) return pairs;
    for (const std::uint32_t upper : margins[0]) {
        const std::uint32_t lower = *std::min_element(margins[1].begin(), margins[1].end(), [&](std::uint32_t a, std::uint32_t b) {
            return std::abs(x(a) - x(upper)) < std::abs(x(b) - x(upper));
        });
        if (y(upper) - y(lower) < kOpen) continue;
        pairs.push_back({upper, lower});
        const auto near = skin.from({{upper, 0.0f}}, kDetour * (neutral.positions.row(upper) - neutral.positions.row(lower)).norm());
        joined += std::any_of(near.begin(), near.end(), [&](const auto& r) { return r.vertex == lower; });
    }
    if (2 * joined > pairs.size()) pairs.clear();  // near the corners some are
    return pairs;
}

}  // namespace mien::encoder
