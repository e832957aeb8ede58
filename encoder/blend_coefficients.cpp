#include "encoder/blend_coefficients.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/parallel.hpp"
#include "core/surface_distance.hpp"
#include "encoder/lining.hpp"
#include "encoder/slits.hpp"

namespace mien::encoder {
namespace {

constexpr std::uint32_t kSkin = 1u << int(Surface::skin);
constexpr std::uint32_t kStill = 0xffffffffu;  // stands for every dot of the still ring: they never move

/// Coefficients of one point: dot -> share, ascending; what is missing to one is still.
using Shares = std::map<std::uint32_t, float>;

void add_scaled(Shares& to, const Shares& from, float scale) {
    for (const auto& [dot, share] : from) to[dot] += scale * share;
}

struct Candidate {
    std::uint32_t index;
    float distance;
    Vec3 position;
};

/// The paper's choice among dots around p: within reach of the mean of the two nearest distances, and of two in the same
/// direction the nearer. `candidates`: nearest first.
std::vector<Candidate> choose(const Vec3& p, const std::vector<Candidate>& candidates, const BlendOptions& options) {
    if (candidates.size() < 2) return candidates;
    const double limit = options.reach * (candidates[0].distance + candidates[1].distance) / 2;
    std::vector<Candidate> chosen;
    for (const Candidate& c : candidates) {
        if (c.distance > limit && chosen.size() >= 2) break;
        const Vec3 direction = (c.position - p).normalized();
        const bool hidden = std::any_of(chosen.begin(), chosen.end(), [&](const Candidate& nearer) {
            return (nearer.position - p).normalized().dot(direction) > options.same_direction;
        });
        if (!hidden) chosen.push_back(c);
    }
    return chosen;
}

class Blender {
public:
    Blender(const Mesh& mesh, const std::vector<Site>& sites, const std::vector<std::uint32_t>& rigid, const BlendOptions& options)
        : mesh_(mesh), sites_(sites), options_(options), skin_(mesh, kSkin), slits_(find_slits(mesh, skin_)), still_(mesh.vertex_count()) {
        for (const std::uint32_t v : rigid) still_[v] = 1;
    }

    Result<model::BlendBase> run() {
        if (sites_.size() < 4) return Error{ErrorCode::invalid, "a face cannot be blended from fewer than four markers"};
        measure_dots();
        if (spacing_ <= 0) return Error{ErrorCode::invalid, "the markers do not lie on the skin of the neutral mesh"};
        place_still_ring();
        measure_vertices();
        place_grid();
        assign_grid();
        for (int pass = 0; pass < options_.smoothing_passes; ++pass) smooth_grid();
        assign_skin();
        assign_attachments();
        assign_inner_mouth();
        return pack();
    }

private:
    Vec3 position(std::uint32_t v) const { return mesh_.positions.row(v).transpose(); }

    bool conflict(std::uint32_t a, std::uint32_t b) const {
        return std::any_of(slits_.begin(), slits_.end(), [&](const Slit& s) { return int(s.sides[a]) * int(s.sides[b]) < 0; });
    }

    /// Outlining points, at the rim of a slit, mix only with their own kind: 0 for no outline.
    int outline(std::uint32_t v) const {
        for (std::size_t i = 0; i < slits_.size(); ++i) {
            const float rim = slits_[i].mouth ? 6.0f : 9.0f;  // lids are open by about 10 mm
            if (slits_[i].sides[v] == Side::beside) continue;
            for (const Vec3& p : slits_[i].line)
                if (std::hypot(p.y() - position(v).y(), p.x() - position(v).x()) < rim && std::abs(p.z() - position(v).z()) < 12)
                    return int(2 * i) + (slits_[i].sides[v] == Side::above ? 1 : 2);
        }
        return 0;
    }

    struct Dot {
        std::uint32_t marker;  // kStill: of the ring
        std::uint32_t vertex;  // the nearest one; its labels are the dot's
        Vec3 position;
        std::vector<std::pair<std::uint32_t, float>> seeds;
    };

    void measure_dots() {
        for (std::uint32_t m = 0; m < sites_.size(); ++m) {
            Dot dot{m, 0, sites_[m].position(mesh_.positions), {}};
            float heaviest = -1;
            for (int i = 0; i < 3; ++i) {
                const std::uint32_t v = sites_[m].vertices[i];
                if (sites_[m].weights[i] <= 0 || !skin_.carries(v)) continue;
                dot.seeds.emplace_back(v, (position(v) - dot.position).norm());
                if (sites_[m].weights[i] > heaviest) {
                    heaviest = sites_[m].weights[i];
                    dot.vertex = v;
                }
            }
            marker_vertex_.push_back(dot.vertex);
            if (!dot.seeds.empty()) dots_.push_back(std::move(dot));
        }
        std::vector<float> nearest;
        for (const Dot& a : dots_) {
            float best = 1e9f;
            for (const Dot& b : dots_)
                if (&a != &b) best = std::min(best, (a.position - b.position).norm());
            nearest.push_back(best);
        }
        if (nearest.size() < 4) return;
        std::nth_element(nearest.begin(), nearest.begin() + long(nearest.size() / 2), nearest.end());
        spacing_ = nearest[nearest.size() / 2];
    }

