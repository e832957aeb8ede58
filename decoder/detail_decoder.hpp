#pragma once

#include <memory>

#include "decoder/model_decoder.hpp"
#include "model/detail_model.hpp"

namespace mien::decoder {

/// A detail model that grows with what has come of it.
class DetailDecoder {
public:
    /// Mesh, shell and marker domain of the model that manifest blob `manifest` names: these must be there. Errors: `missing`, `damaged`,
    /// `limit_exceeded` (before anything is built); `invalid` of a manifest without these layers.
    static Result<DetailDecoder> open(const Hash& manifest, const FindBlob& find);

    struct Changed {
        bool medium = false, fine = false, albedo = false;
        bool any() const { return medium || fine || albedo; }
    };
    /// Takes what `find` has by now: a map begins with its mask and first stage, and each refinement counts once all before it are there. An
    /// error is final: the model is left as it was, and the decoder is of no further use.
    Result<Changed> update(const FindBlob& find);
    /// All stages of all maps are in.
    bool complete() const;

    /// Layers that have not begun have no texels.
    const model::DetailModel& model() const;
    model::DetailModel take();  ///< ends the decoder

    DetailDecoder(DetailDecoder&&) noexcept;
    DetailDecoder& operator=(DetailDecoder&&) noexcept;
    ~DetailDecoder();

private:
    class Unpacker;
    explicit DetailDecoder(std::unique_ptr<Unpacker> unpacker);
    std::unique_ptr<Unpacker> unpacker_;
};

/// Both in one: the detail model as far as `find` has it.
Result<model::DetailModel> decode_detail(const Hash& manifest, const FindBlob& find);

/// The model of a stored stream, as a model file is one.
Result<model::DetailModel> decode_detail_file(ByteView file);

}  // namespace mien::decoder
