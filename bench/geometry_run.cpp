#include "bench/geometry_run.hpp"

#include "tools/motion_error.hpp"

namespace mien::bench {

Result<void> measure(const GeometryInput& input, GeometryStream& stream, GeometryRow& row) {
    MIEN_CHECK(stream.start());
    tools::MotionError error;
    std::vector<float> out(std::size_t(input.numbers()));
    for (std::int64_t f = 0; f < input.frames; ++f) {
        MIEN_CHECK(stream.decode(f, out));
        error.add(input.truth(f), out.data(), input.points, input.dimension);
    }
    row.rms = error.rms();
    row.peak = error.peak();
    row.kg = error.kg_percent();
    return {};
}

GeometryRun run_geometry(const GeometryInput& input, const GeometryCodec& codec, double rms) {
    GeometryRun run;
    GeometryRow& row = run.row;
    row.codec = codec.name;
    row.library = codec.library;
    row.mode = codec.mode == Mode::live ? "live" : "file";
    row.asked_rms = codec.lossless ? 0 : rms;
    auto stream = codec.encode(input, rms);
    if (!stream.ok()) {
        row.failed = stream.error().message;
        return run;
    }
    run.stream = std::move(*stream);
    row.parts = run.stream->parts;
    row.apart = run.stream->apart;
    row.bytes = run.stream->bytes();
    const double bits = 8.0 * double(row.bytes), frames = double(input.frames);
    row.kbps = bits / 1000 * input.clip.frame_rate.value() / frames;
    row.bits_per_vertex_frame = bits / frames / double(input.points);
    const auto measured = measure(input, *run.stream, row);
    if (!measured.ok()) {
        row.failed = measured.error().message;
        run.stream.reset();
    }
    return run;
}

}  // namespace mien::bench
