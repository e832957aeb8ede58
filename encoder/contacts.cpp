#include "encoder/contacts.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/surface_distance.hpp"
#include "encoder/lid_margins.hpp"
#include "encoder/lining.hpp"
#include "encoder/slits.hpp"
#include "encoder/smooth_step.hpp"

namespace mien::encoder {
namespace {

constexpr float kReach = 10;      // mm from the line of the mouth, or from a lid's margin; what lies farther never comes to it
constexpr float kAtRest = 0.01f;  // mm that a lid may be moved at rest
constexpr float kBeside = 1;      // mm beyond the last pair of an eye at which hold ends
constexpr float kPairGap = 5;     // mm between the vertices of a pair
constexpr float kPairSpacing = 1; // mm between pairs at least
constexpr float kLiningReach = 8; // mm along the lining at which it is let go
// Lips are one where they meet at the corners, and so are lids: hold grows with the way along the skin to the other one, mm.
constexpr float kOneLip = 0.3f, kTwoLips = 1.5f;

class ContactFinder {
public:
    ContactFinder(const Mesh& mesh, const SurfaceDistance& skin, const Slit& slit) : mesh_(mesh), skin_(skin), slit_(slit) {
        if (slit.mouth) {
            line_ = slit.line;
        } else {
            margins_ = lid_margins(mesh, skin, slit);
            for (const auto& pair : margins_)
                for (const std::uint32_t v : pair) line_.push_back(position(v));
        }
        measure_ways();
    }

    std::optional<model::Contact> run() const {
        model::Contact contact;
        contact.pairs = slit_.mouth ? facing_lips() : spread_margins();
        if (contact.pairs.empty()) return std::nullopt;
        std::vector<std::uint32_t> roots;
        for (std::uint32_t v = 0; v < mesh_.vertex_count(); ++v)
            if (way_[v] < kFar) roots.push_back(v);
        const std::vector<Rooted> rooted = grow_lining(mesh_, roots);
        for (std::uint32_t v = 0; v < mesh_.vertex_count(); ++v) {
            if (slit_.sides[v] == Side::beside || to_line(v) > kReach) continue;
            float hold = 0;
            if (skin_.carries(v)) hold = two_lips(v) * before_ends(v);
            else if (const auto [rim, depth] = rooted[v]; rim != kNoRim && slit_.sides[rim] == slit_.sides[v])
                hold = two_lips(rim) * before_ends(rim) * smooth_step(1 - depth / kLiningReach);
            if (hold > 0) contact.members.push_back({v, slit_.sides[v] == Side::above ? hold : -hold});
        }
        if (!slit_.mouth) leave_at_rest(contact);
        return contact;
    }

private:
    static constexpr float kFar = 30;  // mm

    Vec3 position(std::uint32_t v) const { return mesh_.positions.row(v).transpose(); }
    float to_line(std::uint32_t v) const {
        float nearest = 1e9f;
        for (const Vec3& p : line_) nearest = std::min(nearest, (p - position(v)).norm());
        return nearest;
    }
    float two_lips(std::uint32_t v) const { return smooth_step((way_[v] - kOneLip) / (kTwoLips - kOneLip)); }

    /// Open lids lie on their own sides of S; what does not at rest is skin of a corner that sides tell nothing of.
    void leave_at_rest(model::Contact& contact) const {
        Points held = mesh_.positions;
        model::hold_apart(contact, held);
        std::erase_if(contact.members, [&](const auto& member) { return (held.row(member.vertex) - mesh_.positions.row(member.vertex)).norm() > kAtRest; });
    }

    /// Beside the corners of an eye S is that of its last pair, which says nothing of the skin there. A mouth's pairs end at its corners.
    float before_ends(std::uint32_t v) const {
        if (slit_.mouth) return 1;
        const float x = position(v).x();
        return smooth_step(1 - std::max(position(margins_.front()[0]).x() - x, x - position(margins_.back()[0]).x()) / kBeside);
    }

    void measure_ways() {
        way_.assign(mesh_.vertex_count(), kFar);
        for (const Side side : {Side::above, Side::below}) {
            std::vector<std::pair<std::uint32_t, float>> others;
            for (std::uint32_t v = 0; v < mesh_.vertex_count(); ++v)
                if (skin_.carries(v) && int(slit_.sides[v]) == -int(side)) others.emplace_back(v, 0.0f);
            for (const auto& r : skin_.from(others, kFar))
                if (slit_.sides[r.vertex] == side) way_[r.vertex] = r.distance;
        }
    }

    std::vector<std::array<std::uint32_t, 2>> spread_margins() const {
        const std::size_t stride = (margins_.size() + model::kMaxContactPairs - 1) / model::kMaxContactPairs;
        std::vector<std::array<std::uint32_t, 2>> spread;
        for (std::size_t i = 0; i < margins_.size(); i += stride) spread.push_back(margins_[i]);
        return spread;
    }

    std::vector<std::array<std::uint32_t, 2>> facing_lips() const {
        std::vector<std::uint32_t> upper, lower;
        for (std::uint32_t v = 0; v < mesh_.vertex_count(); ++v)
            if (skin_.carries(v) && slit_.sides[v] != Side::beside && way_[v] > kOneLip && to_line(v) < kReach)
                (slit_.sides[v] == Side::above ? upper : lower).push_back(v);
        if (upper.empty() || lower.empty()) return {};
        const auto nearest = [&](std::uint32_t v, const std::vector<std::uint32_t>& among) {
            return *std::min_element(among.begin(), among.end(), [&](std::uint32_t a, std::uint32_t b) {
                return (position(a) - position(v)).squaredNorm() < (position(b) - position(v)).squaredNorm();
            });
        };
        std::vector<std::array<std::uint32_t, 2>> all;
        for (const std::uint32_t u : upper) {
            const std::uint32_t l = nearest(u, lower);
            if (nearest(l, upper) == u && (position(u) - position(l)).norm() < kPairGap) all.push_back({u, l});
        }
        for (float spacing = kPairSpacing;; spacing *= 1.2f) {
            std::vector<std::array<std::uint32_t, 2>> spread;
            for (const auto& pair : all)
                if (std::none_of(spread.begin(), spread.end(), [&](const auto& other) { return (middle(pair) - middle(other)).norm() < spacing; }))
                    spread.push_back(pair);
            if (spread.size() <= model::kMaxContactPairs) return spread;
        }
    }
    Vec3 middle(const std::array<std::uint32_t, 2>& pair) const { return (position(pair[0]) + position(pair[1])) / 2; }

    const Mesh& mesh_;
    const SurfaceDistance& skin_;
    const Slit& slit_;
    std::vector<std::array<std::uint32_t, 2>> margins_;  // of an eye
    std::vector<Vec3> line_;  // of the mouth, or both margins
    std::vector<float> way_;  // V: along the skin to the other lip or lid, mm
};

}  // namespace

std::vector<model::Contact> find_contacts(const Mesh& neutral) {
    const SurfaceDistance skin(neutral, 1u << int(Surface::skin));
    std::vector<Slit> slits = find_slits(neutral, skin);
    std::stable_partition(slits.begin(), slits.end(), [](const Slit& slit) { return slit.mouth; });
    std::vector<model::Contact> contacts;
    for (const Slit& slit : slits)
        if (auto contact = ContactFinder(neutral, skin, slit).run()) contacts.push_back(std::move(*contact));
    return contacts;
}

}  // namespace mien::encoder
