#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "net/source.hpp"
#include "player/damage_log.hpp"

namespace mien::player {

/// What a run of the player was like; `--stats-json` and the overlay.
struct Statistics {
    double startup = 0;                ///< seconds from the start of the process, or the drop of a file, to the first frame drawn
    std::uint64_t startup_bytes = 0;   ///< received until then
    std::int64_t frames = 0;           ///< drawn
    double frames_per_second = 0;      ///< of decoding and drawing what was received (headless: as fast as it goes)
    std::uint64_t dropped = 0;         ///< frames decoded or skipped, never shown, because they came too late
    std::uint32_t stalls = 0;          ///< times playing had to wait for the network
    std::uint64_t damaged_groups = 0;
    std::vector<Damage> damage;        ///< met in a recording
    std::uint64_t motion_bytes = 0, texture_bytes = 0, sound_bytes = 0;   ///< of objects
    net::SourceStatistics source;
    /// Means per frame of --benchmark, ms. The first three follow each other on one thread; `processor` is what all
    /// threads of the process took, decoding included.
    struct FrameCost {
        double wait = 0;      ///< for the next decoded frame
        double upload = 0;    ///< of coefficients and texture
        double draw = 0;      ///< shape, shadow, face, smoothing, until the picture is there
        double processor = 0;
    };
    std::optional<FrameCost> cost;
    std::string renderer;
    /// Of the received against the truth pictures, --compare.
    std::optional<double> rendered_psnr, rendered_ssim;
};

/// How to_json() begins, spaces and line ends apart.
inline constexpr std::string_view kStatisticsBegin = R"({"startup_s":)";
std::string to_json(const Statistics& statistics);
/// Throws EnvironmentError.
void write_json(const std::filesystem::path& path, const Statistics& statistics);

}  // namespace mien::player
