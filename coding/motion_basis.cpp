#include "coding/motion_basis.hpp"

#include <bit>
#include <cassert>
#include <cmath>

#include "coding/motion_channels.hpp"
#include "coding/static_code.hpp"
#include "coding/vector_coder.hpp"
#include "core/byte_io.hpp"

namespace mien::coding {
namespace {

constexpr std::uint8_t kAcrossMesh = 1, kHasParents = 2, kHasWeights = 4, kMirrored = 8, kCorrects = 16, kRefines = 32;

Error damaged(const char* what) { return {ErrorCode::damaged, std::string("motion basis: ") + what}; }

// Below a bound that keeps every decoded value finite in float.
bool sane(float v) { return std::isfinite(v) && v > 0 && v < 1e9f; }

template <class Coder>
void code_start(Coder& coder, MotionStart& start, const MotionChannels& layout) {
    constexpr std::size_t kMost = Binarisation::kBins + Binarisation::kShiftedBins;
    const std::size_t bins = layout.bins(), entries = layout.model_entries(), weights = layout.model_weights();
    std::array<AdaptiveBit, 4> any;
    std::array<AdaptiveBit, 2 * kMost> present;
    const std::array<int, 1> counts{int(bins)};
    IntegerModel levels(counts, 1, int(bins), 60);
    std::array<std::int32_t, kMost> usual{};
    std::vector<MotionStart::Chance> out;
    std::size_t next = 0;
    int before = 0;
    for (std::size_t context = 0; context < entries / bins && !coder.failed(); ++context) {
        const std::size_t begin = context * bins;
        const bool has = next < start.chances.size() && start.chances[next].at < begin + bins;
        int bit = has;
        any[std::size_t(before)].code(coder, bit);
        before = (before << 1 | bit) & 3;
        if (!bit) continue;
        int last = 1;
        for (std::size_t bin = 0; bin < bins; ++bin) {
            int here = next < start.chances.size() && start.chances[next].at == begin + bin;
            present[bin * 2 + std::size_t(last)].code(coder, here);
            last = here;
            if (!here) continue;
            // Levels of one bin are alike from context to context.
            std::int32_t difference = Coder::kDecodes ? 0 : start.chances[next].level - usual[bin];
            IntegerModel::Contexts contexts;
            contexts.input[0] = int(bin);
            contexts.sign = int(bin);
            levels.code(coder, difference, contexts);
            const std::int64_t level = std::int64_t(usual[bin]) + difference;
            if (level < -30 || level > 30) {
                coder.fail();
                return;
            }
            out.push_back({std::uint32_t(begin + bin), std::int8_t(level)});
            usual[bin] = std::int32_t(level);
            ++next;
        }
    }
    if (Coder::kDecodes) start.chances = std::move(out);
    if (start.weights.empty()) return;
    start.weights.resize(weights);
    IntegerModel weight_model(counts, 1, 1, 60);
    for (std::size_t i = 0; i < weights && !coder.failed(); ++i) {
        std::int32_t v = start.weights[i];
        weight_model.code(coder, v, {});
        if (v < -127 || v > 127) return coder.fail();
        start.weights[i] = std::int8_t(v);
    }
}

// Which points are corrected: the gaps between them.
template <class Coder>
bool code_corrected(Coder& coder, std::vector<std::uint32_t>& points, std::uint32_t limit) {
    const std::array<int, 1> counts{8};
    IntegerModel gaps(counts, 1, 1, 60);
    std::int64_t last = -1;
    IntegerModel::Contexts contexts;
    for (std::uint32_t& point : points) {
        std::int32_t gap = Coder::kDecodes ? 0 : std::int32_t(std::int64_t(point) - last - 1);
        gaps.code(coder, gap, contexts);
        if (gap < 0 || last + 1 + gap >= std::int64_t(limit) || coder.failed()) return false;
        contexts.input[0] = magnitude_level(std::uint32_t(gap), 8);
        last += 1 + gap;
        point = std::uint32_t(last);
    }
    return true;
}

}  // namespace

PointOrder basis_order(const MotionBasis& basis, const MotionShape& shape, std::span<const Triangle> triangles, std::span<const std::uint32_t> mirror) {
    if (basis.across_mesh) return mesh_order(shape.points, triangles, basis.mirrored ? mirror : std::span<const std::uint32_t>());
    if (!basis.parents.empty()) return parent_order(basis.parents);
    return plain_order(shape.points);
}

MotionBasis refining(const MotionBasis& below) {
    MotionBasis basis;
    basis.scheme = below.scheme;
    basis.components = below.components;
    basis.refines = true;
    basis.shared = below.size();
    basis.block = below.block;
    basis.across_mesh = below.across_mesh;
    basis.mirrored = below.mirrored;
    basis.parents = below.parents;
    basis.level_steps = below.level_steps;
    return basis;
}

BasisBytes write_motion_basis(const MotionBasis& basis, const MotionShape& shape, const PointOrder& order) {
    ByteWriter out;
    out.u8(std::uint8_t(basis.scheme));
    const MotionChannels layout(shape, basis);
    MotionStart start = basis.start;

    Bytes probabilities;
    if (basis.scheme == MotionScheme::guenter98) {
        RangeEncoder coder;
        for (auto row : basis.static_codes) code_static_row(coder, row);
        probabilities = coder.finish();
    } else if (!start.chances.empty() || !start.weights.empty()) {
        RangeEncoder coder;
        code_start(coder, start, layout);
        probabilities = coder.finish();
    }
    out.varint(probabilities.size());
    out.bytes(probabilities);
    out.varint(basis.size() - basis.shared);
    out.f32(basis.step);
    out.f32(basis.mean_step);
    std::uint8_t flags = 0;
    // A refinement has what it shares with the rung below from there.
    const bool across_mesh = basis.across_mesh && !basis.refines, parents = !basis.parents.empty() && !basis.refines;
    if (basis.refines) flags |= kRefines;
    if (across_mesh) flags |= kAcrossMesh;
    if (parents) flags |= kHasParents;
    if (!start.weights.empty()) flags |= kHasWeights;
    if (basis.mirrored && !basis.refines) flags |= kMirrored;
    if (!basis.corrected.empty()) flags |= kCorrects;
    out.u8(flags);
    if (shape.pose) {
        out.f32(basis.translation_step);
        out.f32(basis.rotation_step);
        for (float c : basis.centre) out.f32(c);
    }
    if (shape.gaze) out.f32(basis.gaze_step);
    for (int i = 0; i < shape.side_channels(); ++i) out.svarint(basis.side_mean[std::size_t(i)]);
    if (basis.scheme == MotionScheme::transform && !basis.refines) out.u8(basis.block);
    if (basis.scheme != MotionScheme::guenter98) out.u8(start.confidence);
    if (basis.scheme == MotionScheme::causal)
        for (const auto& row : basis.predictors)
            for (std::int16_t a : row) out.svarint(a);
    if (across_mesh)
        for (std::uint8_t s : basis.level_steps) out.u8(s);
    if (!basis.corrected.empty()) {
        out.f32(basis.correction_step);
        out.varint(basis.corrected.size());
    }

    RangeEncoder coder;
    if (parents)
        for (std::uint32_t i = 1; i < shape.points; ++i) {
            std::uint32_t parent = basis.parents[i];
            code_plain(coder, parent, int(std::bit_width(i)));
        }
    std::vector<std::uint32_t> corrected = basis.corrected;
    [[maybe_unused]] const bool ascending = code_corrected(coder, corrected, shape.points);
    assert(ascending);
    if (basis.scheme == MotionScheme::guenter98) {
        write_static_vectors(coder, basis, shape);
    } else {
        VectorCoder vectors(shape, order, basis.level_steps);
        std::vector<std::int32_t> walk(std::size_t(shape.dimension()), 0);
        const auto code = [&](const std::vector<std::int32_t>& vector) {
            vectors.code(coder, walk, [&](const VectorCoder::Value& v, const auto&, auto&) {
                const std::int64_t difference = vector[v.index] - v.prediction;
                assert(difference % v.step == 0);
                return std::int32_t(difference / v.step);
            });
        };
        const std::span<const std::vector<std::int32_t>> components(basis.components);
        vectors.learn(components.first(basis.shared));
        code(basis.mean);
        for (const auto& component : components.subspan(basis.shared)) code(component);
    }
    out.bytes(coder.finish());
    return {out.take(), probabilities.size()};
}

Result<std::size_t> motion_basis_probabilities(ByteView bytes) {
    ByteReader in(bytes);
    in.u8();
    const std::uint64_t size = in.varint();
    if (!in.ok() || size > in.remaining()) return Error{ErrorCode::truncated, "the motion basis ends inside its head"};
    return std::size_t(size);
}

Result<MotionBasis> read_motion_basis(const MotionShape& shape, ByteView bytes, std::span<const Triangle> triangles,
                                      std::span<const std::uint32_t> mirror, const MotionBasis* below) {
    ByteReader in(bytes);
    MotionBasis basis = below ? refining(*below) : MotionBasis();
    const std::uint8_t scheme = in.u8();
    if (in.ok() && (scheme < 1 || scheme > 3)) return damaged("unknown scheme");
    if (in.ok() && below && (MotionScheme(scheme) != below->scheme || below->scheme == MotionScheme::guenter98))
        return damaged("its scheme is not that of the rung below");
    basis.scheme = MotionScheme(scheme);
    const std::uint64_t probabilities_size = in.varint();
    const ByteView probabilities = in.bytes(probabilities_size);
    const std::uint64_t own = in.varint(), k = own + basis.shared;
    basis.step = in.f32();
    basis.mean_step = in.f32();
    const std::uint8_t flags = in.u8();
    if (!in.ok()) return Error{ErrorCode::truncated, "the motion basis ends inside its head"};
    if (own > MotionBasis::kMaxComponents || k > MotionBasis::kMaxComponents || (k + 1) * shape.dimension() > MotionBasis::kMaxValues)
        return Error{ErrorCode::limit_exceeded, "motion basis: more components than its limits allow"};
    if (!sane(basis.step) || !sane(basis.mean_step)) return damaged("a step is not a positive number");
    if (flags > (kAcrossMesh | kHasParents | kHasWeights | kMirrored | kCorrects | kRefines) || (flags & 3) == 3 || (flags & (kAcrossMesh | kMirrored)) == kMirrored) return damaged("unknown flags");
    if (bool(flags & kRefines) != basis.refines || (basis.refines && (flags & (kAcrossMesh | kHasParents | kMirrored))))
        return damaged("its place among the rungs is another");
    if (shape.pose) {
        basis.translation_step = in.f32();
        basis.rotation_step = in.f32();
        for (float& c : basis.centre) {
            c = in.f32();
            if (!std::isfinite(c) || std::abs(c) > 1e9f) return damaged("the head's centre is not a number");
        }
        if (!sane(basis.translation_step) || !sane(basis.rotation_step)) return damaged("a step is not a positive number");
    }
    if (shape.gaze) {
        basis.gaze_step = in.f32();
        if (!sane(basis.gaze_step)) return damaged("a step is not a positive number");
    }
    for (int i = 0; i < shape.side_channels(); ++i) {
        const std::int64_t v = in.svarint();
        if (v < -(1 << 28) || v > (1 << 28)) return damaged("a mean pose out of range");
        basis.side_mean[std::size_t(i)] = std::int32_t(v);
    }
    if (basis.scheme == MotionScheme::transform && !basis.refines) {
        basis.block = in.u8();
        if (in.ok() && (basis.block < 1 || basis.block > CosineTransform::kMaxLength)) return damaged("block length out of range");
    }
    if (basis.scheme != MotionScheme::guenter98) basis.start.confidence = in.u8();
    const int channels = shape.side_channels() + int(k);
    if (basis.scheme == MotionScheme::causal) {
        basis.predictors.resize(std::size_t(channels));
        for (auto& row : basis.predictors)
            for (std::int16_t& a : row) {
                const std::int64_t v = in.svarint();
                if (v < -2048 || v > 2048) return damaged("a predictor out of range");
                a = std::int16_t(v);
            }
    }
    if (!basis.refines) basis.across_mesh = flags & kAcrossMesh;
    if (flags & kAcrossMesh) {
        for (std::uint8_t& s : basis.level_steps) {
            s = in.u8();
            if (in.ok() && s == 0) return damaged("a residual step of zero");
        }
        if (triangles.empty())
            return Error{ErrorCode::missing, "this motion basis is predicted across the neutral mesh, whose triangles are not given"};
        basis.mirrored = flags & kMirrored;
        if (basis.mirrored && mirror.size() != shape.points)
            return Error{ErrorCode::missing, "this motion basis is predicted from side to side, but the neutral mesh has no mirror"};
    }
    if (flags & kCorrects) {
        basis.correction_step = in.f32();
        const std::uint64_t count = in.varint();
        if (in.ok() && (!sane(basis.correction_step) || count == 0 || count > shape.points)) return damaged("corrections out of range");
        if (in.ok()) basis.corrected.resize(std::size_t(count));
    }
    if (!in.ok()) return Error{ErrorCode::truncated, "the motion basis ends inside its head"};

    const MotionChannels layout(shape, basis);
    if (basis.scheme == MotionScheme::guenter98) {
        RangeDecoder coder(probabilities);
        basis.static_codes.resize(std::size_t(channels) + std::size_t(k) + 1);
        for (auto& row : basis.static_codes) {
            code_static_row(coder, row);
            if (coder.failed()) break;
        }
        if (!coder.complete()) return damaged("the static codes do not end where they should");
    } else if (!probabilities.empty() || (flags & kHasWeights)) {
        RangeDecoder coder(probabilities);
        if (flags & kHasWeights) basis.start.weights.assign(1, 0);
        code_start(coder, basis.start, layout);
        if (!coder.complete()) return damaged("the starting probabilities do not end where they should");
    }

    RangeDecoder coder(in.bytes(in.remaining()));
    if (flags & kHasParents) {
        basis.parents.assign(shape.points, 0);
        for (std::uint32_t i = 1; i < shape.points; ++i) {
            std::uint32_t parent = 0;
            code_plain(coder, parent, int(std::bit_width(i)));
            if (parent > i || coder.failed()) return damaged("a point is predicted from a later one");
            basis.parents[i] = parent;
        }
    }
    if (!code_corrected(coder, basis.corrected, shape.points)) return damaged("a corrected point that is none");
    const std::size_t d = std::size_t(shape.dimension());
    if (basis.scheme == MotionScheme::guenter98) {
        read_static_vectors(coder, basis, shape, std::uint32_t(k));
    } else {
        const PointOrder order = basis_order(basis, shape, triangles, mirror);
        VectorCoder vectors(shape, order, basis.level_steps);
        std::vector<std::int32_t> walk(d, 0);
        vectors.learn(basis.components);
        const auto ignore = [](const VectorCoder::Value&, const auto&, auto&) { return 0; };
        vectors.code(coder, walk, ignore);
        basis.mean = walk;
        for (std::uint64_t j = 0; j < own && !coder.failed(); ++j) {
            vectors.code(coder, walk, ignore);
            basis.components.push_back(walk);
        }
    }
    if (!coder.complete()) return damaged("its vectors do not end where they should");
    return basis;
}

}  // namespace mien::coding