    /// Still dots close the face: spread over the skin that lies just beyond reach of all markers, and over rigid skin.
    void place_still_ring() {
        constexpr float kInner = 2.5f, kOuter = 4.5f;  // in dot spacings from the nearest marker
        std::vector<std::pair<std::uint32_t, float>> seeds;
        for (const Dot& dot : dots_) seeds.insert(seeds.end(), dot.seeds.begin(), dot.seeds.end());
        to_marker_.assign(mesh_.vertex_count(), 1e9f);
        std::vector<std::uint32_t> ring;
        for (const auto& r : skin_.from(seeds)) {
            to_marker_[r.vertex] = r.distance;
            const bool beyond = r.distance > kInner * spacing_ && r.distance < kOuter * spacing_;
            const bool skull = still_[r.vertex] && r.distance > spacing_;
            if (beyond || skull) ring.push_back(r.vertex);
        }
        reach_ = kInner * spacing_;
        std::vector<std::uint32_t> placed;
        for (const std::uint32_t v : ring) {
            if (std::any_of(placed.begin(), placed.end(), [&](std::uint32_t u) { return (position(u) - position(v)).norm() < spacing_; })) continue;
            placed.push_back(v);
            dots_.push_back({kStill, v, position(v), {{v, 0.0f}}});
        }
    }

    /// For every vertex: dots along the skin, nearest first.
    void measure_vertices() {
        const float limit = 5 * spacing_;
        std::vector<std::vector<SurfaceDistance::Reached>> reached(dots_.size());
        parallel_for(std::int64_t(dots_.size()), [&](std::int64_t d) { reached[d] = skin_.from(dots_[d].seeds, limit); });
        around_.resize(mesh_.vertex_count());
        for (std::uint32_t d = 0; d < dots_.size(); ++d)
            for (const auto& r : reached[d]) around_[r.vertex].push_back({d, r.distance, dots_[d].position});
        for (auto& list : around_)
            std::sort(list.begin(), list.end(), [](const Candidate& a, const Candidate& b) {
                return std::pair(a.distance, a.index) < std::pair(b.distance, b.index);
            });
    }

    /// Evenly spread vertices of the face, closer together only where labels part them.
    void place_grid() {
        std::vector<std::uint32_t> face;
        for (std::uint32_t v = 0; v < mesh_.vertex_count(); ++v)
            if (skin_.carries(v) && to_marker_[v] < reach_ && !around_[v].empty()) face.push_back(v);
        if (int(face.size()) <= options_.grid_points) {
            grid_ = face;
        } else {
            double area = 0;
            for (const auto& [a, b, c] : mesh_.triangles)
                if (to_marker_[a] < reach_ && to_marker_[b] < reach_ && to_marker_[c] < reach_)
                    area += (position(b) - position(a)).cross(position(c) - position(a)).norm() / 2;
            const float gap = float(std::sqrt(area / options_.grid_points) * 0.85);  // greedy spreading packs that dense
            for (const std::uint32_t v : face)
                if (std::none_of(grid_.begin(), grid_.end(), [&](std::uint32_t u) {
                        return (position(u) - position(v)).squaredNorm() < gap * gap && !conflict(u, v);
                    }))
                    grid_.push_back(v);
        }
        // Grid points around every vertex, as measure_vertices does for dots.
        const float limit = 2.0f * spacing_;
        std::vector<std::vector<SurfaceDistance::Reached>> reached(grid_.size());
        parallel_for(std::int64_t(grid_.size()), [&](std::int64_t g) { reached[g] = skin_.from({{grid_[g], 0.0f}}, limit); });
        near_grid_.resize(mesh_.vertex_count());
        for (std::uint32_t g = 0; g < grid_.size(); ++g)
            for (const auto& r : reached[g])
                if (near_grid_[r.vertex].size() < 64) near_grid_[r.vertex].push_back({g, r.distance, position(grid_[g])});
        for (auto& list : near_grid_)
            std::sort(list.begin(), list.end(), [](const Candidate& a, const Candidate& b) {
                return std::pair(a.distance, a.index) < std::pair(b.distance, b.index);
            });
    }

