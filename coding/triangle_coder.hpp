#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <unordered_map>
#include <vector>

#include "coding/integer_model.hpp"
#include "core/mesh.hpp"

namespace mien::coding {

/// What both sides know while they walk through the triangles in their stored order. A triangle either continues across
/// one of the latest edges or starts afresh; a corner is the next unused vertex, the other end of an open edge, a step like
/// the last one, or a number.
template <class Coder>
class TriangleCoder {
public:
    TriangleCoder(Coder& coder, std::uint32_t V) : coder_(coder), V_(V) {}

    void code(Triangle& t) {
        std::int32_t hit = 0, rotation = 0;
        if constexpr (!Coder::kDecodes) find(t, hit, rotation);
        edges_.code(coder_, hit, {{last_hit_, last_rotation_ * 5 + last_kind_[2]}, 0, 0});
        if (hit < 0 || hit > int(recent_.size())) return coder_.fail();
        if (hit > 0) {
            const Edge edge = recent_[recent_.size() - std::size_t(hit)];
            rotations_.code(coder_, rotation, {{last_rotation_, std::min(hit, 7)}, 0, 0});
            if (rotation < 0 || rotation > 2) return coder_.fail();
            const int r = rotation;
            if (Coder::kDecodes) {
                t[r] = edge[1];
                t[(r + 1) % 3] = edge[0];
            }
            corner(t[(r + 2) % 3], edge[0], edge[1], 2);
            recent_.erase(recent_.end() - hit);
            remember({t[(r + 1) % 3], t[(r + 2) % 3]});
            remember({t[(r + 2) % 3], t[r]});
        } else {
            corner(t[0], last_[0], last_[1], 0);
            corner(t[1], t[0], last_[1], 1);
            corner(t[2], t[1], t[0], 2);
            for (int i = 0; i < 3; ++i) remember({t[i], t[(i + 1) % 3]});
        }
        for (int i = 0; i < 3; ++i) close(t[i], t[(i + 1) % 3]);
        last_ = t;
        last_hit_ = std::min(hit, 31);
        last_rotation_ = rotation;
    }

private:
    using Edge = std::array<std::uint32_t, 2>;
    using Ends = std::vector<std::uint32_t>;
    static constexpr std::size_t kRecent = 32;   // edges remembered
    static constexpr std::size_t kMaxOpen = 12;  // ends remembered at one vertex
    static constexpr int kLimit = 255;           // of the adaptive counts

    void find(const Triangle& t, std::int32_t& hit, std::int32_t& rotation) const {
        for (std::size_t back = 1; back <= recent_.size(); ++back) {
            const Edge edge = recent_[recent_.size() - back];
            for (int r = 0; r < 3; ++r)
                if (t[r] == edge[1] && t[(r + 1) % 3] == edge[0]) {
                    hit = std::int32_t(back);
                    rotation = r;
                    return;
                }
        }
    }
    void remember(const Edge& edge) {
        if (recent_.size() == kRecent) recent_.erase(recent_.begin());
        recent_.push_back(edge);
    }

    /// Edge (from, to) of a new triangle closes (to, from) where that was open, else it is open itself.
    void close(std::uint32_t from, std::uint32_t to) {
        const auto erase = [](Ends& ends, std::uint32_t v) {
            const auto at = std::find(ends.begin(), ends.end(), v);
            if (at == ends.end()) return false;
            ends.erase(at);
            return true;
        };
        const auto add = [](Ends& ends, std::uint32_t v) {
            if (ends.size() == kMaxOpen) ends.erase(ends.begin());
            ends.push_back(v);
        };
        if (erase(out_[to], from)) {
            erase(in_[from], to);
            if (out_[to].empty()) out_.erase(to);
            if (in_[from].empty()) in_.erase(from);
        } else {
            add(out_[from], to);
            add(in_[to], from);
        }
    }
    static const Ends& ends_of(const std::unordered_map<std::uint32_t, Ends>& open, std::uint32_t v) {
        static const Ends none;
        const auto at = open.find(v);
        return at == open.end() ? none : at->second;
    }

