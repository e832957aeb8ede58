#include "coding/detail_code.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "coding/integer_model.hpp"
#include "coding/mesh_code.hpp"
#include "core/byte_io.hpp"

namespace mien::coding {
namespace {

// Of the format (docs/format-detail.md).
constexpr int kWeights = 4096;
constexpr std::int64_t kMaxWeight = 16 * kWeights;  // sites of a little outside their triangle
constexpr int kMantissa = 12;                       // bits
constexpr int kMaxExponent = 40;
constexpr std::int32_t kMaxFactor = 1 << 20;
constexpr int kLimit = 255;
constexpr int kLevels = 12;
constexpr float kMaxReach = 1000;
constexpr int kHasExtents = 128;

Error damaged(const char* what) { return {ErrorCode::damaged, std::string("the ") + what + " blob does not decode"}; }

template <class Coder>
void code_axes(Coder& coder, std::vector<std::array<float, MarkerDomain::kAxes>>& axes) {
    const std::array<int, 2> counts = {MarkerDomain::kAxes, kLevels};
    IntegerModel exponents(std::array<int, 1>{1}, 1, 1, kLimit), mantissas(counts, 1, 1, kLimit);
    std::int32_t before = 0;
    for (auto& row : axes) {
        std::int32_t exponent = 0;  // of the power of two above all
        if (!Coder::kDecodes) {
            float most = 0;
            for (const float a : row) most = std::max(most, std::abs(a));
            if (most > 0) exponent = std::clamp(std::ilogb(most) + 1, -kMaxExponent, kMaxExponent);
        }
        std::int32_t step = exponent - before;
        exponents.code(coder, step, {});
        exponent = before + step;
        if (std::abs(exponent) > kMaxExponent) return coder.fail();
        before = exponent;
        std::int32_t last = 0;
        for (int k = 0; k < MarkerDomain::kAxes; ++k) {
            std::int32_t value = 0;
            if (!Coder::kDecodes)
                value = std::int32_t(std::clamp(std::lround(std::ldexp(double(row[std::size_t(k)]), kMantissa - exponent)), -long(1 << kMantissa), long(1 << kMantissa)));
            mantissas.code(coder, value, {{k, magnitude_level(std::uint32_t(std::abs(last)), kLevels)}, 0, 0});
            if (std::abs(value) > 1 << kMantissa) return coder.fail();
            last = value;
            row[std::size_t(k)] = std::ldexp(float(value), exponent - kMantissa);
        }
    }
}

template <class Coder>
void code_extents(Coder& coder, std::vector<float>& extents) {
    IntegerModel model(std::array<int, 1>{1}, 1, 1, kLimit);
    constexpr auto kMost = std::int32_t(kMaxExtent / kExtentStep);
    std::int32_t before = 0;
    for (float& extent : extents) {
        std::int32_t value = 0;
        if (!Coder::kDecodes) value = std::int32_t(std::clamp(std::ceil(extent / kExtentStep), 1.0f, float(kMost)));
        std::int32_t difference = value - before;
        model.code(coder, difference, {});
        if (std::abs(difference) > kMost) return coder.fail();
        value = before + difference;
        if (value < 1 || value > kMost) return coder.fail();
        extent = float(value) * kExtentStep;
        before = value;
    }
}

template <class Coder>
void code_factors(Coder& coder, int terms, std::vector<float>& factors) {
    const int size = terms * (terms + 1) / 2;
    if (size == 0) return;
    IntegerModel model(std::array<int, 2>{size, kLevels}, 1, 1, kLimit);
    std::vector<std::int64_t> sums(std::size_t(size), 0);
    for (std::size_t m = 0; m < factors.size() / std::size_t(size); ++m) {
        std::int32_t last = 0;
        for (int row = 0, k = 0; row < terms; ++row)
            for (int column = 0; column <= row; ++column, ++k) {
                float& factor = factors[m * std::size_t(size) + std::size_t(k)];
                // The mean of the markers before.
                const auto expected = std::int32_t(m == 0 ? 0 : sums[std::size_t(k)] / std::int64_t(m));
                std::int32_t value = 0;
                if (!Coder::kDecodes) {
                    value = std::int32_t(std::clamp(std::round(factor / kFactorStep), -float(kMaxFactor), float(kMaxFactor)));
                    if (row == column) value = std::max(value, 1);
                }
                std::int32_t difference = value - expected;
                model.code(coder, difference, {{k, magnitude_level(std::uint32_t(std::abs(last)), kLevels)}, 0, 0});
                value = expected + difference;
                if (std::abs(value) > kMaxFactor || (row == column && value < 1)) return coder.fail();
                last = difference;
                sums[std::size_t(k)] += value;
                factor = float(value) * kFactorStep;
            }
    }
}

void write_sites(ByteWriter& out, const std::vector<Site>& sites) {
    assert(sites.size() <= kMaxDetailMarkers);
    out.varint(sites.size());
    for (const Site& site : sites) {
        const std::uint32_t* v = site.vertices;
        out.varint(v[0]);
        out.svarint(std::int64_t(v[1]) - v[0]);
        out.svarint(std::int64_t(v[2]) - v[0]);
        if (v[1] != v[0] || v[2] != v[0])
            for (int i = 1; i < 3; ++i) out.svarint(std::clamp<std::int64_t>(std::lround(site.weights[i] * kWeights), -kMaxWeight, kMaxWeight));
    }
}

/// Three sites or more, of a mesh of V vertices.
Result<std::vector<Site>> read_sites(ByteReader& in, std::uint32_t V, const char* what) {
    std::vector<Site> sites;
    const std::uint64_t M = in.varint();
    if (in.ok() && M > kMaxDetailMarkers) return Error{ErrorCode::limit_exceeded, std::string("the ") + what + " blob announces too many markers"};
    for (std::uint64_t m = 0; m < M && in.ok(); ++m) {
        std::int64_t v[3] = {std::int64_t(std::min<std::uint64_t>(in.varint(), V)), 0, 0};
        for (int i = 1; i < 3; ++i) v[i] = v[0] + std::clamp<std::int64_t>(in.svarint(), -std::int64_t(V), V);
        Site site;
        for (int i = 0; i < 3; ++i) {
            if (v[i] < 0 || v[i] >= V) return damaged(what);
            site.vertices[i] = std::uint32_t(v[i]);
        }
        if (v[1] != v[0] || v[2] != v[0])
            for (int i = 1; i < 3; ++i) {
                const std::int64_t weight = in.svarint();
                if (weight < -kMaxWeight || weight > kMaxWeight) return damaged(what);
                site.weights[i] = float(weight) / kWeights;
            }
        site.weights[0] = 1 - site.weights[1] - site.weights[2];
        sites.push_back(site);
    }
    if (!in.ok() || M < 3) return damaged(what);
    return sites;
}

void write_stage(ByteWriter& out, const MapStage& stage) {
    for (const std::int8_t lift : stage.lift) out.u8(std::uint8_t(lift));
    out.bytes(stage.coded);
}
MapStage read_stage(ByteReader& in) {
    MapStage stage;
    for (std::int8_t& lift : stage.lift) lift = std::int8_t(in.u8());
    const ByteView coded = in.bytes(in.remaining());
    stage.coded.assign(coded.begin(), coded.end());
    return stage;
}

}  // namespace

Bytes encode_shell(const Shell& shell) {
    ByteWriter out;
    write_sites(out, shell.sites);
    std::vector<std::array<std::uint32_t, 2>> runs;
    for (const std::uint32_t v : shell.fixed) {
        assert(runs.empty() || v >= runs.back()[0] + runs.back()[1]);
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
    return out.take();
}

Result<Shell> decode_shell(ByteView bytes, std::uint32_t V) {
    ByteReader in(bytes);
    Shell shell;
    MIEN_TRY(sites, read_sites(in, V, "shell"));
    shell.sites = std::move(sites);
    const std::uint64_t runs = in.varint();
    if (!in.ok() || runs > V) return damaged("shell");
    std::uint64_t end = 0;
    for (std::uint64_t r = 0; r < runs; ++r) {
        const std::uint64_t first = in.varint(), length = in.varint();
        if (!in.ok() || first >= V || length >= V || end + first + length >= V) return damaged("shell");
        for (std::uint64_t v = end + first; v <= end + first + length; ++v) shell.fixed.push_back(std::uint32_t(v));
        end += first + length + 1;
    }
    if (!in.ok() || !in.at_end()) return damaged("shell");
    return shell;
}

Bytes encode_driving_markers(const DrivingMarkers& markers) {
    assert(markers.rest_offsets.rows() == Eigen::Index(markers.sites.size()));
    ByteWriter out;
    write_sites(out, markers.sites);
    for (const float offset : markers.rest_offsets.reshaped<Eigen::RowMajor>())
        out.svarint(std::lround(std::clamp(offset, -kMaxRestOffset, kMaxRestOffset) / kRestStep));
    return out.take();
}

Result<DrivingMarkers> decode_driving_markers(ByteView bytes, std::uint32_t V) {
    ByteReader in(bytes);
    DrivingMarkers markers;
    MIEN_TRY(sites, read_sites(in, V, "driving markers"));
    markers.sites = std::move(sites);
    markers.rest_offsets.resize(Eigen::Index(markers.sites.size()), 3);
    for (Eigen::Index m = 0; m < markers.rest_offsets.rows(); ++m)
        for (int c = 0; c < 3; ++c) {
            const std::int64_t steps = in.svarint();
            constexpr auto kMost = std::int64_t(kMaxRestOffset / kRestStep);
            if (!in.ok() || steps < -kMost || steps > kMost) return damaged("driving markers");
            markers.rest_offsets(m, c) = float(steps) * kRestStep;
        }
    if (!in.ok() || !in.at_end()) return damaged("driving markers");
    return markers;
}

Bytes encode_marker_domain(const MarkerDomain& domain) {
    const auto M = std::uint32_t(domain.axes.size());
    assert(domain.reach > 0 && domain.reach <= kMaxReach && domain.terms >= 1 && domain.terms <= MarkerDomain::kMaxTerms);
    assert(domain.factors.size() == M * std::size_t(domain.terms * (domain.terms + 1) / 2));
    ByteWriter out;
    out.f32(domain.reach);
    const Bytes triangles = encode_connectivity(M, domain.triangles);
    out.varint(triangles.size());
    out.bytes(triangles);
    assert(domain.extents.empty() || domain.extents.size() == M);
    out.u8(std::uint8_t(domain.terms | (domain.extents.empty() ? 0 : kHasExtents)));
    RangeEncoder coder;
    auto axes = domain.axes;
    auto extents = domain.extents;
    auto factors = domain.factors;
    code_axes(coder, axes);
    code_extents(coder, extents);
    code_factors(coder, domain.terms, factors);
    out.bytes(coder.finish());
    return out.take();
}

Result<MarkerDomain> decode_marker_domain(ByteView bytes, std::uint32_t M) {
    ByteReader in(bytes);
    MarkerDomain domain;
    domain.reach = in.f32();
    const ByteView triangles = in.bytes(in.varint());
    const int terms = in.u8();
    domain.terms = terms & ~kHasExtents;
    if (!in.ok() || !(domain.reach > 0 && domain.reach <= kMaxReach) || domain.terms < 1 || domain.terms > MarkerDomain::kMaxTerms) return damaged("marker domain");
    MIEN_TRY(mesh, decode_connectivity(triangles));
    if (mesh.V != M) return damaged("marker domain");
    domain.triangles = std::move(mesh.triangles);
    for (const Triangle& t : domain.triangles)
        if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return damaged("marker domain");
    domain.axes.resize(M);
    if (terms & kHasExtents) domain.extents.resize(M);
    domain.factors.resize(M * std::size_t(domain.terms * (domain.terms + 1) / 2));
    RangeDecoder coder(in.bytes(in.remaining()));
    code_axes(coder, domain.axes);
    if (!coder.failed()) code_extents(coder, domain.extents);
    if (!coder.failed()) code_factors(coder, domain.terms, domain.factors);
    if (!coder.complete()) return damaged("marker domain");
    return domain;
}

Bytes encode_map(const MapHead& head, const MapStage& first) {
    ByteWriter out;
    out.u8(std::uint8_t(head.channels));
    out.u8(std::uint8_t(head.order));
    out.f32(head.step);
    out.u8(std::uint8_t(head.stages));
    if (head.channels == 3)
        for (const std::int16_t r : head.rotation) out.u16(std::uint16_t(r));
    write_stage(out, first);
    return out.take();
}

Result<CodedMap> decode_map(ByteView bytes) {
    ByteReader in(bytes);
    CodedMap map;
    map.head.channels = in.u8();
    map.head.order = in.u8();
    map.head.step = in.f32();
    map.head.stages = in.u8();
    if (!in.ok() || (map.head.channels != 1 && map.head.channels != 3) || map.head.order > 3 || !(map.head.step > 1e-9f && map.head.step < 1e6f) ||
        map.head.stages < 1 || map.head.stages > kMaxStages)
        return damaged("detail map");
    if (map.head.channels == 3)
        for (std::int16_t& r : map.head.rotation) r = std::int16_t(in.u16());
    map.first = read_stage(in);
    if (!in.ok()) return damaged("detail map");
    return map;
}

Bytes encode_refinement(int stage, const MapStage& refinement) {
    ByteWriter out;
    out.u8(std::uint8_t(stage));
    write_stage(out, refinement);
    return out.take();
}

Result<MapStage> decode_refinement(ByteView bytes, int stage) {
    ByteReader in(bytes);
    const int number = in.u8();
    MapStage refinement = read_stage(in);
    if (!in.ok() || number != stage) return damaged("detail refinement");
    return refinement;
}

}  // namespace mien::coding
