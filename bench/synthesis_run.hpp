#pragma once

#include <string>
#include <vector>

#include "core/progress.hpp"
#include "core/result.hpp"
#include "model/face_model.hpp"

namespace mien::bench {

/// What one frame of a trained model costs on the processor, one core: its maps evaluated, and the base shape that they stand on.
struct SynthesisTimes {
    struct Row {
        std::string name;                      ///< "medium", "fine", "medium + fine", "albedo"
        std::size_t bytes = 0;                 ///< of the coefficients that a frame reads
        std::int64_t values = 0;               ///< channels times texels
        double read = 0, fast = 0, plain = 0;  ///< median seconds: coefficients only read, evaluate(), evaluate_plain()
        double ratio = 0;                      ///< median of fast over read, pairs of one round
        double plain_ratio = 0;                ///< likewise of plain over fast
        double difference = 0;                 ///< largest between fast and plain, in the layer's unit
    };
    std::vector<Row> rows;
    double load = 0;              ///< s: shell solved, marker mesh and samplers made
    double compose = 0;           ///< s: base shape times a basis of marker motion, once a stream
    double base_shape = 0;        ///< median s: the composed motion of `components` coefficients, offsets of all vertices
    double deformation = 0;       ///< median s: strains of the markers and d1, d2 of the domain
    std::int64_t vertices = 0, markers = 0, components = 0;
    int medium_side = 0, fine_side = 0;   ///< texels across the maps
};

/// Times `rounds` frames whose markers move; in each, everything is run in turn. `invalid` of a model without detail layers.
Result<SynthesisTimes> time_synthesis(const model::FaceModel& face, int rounds, const Progress& progress = {});

}  // namespace mien::bench
