#include "bench/suite.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "bench/geometry_run.hpp"
#include "bench/short_clip.hpp"
#include "bench/texture_suite.hpp"
#include "bench/timing.hpp"

namespace mien::bench {

Result<std::optional<protocol::MotionKind>> motion_kind(const Clip& clip, const std::string& asked) {
    using protocol::MotionKind;
    using Kind = std::optional<MotionKind>;
    const std::pair<const char*, bool> there[] = {
        {"vertices", clip.vertices.has_value()}, {"markers", clip.markers.has_value()}, {"weights", clip.weights.has_value()}};
    const MotionKind kinds[] = {MotionKind::vertices, MotionKind::markers, MotionKind::weights};
    for (int i = 0; i < 3; ++i) {
        if (asked == there[i].first && !there[i].second)
            return Error{ErrorCode::missing, "clip '" + clip.name + "' has no " + asked};
        if (there[i].second && (asked == "auto" || asked == there[i].first)) return Kind(kinds[i]);
    }
    if (asked != "auto") return Error{ErrorCode::invalid, "motion is vertices, markers, weights or auto, not '" + asked + "'"};
    return Kind();
}

namespace {

constexpr double kWeightScale = 0.05;  // weight units that stand for a millimetre: 0.005 beside 0.1 mm

ClipFacts facts_of(const Clip& clip, const std::optional<protocol::MotionKind>& kind) {
    ClipFacts facts;
    facts.name = clip.name;
    facts.key = clip_key(clip);
    facts.frame_rate = to_string(clip.frame_rate);
    facts.frames_per_second = clip.frame_rate.value();
    facts.frames = clip.frame_count();
    if (kind) {
        const GeometryInput input(clip, *kind);
        facts.kind = *kind == protocol::MotionKind::vertices  ? "vertices"
                     : *kind == protocol::MotionKind::markers ? "markers"
                                                              : "weights";
        facts.points = input.points;
        facts.triangles = std::int64_t(input.triangles.size());
        if (facts.triangles) {
            facts.draco_sorted_bytes = draco_connectivity_bytes(*clip.neutral, false);
            facts.draco_ordered_bytes = draco_connectivity_bytes(*clip.neutral, true);
        }
    }
    if (clip.texture) facts.texture_width = clip.texture->width(), facts.texture_height = clip.texture->height();
    return facts;
}

class GeometrySuite {
public:
    GeometrySuite(const Clip& clip, protocol::MotionKind kind, const SuiteOptions& options, Report& report,
                  const std::function<void()>& save, const Progress& progress)
        : input_(clip, kind),
          key_(clip_key(clip)),
          options_(options),
          report_(report),
          save_(save),
          progress_(progress),
          list_(geometry_codecs()) {
        rms_ = options.rms;
        if (rms_.empty())
            for (const double mm : {0.4, 0.2, 0.1, 0.05, 0.025})
                rms_.push_back(kind == protocol::MotionKind::weights ? mm * kWeightScale : mm);
        for (const auto& codec : list_.codecs)
            if (chosen(options.codecs, codec->name) && codec->refuses(input_).empty()) codecs_.push_back(codec.get());
    }

    void run_rows() {
        const auto total = std::int64_t(codecs_.size() * rms_.size());
        std::int64_t done = 0;
        for (const GeometryCodec* codec : codecs_)
            for (const double rms : rms_) {
                if (progress_) progress_(codec->name, done, total);
                ++done;
                if (codec->lossless && rms != rms_.front()) continue;
                if (has_row(*codec, codec->lossless ? 0 : rms)) continue;
                GeometryRow row = run_geometry(input_, *codec, rms).row;
                row.clip = key_;
                for (const auto& [what, bytes] : row.apart)
                    if (what == "connectivity")
                        for (ClipFacts& facts : report_.clips)
                            if (facts.key == key_) facts.connectivity_bytes = bytes;
                std::erase_if(report_.geometry, [&](const GeometryRow& old) { return same(old, *codec, row.asked_rms); });
                report_.geometry.push_back(std::move(row));
                save_();
            }
        if (progress_) progress_("motion", total, total);
    }

