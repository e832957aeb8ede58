#include "encoder/texture_encoder.hpp"

#include <algorithm>
#include <cmath>

#include "encoder/texture_lanes.hpp"
#include "encoder/texture_regions.hpp"
#include "encoder/texture_steps.hpp"
#include "encoder/texture_weight.hpp"
#include "protocol/limits.hpp"

namespace mien::encoder {
namespace {

// Rate control starts cold and a clip is short: where it misses by more, it is asked again for what makes up for it.
constexpr double kTolerance = 0.08;
constexpr int kRetries = 2;
constexpr double kLeastKbps = 1;   // that encoders take; x264 refuses less than that and names no reason
// That the steps of shrinking are chosen by: several groups, as what a single one costs says little of a stream's rate control.
constexpr std::int64_t kProbeFrames = 150;

/// A lane, the rate that it is asked for and the run that came closest.
struct Rung {
    TextureLane lane;
    std::optional<double> kbps;
    TextureRun best;
    bool done = false;

    void judge(TextureRun run, bool first, Rational frame_rate, std::int64_t frames) {
        const auto miss = [&](const TextureRun& of) { return std::abs(std::log(of.kbps(frame_rate, frames) / *kbps)); };
        const bool better = first || miss(run) < miss(best);
        if (better) best = std::move(run);
        done = !better || !kbps || std::abs(best.kbps(frame_rate, frames) / *kbps - 1) <= kTolerance;
        if (!done)
            lane.settings.kbps = std::clamp(*lane.settings.kbps * *kbps / best.kbps(frame_rate, frames), std::max(kLeastKbps, *kbps / 8), *kbps * 8);
    }
};

/// Packets into groups, held against what a group promises: it starts with the key frame of its first picture
/// and holds exactly its own pictures.
Result<std::vector<protocol::Group>> group_packets(std::vector<media::VideoPacket> packets,
                                                   std::int64_t frames, std::int64_t group_frames,
                                                   const std::string& codec) {
    std::vector<protocol::Group> groups;
    for (media::VideoPacket& packet : packets) {
        const std::int64_t number = packet.frame / group_frames;
        if (number == std::int64_t(groups.size()) && packet.key && packet.frame == number * group_frames) {
            protocol::Group group;
            group.group = std::uint32_t(number);
            group.first_time = packet.frame;
            groups.push_back(std::move(group));
        }
        if (number + 1 != std::int64_t(groups.size()))
            return Error{ErrorCode::unavailable,
                         "the " + codec +
                             " encoder here does not start closed groups where it is told to (frame " +
                             std::to_string(packet.frame) + ")"};
        groups.back().objects.push_back({1, std::move(packet.bytes)});
    }
    for (std::size_t g = 0; g < groups.size(); ++g)
        if (std::int64_t(groups[g].objects.size()) !=
            std::min(group_frames, frames - std::int64_t(g) * group_frames))
            return Error{
                ErrorCode::unavailable,
                "the " + codec + " encoder here drops or repeats pictures in group " + std::to_string(g)};
    return groups;
}

Result<void> check(const TextureOptions& options, int width) {
    const auto sensible = [](double kbps) { return kbps >= kLeastKbps && kbps <= 2e6; };
    if (options.kbps && options.quality)
        return Error{ErrorCode::invalid, "texture takes a bitrate or a quality, not both"};
    if (!options.rungs.empty() && (options.kbps || options.quality))
        return Error{ErrorCode::invalid, "texture takes rungs, a bitrate or a quality, only one of them"};
    if (options.kbps && !sensible(*options.kbps))
        return Error{ErrorCode::invalid, "texture bitrate must be 1 to 2 000 000 kbit/s"};
    if (options.quality && !(*options.quality >= 0 && *options.quality <= 100))
        return Error{ErrorCode::invalid, "texture quality must be 0 to 100"};
    if (options.rungs.size() > TextureOptions::kMaxRungs)
        return Error{ErrorCode::invalid, "a texture has at most " + std::to_string(TextureOptions::kMaxRungs) + " rungs"};
    double last = 0;
    for (const TextureRung& rung : options.rungs) {
        if (!sensible(rung.kbps))
            return Error{ErrorCode::invalid, "texture bitrate must be 1 to 2 000 000 kbit/s"};
        if (!(rung.kbps > last)) return Error{ErrorCode::invalid, "rungs of texture go from the lowest bitrate to the highest"};
        if (rung.width < 0 || rung.width > width)
            return Error{ErrorCode::invalid, "a rung " + std::to_string(rung.width) + " texels wide does not fit a texture of " +
                                                 std::to_string(width)};
        last = rung.kbps;
    }
    return {};
}

}  // namespace

std::vector<std::string> texture_codecs() {
    return media::VideoEncoder::available();
}

Result<EncodedTexture> encode_texture(const Clip& clip, const TextureOptions& options,
                                      const Progress& progress) {
    assert(clip.texture);
    TextureSource& source = *clip.texture;
    const int width = source.width(), height = source.height();
    const std::int64_t frames = source.frames();
    if (frames < 1 || width < 1 || height < 1) return Error{ErrorCode::invalid, "texture has no frames"};
    if (width > int(protocol::kMaxTextureSide) || height > int(protocol::kMaxTextureSide))
        return Error{ErrorCode::limit_exceeded, "texture of " + std::to_string(width) + " x " +
                                                    std::to_string(height) + " texels is larger than " +
                                                    std::to_string(protocol::kMaxTextureSide) + " on a side"};
    MIEN_CHECK(check(options, width));

    const std::int64_t group_frames =
        options.group_frames > 0 ? std::min(options.group_frames, frames) : frames;
    std::vector<Rung> rungs;
    const auto add_rung = [&](std::optional<double> kbps, int lane_width) {
        TextureLane lane;
        lane.width = lane_width > 0 ? lane_width : width;
        lane.height = std::max(1, int(std::lround(double(height) * lane.width / width)));
        media::VideoEncoderSettings& settings = lane.settings;
        settings.codec = options.codec;
        settings.width = media::coded_side(lane.width);
        settings.height = media::coded_side(lane.height);
        settings.frame_rate = clip.frame_rate;
        settings.kbps = kbps;
        settings.quality = options.quality.value_or(settings.quality);
        settings.speed = options.speed;
        settings.key_interval = group_frames;
        if (options.weighted) {
            const auto same = std::find_if(rungs.begin(), rungs.end(), [&](const Rung& other) { return other.lane.width == lane.width; });
            lane.weights = same != rungs.end() ? same->lane.weights : texture_weights(clip, lane.width, lane.height);
            if (media::VideoEncoder::takes_regions(options.codec))
                settings.regions = texture_regions(lane.weights, lane.width, lane.height);
            else
                lane.shrink = std::make_shared<TextureShrink>(lane.weights, lane.width, lane.height);
        }
        rungs.push_back({std::move(lane), kbps, {}, false});
    };
    for (const TextureRung& rung : options.rungs) add_rung(rung.kbps, rung.width);
    if (options.rungs.empty()) add_rung(options.kbps, 0);

    TextureFill fill(width, height, used_texels(clip, width, height));
    std::vector<TextureLane*> lanes;
    for (Rung& rung : rungs) lanes.push_back(&rung.lane);
    MIEN_CHECK(choose_steps(source, fill, lanes, std::min(frames, kProbeFrames), progress));
    for (int again = 0; again <= kRetries; ++again) {
        std::vector<Rung*> open;
        lanes.clear();
        for (Rung& rung : rungs)
            if (!rung.done) {
                open.push_back(&rung);
                lanes.push_back(&rung.lane);
            }
        if (open.empty()) break;
        MIEN_TRY(runs, encode_lanes(source, fill, lanes, frames, progress));
        for (std::size_t i = 0; i < open.size(); ++i) open[i]->judge(std::move(runs[i]), again == 0, clip.frame_rate, frames);
    }

    EncodedTexture out;
    out.info = {std::uint32_t(width), std::uint32_t(height), YuvView::Matrix::bt709, rungs.front().lane.settings.full_range};
    out.codec = options.codec;
    for (Rung& rung : rungs) {
        const double kbps = rung.best.kbps(clip.frame_rate, frames);
        MIEN_TRY(groups, group_packets(std::move(rung.best.packets), frames, group_frames, options.codec));
        out.rungs.push_back({rung.lane.width, rung.lane.height, rung.kbps, kbps, std::move(rung.best.codec_config), std::move(groups)});
    }
    return out;
}

}  // namespace mien::encoder
