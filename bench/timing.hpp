#pragma once

#include "bench/geometry_codec.hpp"
#include "bench/report.hpp"
#include "core/progress.hpp"

namespace mien::bench {

/// One codec of a timing run.
struct Timed {
    const GeometryCodec* codec;
    GeometryStream* stream;
};

/// Decodes all streams in turn, a unit of `unit_frames` frames each, again and again for `rounds` rounds, on this thread; who
/// goes first changes from unit to unit. Set "frame": times of single frames inside the units, of codecs that decode a frame
/// alone; set "group": whole units, of all codecs whose frames come out within one. The first entry is what ratios refer to,
/// for a set that it takes part in; else the first that does.
Result<std::vector<TimingRow>> time_decoding(const GeometryInput& input, const std::vector<Timed>& entries, double rms,
                                             std::int64_t unit_frames, int rounds, const Progress& progress = {});

/// Set "encode": whole encodings of the clip, in turn.
Result<std::vector<TimingRow>> time_encoding(const GeometryInput& input, const std::vector<const GeometryCodec*>& codecs,
                                             double rms, int rounds, const Progress& progress = {});

/// Value below which the share `q` of the samples lies, linear between samples. At least one sample.
double quantile(std::vector<double> samples, double q);

/// Processor, system and compiler; read bandwidth and SGEMM rate measured now on one core.
Machine measure_machine(bool quick);

}  // namespace mien::bench
