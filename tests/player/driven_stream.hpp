#pragma once

#include <map>
#include <stdexcept>

#include "decoder/model_decoder.hpp"
#include "encoder/detail_encoder.hpp"
#include "encoder/stream_encoder.hpp"
#include "tests/detail/small_model.hpp"
#include "tests/net/harness.hpp"

namespace mien::player {

/// A sheet of skin whose markers drive a detail model of four stages.
inline net::harness::Stream driven_stream() {
    const SmallModel small;
    auto coded = encoder::encode_detail(small.model, small.moments, "sheet");
    if (!coded.ok()) throw std::runtime_error(coded.error().message);
    encoder::StreamOptions options;
    options.motion.kind = protocol::MotionKind::markers;
    options.texture.reset();
    options.group_seconds = 0.5;
    options.model = encoder::EncodedModel{coded->manifest, coded->blobs, {}};
    auto face = decoder::decode_model(coded->manifest, [&](const Hash& hash) -> const Bytes* {
        const auto found = std::ranges::find(coded->blobs, hash, &protocol::StaticBlob::hash);
        return found == coded->blobs.end() ? nullptr : &found->bytes;
    });
    if (!face.ok()) throw std::runtime_error(face.error().message);
    options.model->model = std::move(*face);
    auto stream = encoder::encode_stream(small.clip, options);
    if (!stream.ok()) throw std::runtime_error(stream.error().message);
    return {std::move(stream->header), std::move(stream->blobs), std::move(stream->groups)};
}

/// Unpacked bytes of a stream's blobs; without its refinements.
inline std::uint64_t needed_bytes(const net::harness::Stream& stream) {
    std::uint64_t sum = 0;
    for (const auto& blob : stream.blobs) sum += blob.kind == protocol::BlobKind::refinement ? 0 : blob.bytes.size();
    return sum;
}

}  // namespace mien::player
