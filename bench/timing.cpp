#include "bench/timing.hpp"

#include <algorithm>
#include <cassert>
#include <chrono>
#include <cmath>

#include "core/parallel.hpp"

namespace mien::bench {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Everything on one core while this lives.
class OneCore {
public:
    OneCore() { set_thread_count(1); }
    ~OneCore() { set_thread_count(0); }
    OneCore(const OneCore&) = delete;
    OneCore& operator=(const OneCore&) = delete;
};

struct Samples {
    std::vector<double> frames;  ///< of single frames
    std::vector<double> units;   ///< of whole units, per frame; unit i of every entry is the same frames in the same round
};

TimingRow row_of(const GeometryInput& input, const GeometryCodec& codec, const std::string& set, double rms,
                 std::int64_t unit_frames, const std::vector<double>& samples, const std::vector<double>& units,
                 const std::vector<double>& first_units) {
    TimingRow row;
    row.set = set;
    row.codec = codec.name;
    row.library = codec.library;
    row.asked_rms = rms;
    row.unit_frames = unit_frames;
    row.samples = std::int64_t(samples.size());
    row.lower = quantile(samples, 0.25);
    row.median = quantile(samples, 0.5);
    row.upper = quantile(samples, 0.75);
    row.ns_per_point = row.median * 1e9 / double(input.points);
    std::vector<double> ratios;
    for (std::size_t i = 0; i < units.size(); ++i) ratios.push_back(units[i] / first_units[i]);
    row.ratio = quantile(ratios, 0.5);
    return row;
}

}  // namespace

double quantile(std::vector<double> samples, double q) {
    assert(!samples.empty());
    std::sort(samples.begin(), samples.end());
    const double place = q * double(samples.size() - 1);
    const auto below = std::size_t(place);
    const std::size_t above = std::min(below + 1, samples.size() - 1);
    return samples[below] + (place - double(below)) * (samples[above] - samples[below]);
}

Result<std::vector<TimingRow>> time_decoding(const GeometryInput& input, const std::vector<Timed>& entries, double rms,
                                             std::int64_t unit_frames, int rounds, const Progress& progress) {
    const OneCore one_core;
    const std::int64_t units = (input.frames + unit_frames - 1) / unit_frames;
    std::vector<float> out(std::size_t(input.numbers()));
    std::vector<Samples> samples(entries.size());
    for (int round = 0; round < rounds; ++round) {
        for (const Timed& entry : entries) MIEN_CHECK(entry.stream->start());
        for (std::int64_t unit = 0; unit < units; ++unit) {
            if (progress) progress("timing decoders", round * units + unit, rounds * units);
            const std::int64_t first = unit * unit_frames, end = std::min(input.frames, first + unit_frames);
            for (std::size_t turn = 0; turn < entries.size(); ++turn) {
                const std::size_t e = (turn + std::size_t(unit)) % entries.size();
                double sum = 0;
                for (std::int64_t f = first; f < end; ++f) {
                    const auto start = Clock::now();
                    MIEN_CHECK(entries[e].stream->decode(f, out));
                    const double seconds = seconds_since(start);
                    samples[e].frames.push_back(seconds);
                    sum += seconds;
                }
                samples[e].units.push_back(sum / double(end - first));
            }
        }
    }
    if (progress) progress("timing decoders", 1, 1);

    std::vector<TimingRow> rows;
    for (const bool single : {true, false}) {
        const Samples* subject = nullptr;
        for (std::size_t e = 0; e < entries.size(); ++e) {
            const GeometryStream& stream = *entries[e].stream;
            if (single ? entries[e].codec->mode != Mode::live || stream.frames_together > 1
                       : stream.frames_together > unit_frames)
                continue;
            if (!subject) subject = &samples[e];
            rows.push_back(row_of(input, *entries[e].codec, single ? "frame" : "group", rms, single ? 1 : unit_frames,
                                  single ? samples[e].frames : samples[e].units, samples[e].units, subject->units));
        }
    }
    return rows;
}

Result<std::vector<TimingRow>> time_encoding(const GeometryInput& input, const std::vector<const GeometryCodec*>& codecs,
                                             double rms, int rounds, const Progress& progress) {
    const OneCore one_core;
    std::vector<std::vector<double>> samples(codecs.size());
    for (int round = 0; round < rounds; ++round)
        for (std::size_t c = 0; c < codecs.size(); ++c) {
            if (progress)
                progress("timing encoders", round * std::int64_t(codecs.size()) + std::int64_t(c),
                         rounds * std::int64_t(codecs.size()));
            const auto start = Clock::now();
            MIEN_CHECK(codecs[c]->encode(input, rms));
            samples[c].push_back(seconds_since(start) / double(input.frames));
        }
    if (progress) progress("timing encoders", 1, 1);
    std::vector<TimingRow> rows;
    for (std::size_t c = 0; c < codecs.size(); ++c)
        rows.push_back(row_of(input, *codecs[c], "encode", rms, input.frames, samples[c], samples[c], samples[0]));
    return rows;
}

}  // namespace mien::bench
