#include "encoder/lids.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/surface_distance.hpp"
#include "encoder/lid_margins.hpp"
#include "encoder/lining.hpp"
#include "encoder/slits.hpp"
#include "encoder/smooth_step.hpp"

namespace mien::encoder {
namespace {

constexpr float kFold = 8;             // mm along the skin from the margin to the fold; of adults 8 to 10 on the closed lid
constexpr float kToe = 0.25f;          // of the way, rounds off the fold
// A parabola 1 - u² near the middle of the eye; skin beside its corners, u = 1, goes along a little.
constexpr float kNarrowing = 1.2f;
constexpr float kTrust = 0.85f;        // not all that markers on a lid show is its way: squints and brows move them too
constexpr float kAboveFold = 20;       // mm more along the skin in which the lid's markers get their say again
constexpr float kBeside = 8;           // mm beside the corners, likewise
constexpr float kHeld = 0.5f;          // share of the way from which skin lies on the eyeball
constexpr float kHangs = 14;           // mm to the skin from what may hang on it: lashes
constexpr float kLiningReach = 8;      // mm along the lining at which it is let go

/// max(t, 0) without its kink.
float toe(float t) { return t >= kToe ? t : t <= -kToe ? 0 : (t + kToe) * (t + kToe) / (4 * kToe); }

class LidFinder {
public:
    LidFinder(const Mesh& mesh, const SurfaceDistance& skin, const Slit& eye) : mesh_(mesh), skin_(skin), eye_(eye), margins_(lid_margins(mesh, skin, eye)) {}

    std::vector<model::Lid::Member> run() {
        if (!measure_opening()) return {};
        std::vector<model::Lid::Member> members = of_skin();
        const std::vector<model::Lid::Member> more = behind_and_on(members);
        members.insert(members.end(), more.begin(), more.end());
        std::sort(members.begin(), members.end(), [](const auto& a, const auto& b) { return a.vertex < b.vertex; });
        return members;
    }

private:
    Vec3 position(std::uint32_t v) const { return mesh_.positions.row(v).transpose(); }

    /// How far the eye is open at x: a parabola through what the margins show, which evens out the steps of the mesh.
    bool measure_opening() {
        if (margins_.size() < 4) return false;
        Eigen::MatrixX3d powers(Eigen::Index(margins_.size()), 3);
        Eigen::VectorXd gaps(powers.rows());
        for (Eigen::Index i = 0; i < powers.rows(); ++i) {
            const auto& [upper, lower] = margins_[std::size_t(i)];
            const double x = position(upper).x() - eye_.centre.x();
            powers.row(i) << 1, x, x * x;
            gaps[i] = position(upper).y() - position(lower).y();
        }
        const Eigen::Vector3d c = powers.colPivHouseholderQr().solve(gaps);
        if (!(c[2] < 0)) return false;
        middle_ = float(-c[1] / (2 * c[2])) + eye_.centre.x();
        const double widest = c[0] - c[1] * c[1] / (4 * c[2]);
        if (!(widest > 0)) return false;
        half_width_ = float(std::sqrt(-widest / c[2]));
        return true;
    }

    float margin_height(float x) const {
        const auto after = std::find_if(margins_.begin(), margins_.end(), [&](const auto& pair) { return position(pair[0]).x() >= x; });
        if (after == margins_.begin()) return position(margins_.front()[0]).y();
        if (after == margins_.end()) return position(margins_.back()[0]).y();
        const Vec3 left = position((*(after - 1))[0]), right = position((*after)[0]);
        return std::lerp(left.y(), right.y(), (x - left.x()) / std::max(1e-3f, right.x() - left.x()));
    }

