#include "coding/mesh_traversal.hpp"

#include <algorithm>
#include <deque>
#include <unordered_map>

namespace mien::coding {
namespace {

/// Triangles around every vertex, as one flat list.
struct Incidence {
    std::vector<std::uint32_t> start, triangles;
    Incidence(std::uint32_t V, const std::vector<Triangle>& mesh) : start(V + 1), triangles(mesh.size() * 3) {
        for (const Triangle& t : mesh)
            for (const std::uint32_t v : t) ++start[v + 1];
        for (std::uint32_t v = 0; v < V; ++v) start[v + 1] += start[v];
        std::vector<std::uint32_t> next(start.begin(), start.end() - 1);
        for (std::uint32_t t = 0; t < mesh.size(); ++t)
            for (const std::uint32_t v : mesh[t]) triangles[next[v]++] = t;
    }
};

class Walk {
public:
    Walk(std::uint32_t V, const std::vector<Triangle>& triangles)
        : V_(V), mesh_(triangles), around_(V, triangles), known_(V), degree_(V) {}

    Traversal run() {
        Traversal out;
        out.steps.reserve(V_);
        std::uint32_t previous = 0;
        for (std::uint32_t seed = 0; seed < V_; ++seed) {
            if (known_[seed]) continue;
            visit(seed, out.steps.empty() ? seed : previous, out);
            for (std::uint32_t v; (v = best()) != kNone;) visit(v, kNone, out);
            previous = out.steps.back().vertex;
        }
        return out;
    }

private:
    static constexpr std::uint32_t kNone = 0xffffffffu;
    static constexpr int kLevels = 4;  // vertices touching no, one, two, three or more complete edges
    // A hostile mesh may hang all its triangles on one edge; what is looked at for one prediction stays bounded.
    static constexpr std::uint32_t kMaxFan = 32, kMaxParallelograms = 8;

    std::uint32_t best() {
        for (int level = kLevels - 1; level >= 0; --level)
            while (!queue_[level].empty()) {
                const std::uint32_t v = queue_[level].front();
                queue_[level].pop_front();
                if (!known_[v] && std::min<int>(degree_[v], kLevels - 1) == level) return v;
            }
        return kNone;
    }

    void visit(std::uint32_t v, std::uint32_t nearest, Traversal& out) {
        TraversalStep step{v, std::uint32_t(out.parallelograms.size()), 0, nearest};
        for (std::uint32_t i = around_.start[v]; i < around_.start[v + 1]; ++i) {
            const Triangle& t = mesh_[around_.triangles[i]];
            const int corner = t[0] == v ? 0 : t[1] == v ? 1 : 2;
            const std::uint32_t a = t[(corner + 1) % 3], b = t[(corner + 2) % 3];
            if (known_[a] && step.nearest == kNone) step.nearest = a;
            if (known_[b] && step.nearest == kNone) step.nearest = b;
            if (!known_[a] || !known_[b] || a == v || b == v) continue;
            if (out.parallelograms.size() - step.first == kMaxParallelograms) continue;
            if (const std::uint32_t c = across(a, b, v); c != kNone) out.parallelograms.push_back({a, b, c});
        }
        step.count = std::uint32_t(out.parallelograms.size()) - step.first;
        out.steps.push_back(step);
        known_[v] = true;
        for (std::uint32_t i = around_.start[v]; i < around_.start[v + 1]; ++i) {
            const Triangle& t = mesh_[around_.triangles[i]];
            const int known = known_[t[0]] + known_[t[1]] + known_[t[2]];
            for (const std::uint32_t u : t)
                if (!known_[u]) {
                    degree_[u] += known == 2;
                    queue_[std::min<int>(degree_[u], kLevels - 1)].push_back(u);
                }
        }
    }

    /// A known vertex that makes a triangle with edge (a, b) on the other side than v.
    std::uint32_t across(std::uint32_t a, std::uint32_t b, std::uint32_t v) const {
        for (std::uint32_t i = around_.start[a]; i < std::min(around_.start[a + 1], around_.start[a] + kMaxFan); ++i) {
            const Triangle& t = mesh_[around_.triangles[i]];
            if (t[0] != b && t[1] != b && t[2] != b) continue;
            for (const std::uint32_t c : t)
                if (c != a && c != b && c != v && known_[c]) return c;
        }
        return kNone;
    }

    std::uint32_t V_;
    const std::vector<Triangle>& mesh_;
    Incidence around_;
    std::vector<char> known_;
    std::vector<std::uint32_t> degree_;  // triangles whose other two corners are known
    std::deque<std::uint32_t> queue_[kLevels];
};

}  // namespace

Traversal traverse(std::uint32_t V, const std::vector<Triangle>& triangles) { return Walk(V, triangles).run(); }

}  // namespace mien::coding
