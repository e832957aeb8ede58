#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/clip.hpp"
#include "core/progress.hpp"
#include "core/result.hpp"
#include "protocol/stream.hpp"

namespace mien::bench {

/// The texture of a clip as stored.
struct CodedTexture {
    protocol::Track track;  ///< with one rung
    std::vector<protocol::Group> groups;

    std::uint64_t bytes() const;  ///< packets and codec headers
};

/// The subject: encoder::encode_texture, groups of one second.
Result<CodedTexture> encode_ours(const Clip& clip, const std::string& codec, double kbps, const Progress& progress = {});

/// The baseline: libavcodec's encoder at the same preset, given the same filled texture, rate control and group length, and
/// nothing else. Where the rate control misses, it is asked again in the same way.
Result<CodedTexture> encode_plain(const Clip& clip, const std::string& codec, double kbps, const Progress& progress = {});

/// Decodes everything; `picture` gets every frame in order, as RGB.
Result<void> decode_texture(const CodedTexture& texture,
                            const std::function<Result<void>(std::int64_t frame, const Image& picture)>& picture);

std::string texture_library();  ///< "FFmpeg 5.1.6"

}  // namespace mien::bench