    std::vector<model::Lid::Member> of_skin() const {
        std::vector<std::pair<std::uint32_t, float>> seeds;
        for (const auto& pair : margins_) seeds.emplace_back(pair[0], 0.0f);
        std::vector<model::Lid::Member> members;
        for (const auto& r : skin_.from(seeds, kFold + kAboveFold)) {
            if (eye_.sides[r.vertex] != Side::above) continue;
            const Vec3 p = position(r.vertex);
            // The edge below the margin and the lid's inside belong to it.
            const bool between = p.x() > position(margins_.front()[0]).x() && p.x() < position(margins_.back()[0]).x();
            const bool edge = (between && p.y() <= margin_height(p.x())) || (p - eye_.centre).norm() < eye_.radius;
            const float along = edge ? 1 : toe(1 - r.distance / kFold);
            const float aside = std::abs(p.x() - middle_) / half_width_;
            const float beyond = std::max(0.0f, std::abs(p.x() - middle_) - half_width_);
            const float weight = kTrust * smooth_step(1 - std::max(0.0f, r.distance - kFold) / kAboveFold) * smooth_step(1 - beyond / kBeside);
            if (weight > 0) members.push_back({r.vertex, along * std::exp(-kNarrowing * aside * aside), weight, smooth_step(along / kHeld) * smooth_step(2 - 2 * aside)});
        }
        std::sort(members.begin(), members.end(), [](const auto& a, const auto& b) { return a.vertex < b.vertex; });
        return members;
    }

    /// Lining goes with the rim it grows from; lashes and tear film turn with the skin that they hang on, further out by a longer way.
    std::vector<model::Lid::Member> behind_and_on(const std::vector<model::Lid::Member>& lid) const {
        const auto member_of = [&](std::uint32_t v) -> const model::Lid::Member* {
            const auto it = std::lower_bound(lid.begin(), lid.end(), v, [](const auto& m, std::uint32_t u) { return m.vertex < u; });
            return it != lid.end() && it->vertex == v ? &*it : nullptr;
        };
        std::vector<std::uint32_t> roots, skin;
        for (const auto& member : lid) roots.push_back(member.vertex);
        for (std::uint32_t v = 0; v < mesh_.vertex_count(); ++v)
            if (skin_.carries(v) && (position(v) - eye_.centre).norm() < eye_.radius + 2 * kHangs) skin.push_back(v);
        const std::vector<Rooted> rooted = grow_lining(mesh_, roots), hanging = hang_on_skin(mesh_, skin, kHangs);
        std::vector<model::Lid::Member> more;
        for (std::uint32_t v = 0; v < mesh_.vertex_count(); ++v) {
            if (skin_.carries(v)) continue;
            if (const auto [rim, depth] = rooted[v]; rim != kNoRim) {
                const auto* member = member_of(rim);
                if (const float held = smooth_step(1 - depth / kLiningReach); member && held > 0)
                    more.push_back({v, member->share, member->weight * held, member->hold * held});
                continue;
            }
            const std::uint32_t root = hanging[v].rim;
            const auto* member = root == kNoRim ? nullptr : member_of(root);
            if (!member || (position(v) - position(root)).norm() > kHangs) continue;
            const float further = (position(v) - eye_.centre).norm() / (position(root) - eye_.centre).norm();
            more.push_back({v, member->share * (1 + (further - 1) * member->hold), member->weight, member->hold});
        }
        return more;
    }

    const Mesh& mesh_;
    const SurfaceDistance& skin_;
    const Slit& eye_;
    std::vector<std::array<std::uint32_t, 2>> margins_;
    float middle_ = 0, half_width_ = 0;  // mm, in x, of the opening
};

}  // namespace

std::vector<model::Lid> find_lids(const Mesh& neutral, const std::vector<Site>& sites) {
    const SurfaceDistance skin(neutral, 1u << int(Surface::skin));
    std::vector<model::Lid> lids;
    std::vector<char> taken(neutral.vertex_count());  // eyes of a caricature may be so large that their lids meet
    for (const Slit& slit : find_slits(neutral, skin)) {
        if (slit.mouth) continue;
        auto members = LidFinder(neutral, skin, slit).run();
        std::erase_if(members, [&](const auto& member) { return std::exchange(taken[member.vertex], char(1)); });
        std::vector<float> share(neutral.vertex_count(), 0);
        for (const auto& member : members) share[member.vertex] = member.share;
        const bool seen = std::any_of(sites.begin(), sites.end(), [&](const Site& site) {
            float at = 0;
            for (int i = 0; i < 3; ++i) at += site.weights[i] * share[site.vertices[i]];
            return at > model::kLeastLidShare;
        });
        if (seen) lids.push_back({slit.centre, std::move(members)});
    }
    return lids;
}

}  // namespace mien::encoder
