#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>

#include "decoder/motion_decoder.hpp"
#include "model/face_model.hpp"
#include "protocol/stream_file.hpp"

namespace mien::tools {

/// A stream file, opened: its reader and its static blobs.
class StoredStream {
public:
    /// Errors name the file. `missing` when it is not there.
    static Result<StoredStream> open(const std::filesystem::path& path);
    /// The same for a stream file in memory.
    static Result<StoredStream> from_bytes(std::shared_ptr<const Bytes> bytes);

    const protocol::StreamFileReader& reader() const { return *reader_; }
    const protocol::StreamHeader& header() const { return reader_->header(); }
    const Bytes* blob(const Hash& hash) const;

    Result<model::FaceModel> model() const;
    /// First track of a kind; null when the stream has none.
    const protocol::Track* track(protocol::TrackKind kind) const;
    /// A decoder for the motion track's rungs 0 .. `highest` (or as many as there are).
    Result<decoder::MotionDecoder> motion_decoder(const model::FaceModel& model, std::size_t highest = kAllRungs) const;
    static constexpr std::size_t kAllRungs = 64;

    /// Told of a group that cannot be read or that the visitor refuses; the visit then goes on with the next one.
    using Skip = std::function<void(const protocol::IndexEntry& group, const Error& why)>;
    /// Reads every group of the track's first rung, in order. Without `skip` the first error ends it, its own or the visitor's.
    Result<void> visit_groups(const protocol::Track& track, const std::function<Result<void>(const protocol::Group&)>& visit,
                              const Skip& skip = {}) const;
    /// Decodes the motion track from its start to its end, frame by frame, with all rungs that the decoder was made for. A cut
    /// stream may lack some at its end. With `skip`, where a finer rung is damaged the coarser ones stand alone.
    Result<void> visit_motion(decoder::MotionDecoder& decoder, const std::function<Result<void>(const model::Motion&)>& visit,
                              const Skip& skip = {}) const;

private:
    static Result<StoredStream> load(protocol::StreamFileReader reader);

    std::shared_ptr<protocol::StreamFileReader> reader_;
    std::map<Hash, Bytes> blobs_;
};

}  // namespace mien::tools