    void assign_grid() {
        shares_.resize(grid_.size());
        for (std::uint32_t g = 0; g < grid_.size(); ++g) {
            std::vector<Candidate> allowed;
            for (const Candidate& c : around_[grid_[g]])
                if (!conflict(grid_[g], dots_[c.index].vertex)) allowed.push_back(c);
            const auto chosen = choose(position(grid_[g]), allowed, options_);
            double total = 0;
            for (const Candidate& c : chosen) total += 1 / std::max(c.distance, 1e-3f);
            for (const Candidate& c : chosen)
                if (dots_[c.index].marker != kStill)
                    shares_[g][dots_[c.index].marker] += float(1 / std::max(c.distance, 1e-3f) / total);
        }
    }

    void smooth_grid() {
        std::vector<Shares> next(grid_.size());
        for (std::uint32_t g = 0; g < grid_.size(); ++g) {
            const int kind = outline(grid_[g]);
            std::vector<Candidate> allowed;
            for (const Candidate& c : near_grid_[grid_[g]])
                if (c.index != g && !conflict(grid_[g], grid_[c.index]) && outline(grid_[c.index]) == kind) allowed.push_back(c);
            const auto neighbours = choose(position(grid_[g]), allowed, options_);
            if (neighbours.empty()) {
                next[g] = shares_[g];
                continue;
            }
            add_scaled(next[g], shares_[g], float(1 - options_.smoothing));
            for (const Candidate& c : neighbours) add_scaled(next[g], shares_[c.index], float(options_.smoothing / double(neighbours.size())));
        }
        shares_ = std::move(next);
    }

    /// The paper copies the nearest grid point of the same label, which moves patches of skin as plates. We mix the
    /// nearest few by the inverse square of their distance, so that the skin stays smooth.
    Shares from_grid(std::uint32_t v) const {
        constexpr int kMixed = 4;
        Shares shares;
        double total = 0;
        int mixed = 0;
        for (const Candidate& c : near_grid_[v]) {
            if (conflict(v, grid_[c.index])) continue;
            const double weight = 1 / (double(c.distance) * c.distance + 1e-6);
            add_scaled(shares, shares_[c.index], float(weight));
            total += weight;
            if (++mixed == kMixed) break;
        }
        for (auto& [dot, share] : shares) share = float(share / total);
        keep_apart(v, shares);
        return shares;
    }

    /// Grid points beside a slit mix dots from above and below it; where a vertex on one side takes part in one, what comes
    /// from the other side goes to its own.
    void keep_apart(std::uint32_t v, Shares& shares) const {
        double kept = 0, total = 0;
        for (const auto& [marker, share] : shares) {
            total += share;
            if (!conflict(v, marker_vertex_[marker])) kept += share;
        }
        if (kept == total || kept <= 0) return;
        std::erase_if(shares, [&](const auto& term) { return conflict(v, marker_vertex_[term.first]); });
        for (auto& [marker, share] : shares) share = float(share * total / kept);
    }

    void assign_skin() {
        vertex_shares_.resize(mesh_.vertex_count());
        for (std::uint32_t v = 0; v < mesh_.vertex_count(); ++v)
            if (skin_.carries(v) && !still_[v]) vertex_shares_[v] = from_grid(v);
    }

    /// Lashes, tear film and hair go where the skin that they touch goes.
    void assign_attachments() {
        std::vector<std::uint32_t> face;
        for (std::uint32_t v = 0; v < mesh_.vertex_count(); ++v)
            if (!vertex_shares_[v].empty()) face.push_back(v);
        const std::vector<Rooted> rooted = hang_on_skin(mesh_, face, spacing_);
        for (std::uint32_t v = 0; v < mesh_.vertex_count(); ++v) {
            const std::uint32_t rim = rooted[v].rim;
            if (rim == kNoRim || still_[v] || skin_.carries(v)) continue;
            if ((position(rim) - position(v)).norm() < spacing_) vertex_shares_[v] = vertex_shares_[rim];
        }
    }

    std::vector<Surface> vertex_surfaces() const {
        const std::vector<Surface> of_triangle = mesh_.triangle_surfaces();
        std::vector<Surface> surface(mesh_.vertex_count(), Surface::other);
        for (std::size_t t = 0; t < mesh_.triangles.size(); ++t)
            for (const std::uint32_t v : mesh_.triangles[t]) surface[v] = of_triangle[t];
        return surface;
    }

