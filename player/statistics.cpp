#include "player/statistics.hpp"

#include <cerrno>
#include <cstring>
#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "core/environment_error.hpp"

namespace mien::player {

std::string to_json(const Statistics& s) {
    nlohmann::ordered_json json = {
        {"startup_s", s.startup},
        {"startup_bytes", s.startup_bytes},
        {"frames", s.frames},
        {"frames_per_second", s.frames_per_second},
        {"dropped_frames", s.dropped},
        {"stalls", s.stalls},
        {"damaged_groups", s.damaged_groups + s.source.damaged_groups},
        {"bytes",
         {{"received", s.source.bytes},
          {"model", s.source.blob_bytes},
          {"motion", s.motion_bytes},
          {"texture", s.texture_bytes},
          {"sound", s.sound_bytes}}},
        {"blobs", {{"fetched", s.source.blobs_fetched}, {"from_cache", s.source.blobs_from_cache}}},
        {"model", {{"bytes", s.source.model_bytes}, {"of", s.source.model_size}}},
        {"reconnects", s.source.reconnects},
        {"round_trip_s", s.source.round_trip},
        {"renderer", s.renderer},
    };
    for (const Damage& damage : s.damage) json["damage"].push_back({{"track", name_of(damage.track)}, {"from_s", damage.first}, {"to_s", damage.end}});
    if (s.cost)
        json["milliseconds_per_frame"] = {
            {"wait", s.cost->wait}, {"upload", s.cost->upload}, {"draw", s.cost->draw}, {"processor", s.cost->processor}};
    if (s.rendered_psnr) json["rendered_psnr_y_db"] = *s.rendered_psnr;
    if (s.rendered_ssim) json["rendered_ssim"] = *s.rendered_ssim;
    return json.dump(2) + "\n";
}

void write_json(const std::filesystem::path& path, const Statistics& statistics) {
    std::ofstream file(path, std::ios::binary);
    file << to_json(statistics);
    file.close();
    if (!file) throw EnvironmentError(fmt::format("cannot write {}: {}", path.string(), std::strerror(errno)));
}

}  // namespace mien::player
