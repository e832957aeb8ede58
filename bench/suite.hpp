#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/report.hpp"
#include "core/clip.hpp"
#include "core/progress.hpp"
#include "protocol/stream.hpp"

namespace mien::bench {

struct SuiteOptions {
    std::vector<double> rms;                  ///< asked errors, mm; empty: 0.4 0.2 0.1 0.05 0.025 (weights: a twentieth of it)
    std::vector<std::string> codecs;          ///< name beginnings; empty: all
    std::vector<std::string> texture_codecs;  ///< empty: all that there are
    std::vector<double> texture_kbps{120, 240, 480, 1000};
    std::string motion = "auto";  ///< vertices, markers, weights
    bool geometry = true, timing = true, texture = true, views = true;
    bool force = false;  ///< rows that are there already are run again
    int timing_rounds = 5;
    std::int64_t view_pictures = 8;  ///< frames drawn, from three cameras each
    double encode_seconds = 4;       ///< of the clip, for timing encoders
};

/// Runs everything asked for on one clip that the report does not hold yet, and adds it. `save` is called after every
/// finished piece. Rows that failed are run again.
Result<void> run_clip(const Clip& clip, const SuiteOptions& options, Report& report, const std::function<void()>& save,
                      const Progress& progress = {});

/// Forgets what other sources of this project measured of themselves, and timing runs with them.
void drop_other_builds(Report& report);

/// The motion of the clip that `asked` ("vertices", "markers", "weights", "auto": the first that there is) means; none: it has none. `missing` of what it
/// has not, `invalid` of other words.
Result<std::optional<protocol::MotionKind>> motion_kind(const Clip& clip, const std::string& asked);

bool chosen(const std::vector<std::string>& beginnings, const std::string& name);  ///< true when there are none

}  // namespace mien::bench
