#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "protocol/texture_rungs.hpp"
#include "tools/byte_split.hpp"
#include "tools/commands.hpp"
#include "tools/console.hpp"
#include "tools/stored_stream.hpp"

namespace mien::tools {
namespace {

using nlohmann::ordered_json;
using protocol::TrackKind;

const char* name_of(TrackKind kind) {
    return kind == TrackKind::motion ? "motion" : kind == TrackKind::texture ? "texture" : "sound";
}

ordered_json to_json(const ByteSplit& s) {
    return {{"total", s.total},           {"shape", s.shape},
            {"detail", s.detail},         {"connectivity", s.connectivity},
            {"basis", s.basis},           {"probabilities", s.probabilities},
            {"coefficients", s.coefficients}, {"pose", s.pose},
            {"texture", s.texture},       {"sound", s.sound},
            {"framing", s.framing}};
}

std::string describe(const protocol::Track& track, const protocol::Rung& rung) {
    if (const auto* m = std::get_if<protocol::MotionInfo>(&track.info))
        return fmt::format("{} {}{}{}{}", m->count, m->kind == protocol::MotionKind::vertices ? "vertices" : m->kind == protocol::MotionKind::markers ? "markers" : "weights",
                           m->has_pose ? ", head pose" : "", m->has_gaze ? ", gaze" : "", m->has_presence ? ", some missing" : "");
    if (track.kind == protocol::TrackKind::texture) {
        const protocol::Rung::Size size = protocol::texture_size(track, rung);
        return fmt::format("{} x {}", size.width, size.height);
    }
    const auto& s = std::get<protocol::SoundInfo>(track.info);
    return fmt::format("{} Hz, {} channel{}", s.sample_rate, s.channels, s.channels == 1 ? "" : "s");
}

/// Of a model file: it has no tracks, and so no time.
Result<int> info_of_model(const std::string& file, const StoredStream& stream, bool json) {
    MIEN_TRY(layers, split_model(stream));
    MIEN_TRY(account, stream.reader().account());
    const auto& header = stream.header();
    if (!stream.reader().complete()) warn(fmt::format("'{}': {}", file, stream.reader().complaint()));
    if (json) {
        ordered_json out{{"name", header.name}, {"actor", stream.reader().manifest().actor}, {"model", header.model.hex()}};
        out["bytes"] = {{"total", account.total}};
        out["layers"] = ordered_json::array();
        for (const LayerBytes& layer : layers) out["layers"].push_back({{"name", layer.name}, {"blobs", layer.blobs}, {"bytes", layer.bytes}});
        out["tracks"] = ordered_json::array();
        out["complete"] = stream.reader().complete();
        fmt::print("{}\n", out.dump(2));
        return kDone;
    }
    fmt::print("{}: a face model, {} blobs\nmodel {}\nbytes\n", header.name, account.blobs.size(), header.model.hex().substr(0, 16));
    fmt::print("  {:<14} {:>13}\n", "total", with_thousands(account.total));
    for (const LayerBytes& layer : layers) fmt::print("  {:<14} {:>13}\n", layer.name, with_thousands(layer.bytes));
    return kDone;
}

Result<int> info(const std::string& file, bool json) {
    MIEN_TRY(stream, StoredStream::open(file));
    if (stream.header().tracks.empty()) return info_of_model(file, stream, json);
    MIEN_TRY(split, split_bytes(stream));
    const auto& header = stream.header();
    const double seconds = double(header.frames) / header.frame_rate.value();
    MIEN_TRY(account, stream.reader().account());

    ordered_json out;
    out["name"] = header.name;
    out["duration_s"] = seconds;
    out["frames"] = header.frames;
    out["fps"] = to_string(header.frame_rate);
    out["group_frames"] = header.group_frames;
    out["model"] = header.model.hex();
    std::vector<std::string> damage;
    out["bytes"] = to_json(split);
    out["tracks"] = ordered_json::array();
    for (const protocol::Track& track : header.tracks)
        for (const protocol::Rung& rung : track.rungs) {
            const auto slot = account.slots.find(rung.slot);
            const auto found = slot == account.slots.end() ? protocol::StreamFileReader::Accounting::Slot{} : slot->second;
            out["tracks"].push_back({{"kind", name_of(track.kind)}, {"codec", rung.codec}, {"kbps", seconds > 0 ? double(found.payload) * 8 / 1000 / seconds : 0.0},
                                     {"description", describe(track, rung)}});
            out["tracks"].back()["damaged_groups"] = found.damaged;
            if (found.damaged > 0) damage.push_back(fmt::format("{} {}: damaged groups: {} of {}", name_of(track.kind), rung.codec, found.damaged, found.groups));
            if (rung.refines) out["tracks"].back()["refines"] = *rung.refines;
        }
    out["complete"] = stream.reader().complete() && damage.empty();
    if (!stream.reader().complete()) damage.push_back(stream.reader().complaint());
    for (const std::string& what : damage) warn(fmt::format("'{}': {}", file, what));
    if (json) {
        fmt::print("{}\n", out.dump(2));
        return kDone;
    }
    fmt::print("{}: {}, {} frames at {} frames/s, groups of {}\n", header.name, human_time(seconds), header.frames, to_string(header.frame_rate),
               header.group_frames ? fmt::format("{} frames", header.group_frames) : "the whole clip");
    fmt::print("model {}\n", header.model.hex().substr(0, 16));
    for (const auto& track : out["tracks"])
        fmt::print("  {:<8} {:<7} {:>9.2f} kbit/s  {}\n", track["kind"].get<std::string>(), track["codec"].get<std::string>(), track["kbps"].get<double>(),
                   track.contains("refines") ? fmt::format("refines slot {}", track["refines"].get<int>()) : track["description"].get<std::string>());
    fmt::print("bytes\n");
    for (const auto& [part, bytes] : out["bytes"].items())
        fmt::print("  {:<14} {:>13}  {:>9.2f} kbit/s\n", part, with_thousands(bytes.get<std::uint64_t>()),
                   seconds > 0 ? bytes.get<double>() * 8 / 1000 / seconds : 0.0);
    return kDone;
}

}  // namespace

void add_info(CLI::App& mien, int& code) {
    auto file = std::make_shared<std::string>();
    auto json = std::make_shared<bool>(false);
    CLI::App* command = mien.add_subcommand("info", "Show what a stream or model file holds and where its bytes go");
    command->add_option("file", *file, "Stream or model file")->required();
    command->add_flag("--json", *json, "As JSON");
    command->callback([file, json, &code] { code = guarded([&] { return info(*file, *json); }, *json); });
}

}  // namespace mien::tools
