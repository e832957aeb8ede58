#include "io/clip_validation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "io/point_faults.hpp"

namespace mien::io {
namespace {

// Heads measure 180 to 300 mm, faces of markers 100 to 200, with neck and shoulders up to 700.
constexpr double kSmallest = 50, kLargest = 1000;
// Faces stretch by tenths, units differ by ten at least; markers may be on a part of the face, or of a whole figure's.
constexpr double kLeastOfNeutral = 1.0 / 3, kLeastOfNeutralByMarkers = 1.0 / 50, kMostOfNeutral = 3;
// A kilometre, mm: beyond it, single-precision coordinates are coarser than a twentieth of a millimetre.
constexpr float kFarthest = 1e6f;

/// Finite, and no farther than anything that is captured.
bool all_near(const float* values, std::int64_t count) {
    const Eigen::Map<const Eigen::ArrayXf> all(values, count);
    // NaN is not below anything either.
    return (all.abs() <= kFarthest).all();
}

/// What can be wrong with positions, each fault with its points.
class PositionFaults {
public:
    PositionFaults(const char* one, const char* many) : not_numbers_(one, many), infinite_(one, many), far_(one, many) {}

    void add(std::int64_t frame, std::int64_t point, const float* p) {
        if (std::isnan(p[0]) || std::isnan(p[1]) || std::isnan(p[2])) not_numbers_.add(frame, point);
        else if (std::isinf(p[0]) || std::isinf(p[1]) || std::isinf(p[2])) infinite_.add(frame, point);
        else if (!all_near(p, 3)) far_.add(frame, point);
    }
    void report(Findings& findings, const std::string& source) const {
        not_numbers_.report(findings, Severity::problem, ErrorCode::invalid, source, "not a number");
        infinite_.report(findings, Severity::problem, ErrorCode::invalid, source, "infinite");
        far_.report(findings, Severity::problem, ErrorCode::invalid, source, "more than a kilometre away");
    }

private:
    PointFaults not_numbers_, infinite_, far_;
};

void check_vertices(const PointSequence& vertices, const ClipSources& sources, Findings& findings) {
    const bool file_per_frame = !sources.vertex_frames.empty();
    PositionFaults faults("vertex", "vertices");
    for (std::int64_t f = 0; f < vertices.frames; ++f) {
        const float* frame = vertices.xyz.data() + f * vertices.points * 3;
        if (all_near(frame, vertices.points * 3)) continue;
        PositionFaults of_frame("vertex", "vertices");
        for (std::int64_t v = 0; v < vertices.points; ++v) (file_per_frame ? of_frame : faults).add(f, v, frame + v * 3);
        if (file_per_frame) of_frame.report(findings, sources.vertex_frames[std::size_t(f)]);
    }
    faults.report(findings, sources.vertices);
}

void check_markers(const PointSequence& markers, const ClipSources& sources, Findings& findings) {
    std::vector<bool> present(std::size_t(markers.points));
    IndexRanges empty_frames, never;
    PositionFaults faults("marker", "markers");
    for (std::int64_t f = 0; f < markers.frames; ++f) {
        bool any = false;
        for (std::int64_t m = 0; m < markers.points; ++m) {
            const float* p = markers.xyz.data() + (f * markers.points + m) * 3;
            if (std::isnan(p[0]) && std::isnan(p[1]) && std::isnan(p[2])) continue;  // missing
            faults.add(f, m, p);
            any = present[std::size_t(m)] = true;
        }
        if (!any) empty_frames.add(f);
    }
    faults.report(findings, sources.markers);
    if (empty_frames.count() == markers.frames) return findings.problem(ErrorCode::invalid, fmt::format("{}: no frame has any marker", sources.markers));
    if (!empty_frames.empty())
        findings.warn_of_list([&](std::size_t most) {
            return fmt::format("{}: {} of {} frames have no marker at all: {}", sources.markers, empty_frames.count(), markers.frames, empty_frames.text(most));
        });
    for (std::size_t m = 0; m < present.size(); ++m)
        if (!present[m]) never.add(std::int64_t(m));
    if (!never.empty())
        findings.warn_of_list([&](std::size_t most) {
            return fmt::format("{}: {} never there", sources.markers, never.subject("marker", "markers", most));
        });
}

void check_weights(const WeightSequence& weights, const ClipSources& sources, Findings& findings) {
    PointFaults not_numbers("weight", "weights", &weights.names), infinite("weight", "weights", &weights.names), far("weight", "weights", &weights.names);
    for (std::int64_t f = 0; f < weights.frames; ++f)
        for (std::int64_t i = 0; i < weights.count; ++i) {
            const float value = weights.frame(f)[i];
            if (std::isnan(value)) not_numbers.add(f, i);
            else if (std::isinf(value)) infinite.add(f, i);
            else if (std::abs(value) > 2) far.add(f, i);
        }
    not_numbers.report(findings, Severity::problem, ErrorCode::invalid, sources.weights, "not a number");
    infinite.report(findings, Severity::problem, ErrorCode::invalid, sources.weights, "infinite");
    if (!far.empty())
        findings.warn_of_list([&](std::size_t most) {
            return fmt::format("{}: {} values are beyond -2 .. 2, and weights are fractions, not percent: {}", sources.weights, far.count(), far.text(most));
        });
}

/// "PART: vertices 3-5 are not finite".
void check_finite(PointsRef points, const std::string& part, Findings& findings) {
    if (points.allFinite()) return;
    IndexRanges wrong;
    for (Eigen::Index v = 0; v < points.rows(); ++v)
        if (!points.row(v).allFinite()) wrong.add(v);
    findings.problem_of_list(ErrorCode::invalid, [&](std::size_t most) {
        return fmt::format("{}: {} not finite", part, wrong.subject("vertex", "vertices", most));
    });
}

void check_mesh(const Mesh& mesh, const ClipSources& sources, Findings& findings) {
    check_finite(mesh.positions, sources.neutral, findings);
    IndexRanges folded, outside;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        if (const Triangle& t = mesh.triangles[i]; t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) folded.add(std::int64_t(i));
    if (!folded.empty())
        findings.warn_of_list([&](std::size_t most) {
            return fmt::format("{}: {} triangles name a vertex twice: {}", sources.neutral, folded.count(), folded.text(most));
        });
    for (std::size_t i = 0; i < mesh.texcoords.size(); ++i)
        if (const Vec2& uv = mesh.texcoords[i]; !(uv.x() >= -1e-4f && uv.x() <= 1.0001f && uv.y() >= -1e-4f && uv.y() <= 1.0001f)) outside.add(std::int64_t(i));
    if (!outside.empty())
        findings.warn_of_list([&](std::size_t most) {
            return fmt::format("{}: {} of {} texture coordinates are outside 0 .. 1 and show no texel: {}", sources.neutral, outside.count(), mesh.texcoords.size(),
                               outside.text(most));
        });
}

void check_counts(const Clip& clip, const ClipSources& sources, Findings& findings) {
    const std::int64_t frames = clip.frame_count();
    const auto mismatch = [&](std::string text) { findings.problem(ErrorCode::mismatch, std::move(text)); };
    const std::string& leader = clip.vertices ? sources.vertices : clip.markers ? sources.markers : sources.weights;
    const auto same_frames = [&](const std::string& name, std::int64_t count) {
        if (count != frames) mismatch(fmt::format("{} has {} frames, but {} has {}", name, count, leader, frames));
    };
    if (clip.markers) same_frames(sources.markers, clip.markers->frames);
    if (clip.weights) same_frames(sources.weights, clip.weights->frames);
    if (!clip.head_pose.empty()) same_frames(sources.head_pose, std::int64_t(clip.head_pose.size()));
    if (!clip.gaze.empty()) same_frames(sources.gaze, std::int64_t(clip.gaze.size()));

    const std::int64_t vertices = clip.neutral ? clip.neutral->positions.rows() : clip.vertices ? clip.vertices->points : 0;
    if (clip.neutral && clip.vertices && clip.vertices->points != vertices)
        mismatch(fmt::format("{} has {} vertices a frame, but {} has {}", sources.vertices, clip.vertices->points, sources.neutral, vertices));
    if (!clip.marker_sites.empty()) {
        if (!clip.markers && !sources.unread.contains("markers")) findings.warn("marker_sites are given without markers");
        if (clip.markers && std::int64_t(clip.marker_sites.size()) != clip.markers->points)
            mismatch(fmt::format("{} has {} entries, but {} has {} markers", sources.marker_sites, clip.marker_sites.size(), sources.markers, clip.markers->points));
    }
    if (!clip.blendshapes.empty()) {
        if (clip.weights && std::int64_t(clip.blendshapes.size()) != clip.weights->count)
            mismatch(fmt::format("there are {} blendshapes, but {} has {} weights a frame", clip.blendshapes.size(), sources.weights, clip.weights->count));
        for (const Blendshape& shape : clip.blendshapes) {
            if (clip.neutral && shape.offsets.rows() != vertices)
                mismatch(fmt::format("blendshape {} has {} vertices, but {} has {}", shape.name, shape.offsets.rows(), sources.neutral, vertices));
            check_finite(shape.offsets, "blendshape " + shape.name, findings);
        }
    }
    const bool of_markers = (clip.markers || sources.unread.contains("markers")) && !clip.vertices && !sources.unread.contains("vertices");
    const bool known = of_markers ? clip.markers.has_value() : clip.neutral || clip.vertices || (!sources.unread.contains("neutral") && !sources.unread.contains("vertices"));
    const std::int64_t points = !known ? std::numeric_limits<std::int64_t>::max() : of_markers ? clip.markers->points : vertices;
    std::vector<std::uint32_t> indices;
    IndexRanges outside, entries;
    for (std::size_t i = 0; i < clip.rigid.size(); ++i) {
        if (clip.rigid[i] < points) continue;
        indices.push_back(clip.rigid[i]);
        entries.add(std::int64_t(i));
    }
    std::sort(indices.begin(), indices.end());
    for (const std::uint32_t index : indices) outside.add(index);
    if (!outside.empty())
        findings.problem_of_list(ErrorCode::mismatch, [&](std::size_t most) {
            return fmt::format("{} names {} ({}), but there are {}", sources.rigid, of_markers ? outside.text("marker", "markers", most) : outside.text("vertex", "vertices", most),
                               entries.text("entry", "entries", most), points);
        });
}

void check_media(const Clip& clip, const ClipSources& sources, Findings& findings) {
    const std::int64_t frames = clip.frame_count();
    if (clip.texture) {
        const std::int64_t there = clip.texture->frames();
        if (there != 1 && there < frames)
            findings.problem(ErrorCode::mismatch, fmt::format("{} has {} frames, but the motion has {}", sources.texture, there, frames));
        else if (there != 1 && there > frames)
            findings.warn(fmt::format("{} has {} frames, the motion only {}; the rest is left out", sources.texture, there, frames));
        if (clip.neutral ? !clip.neutral->has_texcoords() : !sources.unread.contains("neutral"))
            findings.warn(fmt::format("{} cannot be shown: the neutral mesh has no texture coordinates", sources.texture));
        if (clip.mask && (clip.mask->width != clip.texture->width() || clip.mask->height != clip.texture->height()))
            findings.problem(ErrorCode::mismatch, fmt::format("the mask is {} x {}, but {} is {} x {}", clip.mask->width, clip.mask->height, sources.texture,
                                                              clip.texture->width(), clip.texture->height()));
    }
    if (clip.scans) {
        if (clip.scans->frames() < frames) findings.problem(ErrorCode::mismatch, fmt::format("there are scans of {} frames, but the motion has {}", clip.scans->frames(), frames));
        if (clip.scans->frames() > frames) findings.warn(fmt::format("there are scans of {} frames, the motion has only {}; the rest is left out", clip.scans->frames(), frames));
    }
    if (!clip.takes.empty() && clip.takes.back().first >= frames)
        findings.problem(ErrorCode::mismatch, fmt::format("the last take begins with frame {}, but the motion has {}", clip.takes.back().first, frames));
    if (clip.sound && frames > 0) {
        if (clip.sound->samples.empty()) return findings.problem(ErrorCode::invalid, fmt::format("{} has no samples", sources.sound));
        if (sources.unread.contains("fps")) return;
        const double picture = double(frames) / clip.frame_rate.value(), off = clip.sound->seconds() - picture;
        if (std::abs(off) > std::max(0.1, 1.5 / clip.frame_rate.value()))
            findings.warn(fmt::format("{} is {:.2f} s {} than the picture ({:.2f} s)", sources.sound, std::abs(off), off > 0 ? "longer" : "shorter", picture));
    }
}

}  // namespace

std::optional<double> extent(PointsRef points) {
    Vec3 low = Vec3::Constant(INFINITY), high = Vec3::Constant(-INFINITY);
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
        const Vec3 p = points.row(i).transpose();
        if (!p.allFinite()) continue;
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
    }
    if (!(low.x() <= high.x())) return std::nullopt;
    return double((high - low).maxCoeff());
}