    Result<void> run_timing() {
        const double rms = rms_[rms_.size() / 2];
        std::vector<std::unique_ptr<GeometryStream>> streams;
        std::vector<Timed> timed;
        std::vector<const GeometryCodec*> encoders;
        // The subjects of the two sets come first.
        std::vector<const GeometryCodec*> order = codecs_;
        std::stable_partition(order.begin(), order.end(), [](const GeometryCodec* codec) { return codec->name == "mien-live"; });
        const std::string run = run_name(order, rms);
        const auto of_run = [&](const TimingRow& row) { return row.clip == key_ && row.run == run; };
        if (!options_.force && std::any_of(report_.timing.begin(), report_.timing.end(), of_run)) return {};
        for (const GeometryCodec* codec : order) {
            if (progress_) progress_("encoding for timing", std::int64_t(timed.size()), std::int64_t(order.size()));
            auto stream = codec->encode(input_, rms);
            if (!stream.ok()) continue;  // its row says why
            streams.push_back(std::move(*stream));
            timed.push_back({codec, streams.back().get()});
            if (!codec->lossless) encoders.push_back(codec);
        }
        if (timed.empty()) return {};
        const auto second = std::max<std::int64_t>(1, std::llround(input_.clip.frame_rate.value()));
        MIEN_TRY(rows, time_decoding(input_, timed, rms, second, options_.timing_rounds, progress_));
        if (!encoders.empty()) {
            const Clip beginning =
                first_frames(input_.clip, std::llround(options_.encode_seconds * input_.clip.frame_rate.value()));
            const GeometryInput short_input(beginning, input_.kind);
            MIEN_TRY(more, time_encoding(short_input, encoders, rms, std::min(3, options_.timing_rounds), progress_));
            rows.insert(rows.end(), more.begin(), more.end());
        }
        std::erase_if(report_.timing, of_run);
        for (TimingRow& row : rows) {
            row.clip = key_;
            row.run = run;
            report_.timing.push_back(std::move(row));
        }
        save_();
        return {};
    }

    void note_codecs() {
        for (const auto& codec : list_.codecs)
            if (chosen(options_.codecs, codec->name)) report_.codecs[codec->name] = codec->what;
        std::erase_if(report_.absent, [&](const auto& pair) { return report_.codecs.count(pair.first) > 0; });
        for (const auto& pair : list_.absent)
            if (chosen(options_.codecs, pair.first) && !report_.codecs.count(pair.first) &&
                std::find(report_.absent.begin(), report_.absent.end(), pair) == report_.absent.end())
                report_.absent.push_back(pair);
    }

private:
    bool same(const GeometryRow& row, const GeometryCodec& codec, double rms) const {
        return row.clip == key_ && row.codec == codec.name && row.library == codec.library &&
               std::abs(row.asked_rms - rms) < 1e-9;
    }
    bool has_row(const GeometryCodec& codec, double rms) const {
        return !options_.force && std::any_of(report_.geometry.begin(), report_.geometry.end(), [&](const GeometryRow& row) {
            return row.failed.empty() && same(row, codec, rms);
        });
    }
    /// A run is what ran in it: codecs, versions and error.
    std::string run_name(const std::vector<const GeometryCodec*>& codecs, double rms) const {
        std::string name = fmt::format("RMS {}", rms);
        for (const GeometryCodec* codec : codecs) name += ", " + codec->name + " " + codec->library;
        return name;
    }

    const GeometryInput input_;
    std::string key_;
    const SuiteOptions& options_;
    Report& report_;
    const std::function<void()>& save_;
    const Progress& progress_;
    GeometryCodecs list_;
    std::vector<const GeometryCodec*> codecs_;
    std::vector<double> rms_;
};

}  // namespace

bool chosen(const std::vector<std::string>& beginnings, const std::string& name) {
    return beginnings.empty() ||
           std::any_of(beginnings.begin(), beginnings.end(), [&](const std::string& b) { return name.starts_with(b); });
}

void drop_other_builds(Report& report) {
    const auto other = [](const std::string& library) { return library.starts_with("mien ") && library != own_library(); };
    std::erase_if(report.geometry, [&](const GeometryRow& row) { return other(row.library); });
    std::vector<std::string> stale;
    for (const TimingRow& row : report.timing)
        if (other(row.library)) stale.push_back(row.run);
    std::erase_if(report.timing,
                  [&](const TimingRow& row) { return std::find(stale.begin(), stale.end(), row.run) != stale.end(); });
    std::erase_if(report.texture, [&](const TextureRow& row) { return other(row.library); });
    std::erase_if(report.views, [&](const ViewRow& row) { return other(row.library); });
}

Result<void> run_clip(const Clip& clip, const SuiteOptions& options, Report& report, const std::function<void()>& save,
                      const Progress& progress) {
    MIEN_TRY(kind, motion_kind(clip, options.motion));
    ClipFacts facts = facts_of(clip, kind);
    const std::string key = facts.key;
    const auto old =
        std::find_if(report.clips.begin(), report.clips.end(), [&](const ClipFacts& there) { return there.key == key; });
    if (old == report.clips.end()) {
        report.clips.push_back(std::move(facts));
    } else {
        // What another run knew stays: this build may have no Draco, or this command no motion.
        if (!facts.connectivity_bytes) facts.connectivity_bytes = old->connectivity_bytes;
        if (!facts.draco_sorted_bytes)
            facts.draco_sorted_bytes = old->draco_sorted_bytes, facts.draco_ordered_bytes = old->draco_ordered_bytes;
        *old = std::move(facts);
    }
    if (kind && options.geometry) {
        GeometrySuite suite(clip, *kind, options, report, save, progress);
        suite.note_codecs();
        suite.run_rows();
        if (options.timing) MIEN_CHECK(suite.run_timing());
    }
    if (options.texture && clip.texture && clip.texture->frames() > 1)
        MIEN_CHECK(run_textures(clip, key, options, report, save, progress));
    return {};
}

}  // namespace mien::bench
