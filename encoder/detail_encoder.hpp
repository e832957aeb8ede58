#pragma once

#include <string>
#include <vector>

#include "core/image.hpp"
#include "core/progress.hpp"
#include "core/result.hpp"
#include "model/detail_model.hpp"
#include "model/term_basis.hpp"
#include "protocol/stream.hpp"

namespace mien::encoder {

struct DetailOptions {
    /// RMS that coding may add to a layer over the training frames: mm, per texel; albedo: of its three channels together, linear.
    /// The defaults are far below what a face scanner resolves and what is seen.
    double medium = 0.02, fine = 0.002, albedo = 0.00055;
    /// Bytes of the medium and the fine map, and of all maps; 0: no bound. Map by map the error grows, and a stage goes with each doubling, until
    /// it is kept; the medium map may take half of what it shares.
    std::size_t most_shape_bytes = 0, most_map_bytes = 0;
    std::size_t most_bytes = 0;   ///< of the model file; all three errors grow alike until it is kept. 0: no bound
    std::string name;             ///< of the model file
    int stages = 5;               ///< of each map: every one halves its step; 1 .. coding::kMaxStages
    int fine_stages = 0;          ///< of the fine map, when it is not `stages`
    float mesh_step = 1.0f / 32;  ///< grid of the neutral positions, mm
    const Image* picture = nullptr;  ///< colours all that the albedo map does not; null: none
    Progress progress;
};

/// What to ask when nobody says: the fine layer's error is `fine_error` (mm RMS, what its fit can stand) where that is less than the usual, and
/// it still begins as coarse as ever; a perfect scanner's relief is worth 200 kB with the medium layer, and all maps 800 kB.
DetailOptions detail_options(double fine_error);

struct EncodedDetail {
    Hash manifest;
    std::vector<protocol::StaticBlob> blobs;  ///< manifest first, then in fetching order
    model::DetailModel model;                 ///< as a decoder will have it, but with the maps not rounded: mesh, sites, axes, domains
    struct Layer {
        std::string name;                     ///< "medium", "fine", "albedo"
        double error = 0;                     ///< RMS that coding added over the training frames
        std::vector<std::size_t> stage_bytes;
    };
    std::vector<Layer> layers;
};

/// Packs a detail model into blobs: mesh, shell, marker domain, what moves beside the shell (blend coefficients of all that is not
/// skin, eyes, contact of the lips), and of every map a first stage and refinements. `moments`: of the
/// training frames (Trained models hold them). Errors: coefficients that are not finite or too large for the asked error; most_bytes that cannot be kept;
/// bounds of the format.
Result<EncodedDetail> encode_detail(const model::DetailModel& model, const model::TermMoments& moments, const std::string& actor, const DetailOptions& options = {});

/// The bytes of a model file: a stored stream without tracks.
Bytes model_file(const Hash& manifest, const std::vector<protocol::StaticBlob>& blobs, const std::string& name);

}  // namespace mien::encoder