std::optional<double> usual_extent(const PointSequence& points) {
    if (points.points < 4) return std::nullopt;
    const std::int64_t shown = std::min<std::int64_t>(points.frames, 100);
    std::vector<double> sizes;
    for (std::int64_t i = 0; i < shown; ++i)
        if (const auto size = extent(points.frame(i * points.frames / shown))) sizes.push_back(*size);
    if (sizes.empty()) return std::nullopt;
    std::nth_element(sizes.begin(), sizes.begin() + std::ptrdiff_t(sizes.size() / 2), sizes.end());
    return sizes[sizes.size() / 2];
}

std::optional<double> head_size(const Clip& clip) {
    if (clip.neutral)
        if (const auto size = extent(clip.neutral->positions)) return size;
    for (const auto* sequence : {&clip.vertices, &clip.markers}) {
        if (!*sequence) continue;
        if (const auto size = usual_extent(**sequence)) return size;
    }
    return std::nullopt;
}

std::optional<Unit> plausible_unit(double size) {
    if (size >= 80 && size <= 1000) return Unit::mm;
    if (size >= 8 && size < 80) return Unit::cm;
    if (size >= 0.08 && size <= 1) return Unit::m;
    return std::nullopt;
}

namespace {

std::string length(double mm) { return mm >= 1e3 ? fmt::format("{:.4g} m", mm / 1000) : fmt::format("{:.3g} mm", mm); }

/// The motion against its neutral mesh, and the head against what heads measure.
void check_size(const Clip& clip, const ClipSources& sources, Findings& findings) {
    const auto neutral = clip.neutral ? extent(clip.neutral->positions) : std::nullopt;
    const auto compare = [&](const std::optional<PointSequence>& points, const std::string& source, double least) {
        const auto size = points ? usual_extent(*points) : std::nullopt;
        if (!size || !neutral || !(*neutral > 0)) return;
        if (*size >= least * *neutral && *size <= kMostOfNeutral * *neutral) return;
        findings.problem(ErrorCode::mismatch, fmt::format("{} is {} large, but {} is {}: are they in one unit?", source, length(*size), sources.neutral, length(*neutral)));
    };
    compare(clip.vertices, sources.vertices, kLeastOfNeutral);
    if (sources.unread.contains("unit")) return;
    compare(clip.markers, sources.markers, kLeastOfNeutralByMarkers);

    const auto size = head_size(clip);
    if (!size || (*size >= kSmallest && *size <= kLargest)) return;
    if (*size == 0) return findings.warn_gravely("all points lie in one place");
    const auto meant = plausible_unit(*size / millimetres(clip.unit));
    if (meant && *meant != clip.unit)
        return findings.warn_gravely(fmt::format("the head is {} large; probably the unit should be {}, not {}: {}", length(*size), name_of(*meant), name_of(clip.unit),
                                                 sources.unit_asked ? fmt::format("ask for {}, or for none", name_of(*meant))
                                                                    : fmt::format("write \"unit\": \"{}\" into clip.json", name_of(*meant))));
    findings.warn_gravely(fmt::format("the head is {} large, which fits no unit; is this a head?", length(*size)));
}

}  // namespace

