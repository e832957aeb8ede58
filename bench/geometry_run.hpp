#pragma once

#include "bench/geometry_codec.hpp"
#include "bench/report.hpp"

namespace mien::bench {

/// Encodes at one asked error, decodes every frame and measures against the clip as it was captured. What goes wrong is in
/// the row's `failed`. The stream stays for timing.
struct GeometryRun {
    GeometryRow row;
    std::unique_ptr<GeometryStream> stream;
};
GeometryRun run_geometry(const GeometryInput& input, const GeometryCodec& codec, double rms);

/// Measures a stream by decoding it from start to end: fills rms, peak and kg of the row.
Result<void> measure(const GeometryInput& input, GeometryStream& stream, GeometryRow& row);

}  // namespace mien::bench
