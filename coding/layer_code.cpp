#include "coding/layer_code.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "coding/mesh_traversal.hpp"
#include "coding/vertex_values.hpp"
#include "core/byte_io.hpp"

namespace mien::coding {
namespace {

// Of the format (docs/format-model.md).
constexpr std::uint32_t kMaxMarkers = 1u << 16;
constexpr std::uint32_t kMaxTargets = 4096;
constexpr std::size_t kMaxTargetName = 256;
constexpr std::uint64_t kMaxTargetValues = 1u << 26;  // vertices x targets: 57 targets of a million-vertex head
constexpr int kShares = 255;
constexpr int kHolds = 127;
constexpr int kLidShares = 64, kLidWeights = 255;

Error damaged(const char* what) { return {ErrorCode::damaged, std::string("the ") + what + " blob does not decode"}; }

}  // namespace

Bytes encode_blend(const std::vector<Site>& sites, const SparseRows& rows) {
    ByteWriter out;
    out.varint(sites.size());
    for (const Site& site : sites) {
        for (const std::uint32_t v : site.vertices) out.varint(v);
        for (const float w : site.weights) out.f32(w);
    }
    out.varint(rows.row_start.size() - 1);
    for (std::size_t j = 0; j + 1 < rows.row_start.size(); ++j) {
        // Rounded running sums keep the row's total, and with it the pull of the still points.
        std::vector<std::pair<std::uint32_t, int>> kept;
        double sum = 0;
        int given = 0;
        for (std::uint32_t i = rows.row_start[j]; i < rows.row_start[j + 1]; ++i) {
            sum += rows.terms[i].share;
            const int upto = std::min(kShares, int(std::lround(sum * kShares)));
            if (upto > given) kept.emplace_back(rows.terms[i].column, upto - given);
            given = std::max(given, upto);
        }
        out.varint(kept.size());
        std::uint32_t previous = 0;
        for (const auto& [column, share] : kept) {
            out.varint(column - previous);
            out.u8(std::uint8_t(share));
            previous = column;
        }
    }
    return out.take();
}

Result<Blend> decode_blend(ByteView bytes, std::uint32_t V) {
    ByteReader in(bytes);
    Blend blend;
    const std::uint64_t M = in.varint();
    if (in.ok() && M > kMaxMarkers) return Error{ErrorCode::limit_exceeded, "the blend blob announces too many markers"};
    for (std::uint64_t m = 0; m < M && in.ok(); ++m) {
        Site site;
        for (std::uint32_t& v : site.vertices) {
            const std::uint64_t vertex = in.varint();
            if (vertex >= V) return damaged("blend");
            v = std::uint32_t(vertex);
        }
        for (float& w : site.weights) {
            w = in.f32();
            if (!(std::abs(w) < 1e3f)) return damaged("blend");
        }
        blend.sites.push_back(site);
    }
    if (in.varint() != V || !in.ok()) return damaged("blend");
    blend.rows.row_start.push_back(0);
    for (std::uint32_t j = 0; j < V; ++j) {
        const std::uint64_t count = in.varint();
        if (!in.ok() || count > std::min<std::uint64_t>(M, kShares)) return damaged("blend");
        std::uint64_t column = 0;
        int total = 0;
        for (std::uint64_t i = 0; i < count; ++i) {
            const std::uint64_t gap = in.varint();
            if (gap >= M || (i > 0 && gap == 0)) return damaged("blend");
            column += gap;
            const std::uint8_t share = in.u8();
            total += share;
            if (!in.ok() || column >= M || share == 0 || total > kShares) return damaged("blend");
            blend.rows.terms.push_back({std::uint32_t(column), float(share) / kShares});
        }
        blend.rows.row_start.push_back(std::uint32_t(blend.rows.terms.size()));
    }
    if (!in.at_end()) return damaged("blend");
    return blend;
}

Bytes encode_blendshapes(const std::vector<Blendshape>& targets, const std::vector<Triangle>& triangles, float step) {
    ByteWriter out;
    out.varint(targets.size());
    out.f32(step);
    for (const Blendshape& target : targets) out.text(target.name.substr(0, kMaxTargetName));
    RangeEncoder coder;
    if (!targets.empty()) {
        const auto V = std::uint32_t(targets.front().offsets.rows());
        const Traversal traversal = traverse(V, triangles);
        VertexValueModel<3> model;
        std::vector<std::array<std::int32_t, 3>> values(V);
        for (const Blendshape& target : targets) {
            assert(target.offsets.rows() == V);
            for (std::uint32_t v = 0; v < V; ++v)
                for (int c = 0; c < 3; ++c) values[v][std::size_t(c)] = std::int32_t(std::lround(target.offsets(v, c) / step));
            code_values<3>(coder, model, traversal, values);
        }
    }
    const Bytes coded = coder.finish();
    out.varint(coded.size());
    out.bytes(coded);
    return out.take();
}

Result<std::vector<Blendshape>> decode_blendshapes(ByteView bytes, std::uint32_t V, const std::vector<Triangle>& triangles) {
    ByteReader in(bytes);
    const std::uint64_t count = in.varint();
    const float step = in.f32();
    if (!in.ok() || !(step > 1e-9f && step < 1e6f)) return damaged("blendshape");
    if (count > kMaxTargets || count * V > kMaxTargetValues)
        return Error{ErrorCode::limit_exceeded, "the blendshape blob announces too many targets"};
    std::vector<Blendshape> targets;
    for (std::uint64_t i = 0; i < count && in.ok(); ++i) targets.push_back({in.text(kMaxTargetName), {}});
    const ByteView coded = in.bytes(in.varint());
    if (!in.ok() || !in.at_end()) return damaged("blendshape");
    RangeDecoder coder(coded);
    if (count > 0) {
        const Traversal traversal = traverse(V, triangles);
        VertexValueModel<3> model;
        std::vector<std::array<std::int32_t, 3>> values(V);
        for (Blendshape& target : targets) {
            code_values<3>(coder, model, traversal, values);
            if (coder.failed()) return damaged("blendshape");
            target.offsets.resize(V, 3);
            for (std::uint32_t v = 0; v < V; ++v)
                for (int c = 0; c < 3; ++c) target.offsets(v, c) = step * float(values[v][std::size_t(c)]);
        }
    }
    if (!coder.complete()) return damaged("blendshape");
    return targets;
}

Bytes encode_eyes(const std::array<std::optional<Ball>, 2>& eyes) {
    ByteWriter out;
    for (const auto& eye : eyes) {
        out.u8(eye.has_value());
        if (!eye) continue;
        for (int c = 0; c < 3; ++c) out.f32(eye->centre[c]);
        // Runs of consecutive vertices: gap, length - 1.
        std::vector<std::array<std::uint32_t, 2>> runs;
        for (const std::uint32_t v : eye->vertices) {
            if (!runs.empty() && v == runs.back()[0] + runs.back()[1]) ++runs.back()[1];
            else runs.push_back({v, 1});
        }
        out.varint(runs.size());
        std::uint32_t end = 0;
        for (const auto& [first, length] : runs) {
            out.varint(first - end);
            out.varint(length - 1);
            end = first + length;
        }
    }
    return out.take();
}

Result<std::array<std::optional<Ball>, 2>> decode_eyes(ByteView bytes, std::uint32_t V) {
    ByteReader in(bytes);
    std::array<std::optional<Ball>, 2> eyes;
    for (auto& eye : eyes) {
        const std::uint8_t present = in.u8();
        if (!in.ok() || present > 1) return damaged("eyes");
        if (!present) continue;
        eye.emplace();
        for (int c = 0; c < 3; ++c) {
            eye->centre[c] = in.f32();
            if (!(std::abs(eye->centre[c]) < 1e6f)) return damaged("eyes");
        }
        const std::uint64_t runs = in.varint();
        if (runs > V) return damaged("eyes");
        std::uint64_t end = 0;
        for (std::uint64_t r = 0; r < runs; ++r) {
            const std::uint64_t first = in.varint(), length = in.varint();
            if (!in.ok() || first >= V || length >= V || end + first + length >= V) return damaged("eyes");
            for (std::uint64_t v = end + first; v <= end + first + length; ++v) eye->vertices.push_back(std::uint32_t(v));
            end += first + length + 1;
        }
    }
    if (!in.ok() || !in.at_end()) return damaged("eyes");
    return eyes;
}

Bytes encode_contact(const Contact& contact) {
    assert(!contact.pairs.empty() && contact.pairs.size() <= kMaxContactPairs);
    ByteWriter out;
    out.varint(contact.pairs.size());
    for (const auto& pair : contact.pairs)
        for (const std::uint32_t v : pair) out.varint(v);
    out.varint(contact.members.size());
    std::uint32_t next = 0;
    for (const Contact::Member& member : contact.members) {
        assert(member.vertex >= next && member.hold != 0 && std::abs(member.hold) <= 1);
        const int hold = std::max(1, int(std::lround(std::abs(member.hold) * kHolds)));
        out.varint(member.vertex - next);
        out.u8(std::uint8_t(member.hold > 0 ? hold : 256 - hold));
        next = member.vertex + 1;
    }
    return out.take();
}

Result<Contact> decode_contact(ByteView bytes, std::uint32_t V) {
    ByteReader in(bytes);
    Contact contact;
    const std::uint64_t pairs = in.varint();
    if (!in.ok() || pairs == 0 || pairs > kMaxContactPairs) return damaged("contact");
    for (std::uint64_t i = 0; i < pairs; ++i) {
        const std::uint64_t upper = in.varint(), lower = in.varint();
        if (!in.ok() || upper >= V || lower >= V) return damaged("contact");
        contact.pairs.push_back({std::uint32_t(upper), std::uint32_t(lower)});
    }
    const std::uint64_t members = in.varint();
    if (!in.ok() || members > V) return damaged("contact");
    std::uint64_t next = 0;
    for (std::uint64_t i = 0; i < members; ++i) {
        const std::uint64_t gap = in.varint();
        const int hold = static_cast<std::int8_t>(in.u8());
        if (!in.ok() || gap >= V || next + gap >= V || hold == 0 || hold < -kHolds) return damaged("contact");
        next += gap;
        contact.members.push_back({std::uint32_t(next++), float(hold) / kHolds});
    }
    if (!in.at_end()) return damaged("contact");
    return contact;
}

Bytes encode_lid(const Lid& lid) {
    ByteWriter out;
    for (int c = 0; c < 3; ++c) out.f32(lid.centre[c]);
    out.varint(lid.members.size());
    std::uint32_t next = 0;
    for (const Lid::Member& member : lid.members) {
        assert(member.vertex >= next && member.share >= 0 && member.weight >= 0 && member.weight <= 1 && member.hold >= 0 && member.hold <= 1);
        out.varint(member.vertex - next);
        out.u8(std::uint8_t(std::min<long>(std::lround(member.share * kLidShares), 255)));
        out.u8(std::uint8_t(std::lround(member.weight * kLidWeights)));
        out.u8(std::uint8_t(std::lround(member.hold * kLidWeights)));
        next = member.vertex + 1;
    }
    return out.take();
}

Result<Lid> decode_lid(ByteView bytes, std::uint32_t V) {
    ByteReader in(bytes);
    Lid lid;
    for (int c = 0; c < 3; ++c) {
        lid.centre[c] = in.f32();
        if (!(std::abs(lid.centre[c]) < 1e6f)) return damaged("lid");
    }
    const std::uint64_t members = in.varint();
    if (!in.ok() || members > V) return damaged("lid");
    std::uint64_t next = 0;
    for (std::uint64_t i = 0; i < members; ++i) {
        const std::uint64_t gap = in.varint();
        const std::uint8_t share = in.u8(), weight = in.u8(), hold = in.u8();
        if (!in.ok() || gap >= V || next + gap >= V) return damaged("lid");
        next += gap;
        lid.members.push_back({std::uint32_t(next++), float(share) / kLidShares, float(weight) / kLidWeights, float(hold) / kLidWeights});
    }
    if (!in.at_end()) return damaged("lid");
    return lid;
}

}  // namespace mien::coding