    /// Fills linked_: vertices v for which edges (a, v) and, of the last corner, (v, b) would close open ones. Those that
    /// close two come first, then the latest.
    void link(std::uint32_t a, std::uint32_t b, int place) {
        linked_.clear();
        both_ = 0;
        if (place == 0) return;
        const Ends &in = ends_of(in_, a), &out = ends_of(out_, b);
        if (place == 2)
            for (std::size_t i = in.size(); i-- > 0;)
                if (in[i] != b && std::find(out.begin(), out.end(), in[i]) != out.end()) linked_.push_back(in[i]);
        both_ = int(linked_.size());
        const auto append = [&](const Ends& ends) {
            for (std::size_t i = ends.size(); i-- > 0;)
                if (ends[i] != a && ends[i] != b && std::find(linked_.begin(), linked_.end(), ends[i]) == linked_.end())
                    linked_.push_back(ends[i]);
        };
        append(in);
        if (place == 2) append(out);
    }

    /// One corner, given two known ones. kind: 0 the next unused vertex, 1 as far from `a` as the last corner was from its
    /// own, 2 one of the latest edges' ends, 3 a number, 4 at the other end of an open edge.
    void corner(std::uint32_t& v, std::uint32_t a, std::uint32_t b, int place) {
        const std::uint32_t stepped = std::uint32_t(std::int64_t(a) + last_delta_[place]);
        link(a, b, place);
        std::int32_t kind = 3, which = 0;
        if constexpr (!Coder::kDecodes) {
            const auto at = std::find(linked_.begin(), linked_.end(), v);
            which = std::int32_t(at - linked_.begin());
            if (v == next_) kind = 0;
            else if (at != linked_.end() && which < both_) kind = 4;
            else if (v == stepped) kind = 1;
            else if (at != linked_.end()) kind = 4;
            else if ((which = end_of_recent(v, a, b)) >= 0) kind = 2;
        }
        const int known = int(linked_.size());
        kinds_.code(coder_, kind, {{last_kind_[place], place * 32 + last_hit_, last_kind_[place] * 5 + before_kind_[place],
                                    (place * 4 + std::min(known, 3)) * 3 + std::min(both_, 2)}, 0, 0});
        if (kind < 0 || kind > 4) return coder_.fail();
        if (kind == 2) {
            whichs_.code(coder_, which, {{place, last_hit_}, 0, 0});
            if (which < 0 || which >= int(recent_.size())) return coder_.fail();
        }
        if (kind == 4) {
            links_.code(coder_, which, {{place * 8 + std::min(known, 7), std::min(both_, 3)}, 0, 0});
            if (which < 0 || which >= known) return coder_.fail();
        }
        std::int32_t delta = 0;
        if (kind == 3) {
            if constexpr (!Coder::kDecodes) delta = std::int32_t(std::int64_t(v) - a);
            numbers_.code(coder_, delta, {{place, magnitude_level(std::uint32_t(std::abs(last_delta_[place])), 16)}, 0, 0});
        }
        if (Coder::kDecodes)
            v = kind == 0   ? next_
                : kind == 1 ? stepped
                : kind == 2 ? recent_[recent_.size() - 1 - std::size_t(which)][1]
                : kind == 4 ? linked_[std::size_t(which)]
                            : std::uint32_t(std::int64_t(a) + delta);
        if (v >= V_) {
            v = 0;
            return coder_.fail();
        }
        if (kind != 2) last_delta_[place] = std::int32_t(std::int64_t(v) - a);
        before_kind_[place] = last_kind_[place];
        last_kind_[place] = kind;
        if (v >= next_) next_ = v + 1;
    }
    std::int32_t end_of_recent(std::uint32_t v, std::uint32_t a, std::uint32_t b) const {
        if (v == a || v == b) return -1;
        for (std::size_t i = 0; i < recent_.size(); ++i)
            if (recent_[recent_.size() - 1 - i][1] == v) return std::int32_t(i);
        return -1;
    }

    static IntegerModel model(std::initializer_list<int> contexts) {
        return IntegerModel(std::vector<int>(contexts), 1, 1, kLimit);
    }

    Coder& coder_;
    std::uint32_t V_;
    std::uint32_t next_ = 0;            ///< the lowest vertex number above all used
    std::vector<Edge> recent_;          ///< latest last
    std::unordered_map<std::uint32_t, Ends> in_, out_;  ///< other ends of open edges to and from a vertex
    Ends linked_;
    int both_ = 0;                      ///< how many of linked_ close two edges
    Triangle last_{};
    int last_hit_ = 0, last_rotation_ = 0;
    std::array<std::int32_t, 3> last_delta_{};
    std::array<int, 3> last_kind_{}, before_kind_{};
    IntegerModel edges_ = model({32, 15}), rotations_ = model({3, 8}), kinds_ = model({5, 96, 25, 36}), whichs_ = model({3, 32}),
                 links_ = model({24, 4}), numbers_ = model({3, 16});
};

}  // namespace mien::coding