void validate(const Clip& clip, const ClipSources& sources, Findings& findings) {
    if (!clip.vertices && !clip.markers && !clip.weights) {
        const auto unread = [&](const char* key) { return sources.unread.contains(key); };
        if (!unread("vertices") && !unread("markers") && !unread("weights"))
            findings.problem(ErrorCode::missing, "the clip has no motion: at least one of vertices, markers and weights is needed");
        return;
    }
    if (clip.frame_count() == 0) findings.problem(ErrorCode::invalid, "the clip is empty: it has no frames");
    check_counts(clip, sources, findings);
    if (clip.neutral) check_mesh(*clip.neutral, sources, findings);
    if (clip.vertices) check_vertices(*clip.vertices, sources, findings);
    if (clip.markers && clip.markers->frames > 0) check_markers(*clip.markers, sources, findings);
    if (clip.weights) check_weights(*clip.weights, sources, findings);
    const auto frames_are_finite = [&](const std::string& source, std::size_t frames, const auto& finite) {
        IndexRanges wrong;
        for (std::size_t f = 0; f < frames; ++f)
            if (!finite(f)) wrong.add(std::int64_t(f));
        if (!wrong.empty())
            findings.problem_of_list(ErrorCode::invalid, [&](std::size_t most) {
                return fmt::format("{}: {} not finite", source, wrong.subject("frame", "frames", most));
            });
    };
    frames_are_finite(sources.head_pose, clip.head_pose.size(), [&](std::size_t f) {
        return clip.head_pose[f].translation.allFinite() && clip.head_pose[f].rotation.coeffs().allFinite();
    });
    frames_are_finite(sources.gaze, clip.gaze.size(), [&](std::size_t f) {
        const Gaze& gaze = clip.gaze[f];
        return std::isfinite(gaze.yaw[0]) && std::isfinite(gaze.yaw[1]) && std::isfinite(gaze.pitch[0]) && std::isfinite(gaze.pitch[1]);
    });
    check_size(clip, sources, findings);
    check_media(clip, sources, findings);
}

}  // namespace mien::io
