#include <fmt/core.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tools/commands.hpp"
#include "tools/console.hpp"
#include "tools/stored_stream.hpp"

namespace mien::tools {
namespace {

using nlohmann::ordered_json;
using protocol::BlobKind;
using protocol::TrackKind;

const char* name_of(TrackKind kind) {
    return kind == TrackKind::motion ? "motion" : kind == TrackKind::texture ? "texture" : "sound";
}

/// The bytes of a file by what they are for (design: shape, connectivity, basis, probabilities, coefficients, pose,
/// texture, sound, framing). They add up to the total; what a lost message left unclaimed counts as framing.
struct ByteSplit {
    std::uint64_t total = 0, shape = 0, connectivity = 0, basis = 0, probabilities = 0, coefficients = 0, pose = 0, texture = 0,
                  sound = 0, framing = 0;
};

/// Shares of coefficients and pose in the motion objects, by ideal code lengths of a decode.
Result<double> pose_share(const StoredStream& stream) {
    const protocol::Track* track = stream.track(TrackKind::motion);
    MIEN_TRY(model, stream.model());
    MIEN_TRY(decoder, stream.motion_decoder(model));
    for (const auto& entry : stream.reader().index()) {
        if (entry.slot != track->rungs.front().slot) continue;
        MIEN_TRY(group, stream.reader().read_group(entry));
        decoder.begin_group();
        std::int64_t frame = group.first_time;
        for (const auto& object : group.objects) {
            MIEN_CHECK(decoder.decode(object, frame));
            frame += object.frames;
        }
    }
    const auto split = decoder.split();
    const double all = split.coefficients + split.pose;
    return all > 0 ? split.pose / all : 0.0;
}

Result<ByteSplit> split_bytes(const StoredStream& stream) {
    MIEN_TRY(account, stream.reader().account());
    ByteSplit split;
    split.total = account.total;
    for (const auto& blob : account.blobs) {
        switch (blob.info.kind) {
            case BlobKind::manifest: break;  // hashes and names: framing
            case BlobKind::shape:
            case BlobKind::blend:
            case BlobKind::blendshapes:
            case BlobKind::eyes:
            case BlobKind::contact: split.shape += blob.stored; break;
            case BlobKind::connectivity:
            case BlobKind::texcoords: split.connectivity += blob.stored; break;
            case BlobKind::texture: split.texture += blob.stored; break;
            case BlobKind::motion_basis: {
                const Bytes* bytes = stream.blob(blob.info.hash);
                MIEN_TRY(parts, decoder::split_basis(*bytes));
                const double share = double(parts.probabilities) / std::max<double>(1, double(parts.basis + parts.probabilities));
                const auto probabilities = std::uint64_t(std::llround(share * double(blob.stored)));
                split.probabilities += probabilities;
                split.basis += blob.stored - probabilities;
                break;
            }
        }
    }
    for (const protocol::Track& track : stream.header().tracks)
        for (const protocol::Rung& rung : track.rungs) {
            const auto slot = account.slots.find(rung.slot);
            const std::uint64_t payload = slot == account.slots.end() ? 0 : slot->second.payload;
            if (track.kind == TrackKind::texture) split.texture += payload;
            if (track.kind == TrackKind::sound) split.sound += payload;
            if (track.kind == TrackKind::motion) split.coefficients += payload;
        }
    if (stream.track(TrackKind::motion)) {
        MIEN_TRY(share, pose_share(stream));
        split.pose = std::uint64_t(std::llround(share * double(split.coefficients)));
        split.coefficients -= split.pose;
    }
    split.framing = split.total - (split.shape + split.connectivity + split.basis + split.probabilities + split.coefficients + split.pose + split.texture + split.sound);
    return split;
}

ordered_json to_json(const ByteSplit& s) {
    return {{"total", s.total},           {"shape", s.shape},
            {"connectivity", s.connectivity}, {"basis", s.basis},
            {"probabilities", s.probabilities}, {"coefficients", s.coefficients},
            {"pose", s.pose},             {"texture", s.texture},
            {"sound", s.sound},           {"framing", s.framing}};
}

std::string describe(const protocol::Track& track) {
    if (const auto* m = std::get_if<protocol::MotionInfo>(&track.info))
        return fmt::format("{} {}{}{}{}", m->count, m->kind == protocol::MotionKind::vertices ? "vertices" : m->kind == protocol::MotionKind::markers ? "markers" : "weights",
                           m->has_pose ? ", head pose" : "", m->has_gaze ? ", gaze" : "", m->has_presence ? ", some missing" : "");
    if (const auto* t = std::get_if<protocol::TextureInfo>(&track.info)) return fmt::format("{} x {}", t->width, t->height);
    const auto& s = std::get<protocol::SoundInfo>(track.info);
    return fmt::format("{} Hz, {} channel{}", s.sample_rate, s.channels, s.channels == 1 ? "" : "s");
}

int info(const std::string& file, bool json) {
    auto opened = StoredStream::open(file);
    if (!opened.ok()) return fail(opened.error());
    const StoredStream& stream = *opened;
    auto split = split_bytes(stream);
    if (!split.ok()) return fail(split.error());
    const auto& header = stream.header();
    const double seconds = double(header.frames) / header.frame_rate.value();
    auto account = stream.reader().account();
    if (!account.ok()) return fail(account.error());

    ordered_json out;
    out["name"] = header.name;
    out["duration_s"] = seconds;
    out["frames"] = header.frames;
    out["fps"] = to_string(header.frame_rate);
    out["group_frames"] = header.group_frames;
    out["model"] = header.model.hex();
    out["complete"] = stream.reader().complete();
    out["bytes"] = to_json(*split);
    out["tracks"] = ordered_json::array();
    for (const protocol::Track& track : header.tracks)
        for (const protocol::Rung& rung : track.rungs) {
            const auto slot = account->slots.find(rung.slot);
            const std::uint64_t payload = slot == account->slots.end() ? 0 : slot->second.payload;
            out["tracks"].push_back({{"kind", name_of(track.kind)}, {"codec", rung.codec}, {"kbps", seconds > 0 ? double(payload) * 8 / 1000 / seconds : 0.0},
                                     {"description", describe(track)}});
        }
    if (json) {
        fmt::print("{}\n", out.dump(2));
        return kDone;
    }
    fmt::print("{}: {}, {} frames at {} frames/s, groups of {}\n", header.name, human_time(seconds), header.frames, to_string(header.frame_rate),
               header.group_frames ? fmt::format("{} frames", header.group_frames) : "the whole clip");
    fmt::print("model {}\n", header.model.hex().substr(0, 16));
    for (const auto& track : out["tracks"])
        fmt::print("  {:<8} {:<7} {:>9.2f} kbit/s  {}\n", track["kind"].get<std::string>(), track["codec"].get<std::string>(), track["kbps"].get<double>(),
                   track["description"].get<std::string>());
    fmt::print("bytes\n");
    for (const auto& [part, bytes] : out["bytes"].items())
        fmt::print("  {:<14} {:>13}  {:>9.2f} kbit/s\n", part, with_thousands(bytes.get<std::uint64_t>()),
                   seconds > 0 ? bytes.get<double>() * 8 / 1000 / seconds : 0.0);
    if (!stream.reader().complete()) warn(stream.reader().complaint());
    return kDone;
}

}  // namespace

void add_info(CLI::App& mien, int& code) {
    auto file = std::make_shared<std::string>();
    auto json = std::make_shared<bool>(false);
    CLI::App* command = mien.add_subcommand("info", "Show what a stream file holds and where its bytes go");
    command->add_option("file", *file, "Stream file")->required();
    command->add_flag("--json", *json, "As JSON");
    command->callback([file, json, &code] { code = guarded([&] { return info(*file, *json); }); });
}

}  // namespace mien::tools