    /// What lies behind the skin hangs on two things: lining (the walls of the mouth, the sockets of the eyes) follows the
    /// rim of skin that it grows from, the less the deeper it lies (the paper's rows of inner-mouth vertices); all else is
    /// bone: what belongs to the lower jaw turns with the chin about the hinge, the rest is skull.
    void assign_inner_mouth() {
        const std::vector<Surface> surface = vertex_surfaces();
        const auto mouth = std::find_if(slits_.begin(), slits_.end(), [](const Slit& s) { return s.mouth; });
        Shares chin;
        Vec3 lips = Vec3::Zero(), hinge = Vec3::Zero();
        if (mouth != slits_.end() && !grid_.empty()) {
            lips = mouth->line[mouth->line.size() / 2];
            const Vec3 below = lips - Vec3(0, 28, 5);
            chin = shares_[std::size_t(std::min_element(grid_.begin(), grid_.end(), [&](std::uint32_t a, std::uint32_t b) {
                                           return (position(a) - below).squaredNorm() < (position(b) - below).squaredNorm();
                                       }) - grid_.begin())];
            hinge = lips - Vec3(0, 0, kHingeBehindLips);
        }
        // 0 at the hinge, 1 at the lips: a small turn about the hinge moves by that much of the chin's way.
        const auto on_jaw = [&](const Vec3& p) { return std::clamp((p.z() - hinge.z()) / kHingeBehindLips, 0.0f, 1.0f); };

        const std::vector<Piece> piece_of = connected_pieces(mesh_);
        std::vector<std::uint32_t> roots;
        for (std::uint32_t v = 0; v < mesh_.vertex_count(); ++v)
            if (skin_.carries(v) && !vertex_shares_[v].empty()) roots.push_back(v);
        const std::vector<Rooted> rooted = grow_lining(mesh_, roots);
        for (std::uint32_t v = 0; v < mesh_.vertex_count(); ++v) {
            if (still_[v] || skin_.carries(v)) continue;
            const bool lining = surface[v] == Surface::mouth && rooted[v].rim != kNoRim;
            if (surface[v] != Surface::teeth && surface[v] != Surface::mouth) continue;
            // What reaches over both jaws leaves the lower one gradually on its way up; all else belongs to one as a whole.
            const Piece& piece = piece_of[v];
            const bool both = lining || (piece.low < lips.y() - kOneJaw && piece.high > lips.y() + kOneJaw);
            const float lower = both ? std::clamp((lips.y() - position(v).y()) / (2 * kOneJaw) + 0.5f, 0.0f, 1.0f) : float(piece.mean < lips.y());
            const float skin = lining ? std::exp(-rooted[v].depth * rooted[v].depth / (kLiningDepth * kLiningDepth)) : 0.0f;
            Shares shares;
            if (lining) add_scaled(shares, vertex_shares_[rooted[v].rim], skin);
            add_scaled(shares, chin, (1 - skin) * lower * on_jaw(position(v)));
            vertex_shares_[v] = shares;
        }
    }

    static constexpr float kHingeBehindLips = 90;  // mm; Bonwill's triangle: condyles about 100 mm from the incisors
    static constexpr float kOneJaw = 10;           // mm above and below the line between the lips
    static constexpr float kLiningDepth = 14;      // mm along the lining at which it has let go of the skin

    model::BlendBase pack() const {
        constexpr float kNegligible = 1.0f / 512;  // of a 40 mm jaw stroke: below 0.1 mm
        model::BlendBase base;
        base.markers.resize(Eigen::Index(sites_.size()), 3);
        for (std::size_t m = 0; m < sites_.size(); ++m) base.markers.row(Eigen::Index(m)) = sites_[m].position(mesh_.positions).transpose();
        base.sites = sites_;
        base.row_start.push_back(0);
        for (const Shares& shares : vertex_shares_) {
            for (const auto& [dot, share] : shares)
                if (share >= kNegligible) base.terms.push_back({dot, share});
            base.row_start.push_back(std::uint32_t(base.terms.size()));
        }
        return base;
    }

    const Mesh& mesh_;
    const std::vector<Site>& sites_;
    const BlendOptions options_;
    SurfaceDistance skin_;
    std::vector<Slit> slits_;
    std::vector<char> still_;                    // V
    std::vector<Dot> dots_;
    std::vector<std::uint32_t> marker_vertex_;   // of every marker
    float spacing_ = 0;                          // median distance between neighbouring markers, mm
    float reach_ = 0;                            // the face ends that far from the nearest marker, mm
    std::vector<float> to_marker_;               // V
    std::vector<std::vector<Candidate>> around_;     // V: dots
    std::vector<std::uint32_t> grid_;            // vertices
    std::vector<std::vector<Candidate>> near_grid_;  // V: grid points
    std::vector<Shares> shares_;                 // of grid points
    std::vector<Shares> vertex_shares_;          // V
};

}  // namespace

Result<model::BlendBase> blend_coefficients(const Mesh& neutral, const std::vector<Site>& sites,
                                            const std::vector<std::uint32_t>& rigid, const BlendOptions& options) {
    return Blender(neutral, sites, rigid, options).run();
}

}  // namespace mien::encoder
