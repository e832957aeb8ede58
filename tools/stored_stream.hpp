#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>

#include "core/clip.hpp"
#include "core/progress.hpp"
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

    /// Reads every group of the track's first rung, in order. Stops at the first error, its own or the visitor's.
    Result<void> visit_groups(const protocol::Track& track, const std::function<Result<void>(const protocol::Group&)>& visit) const;
    /// Decodes the motion track from its start to its end, frame by frame, with all rungs that the decoder was made for. A cut stream
    /// may lack some at its end; those that are damaged are an error.
    Result<void> visit_motion(decoder::MotionDecoder& decoder, const std::function<Result<void>(const model::Motion&)>& visit) const;

private:
    static Result<StoredStream> load(protocol::StreamFileReader reader);

    std::shared_ptr<protocol::StreamFileReader> reader_;
    std::map<Hash, Bytes> blobs_;
};

/// Everything a stream gives back, in the shape of the clip that was encoded: its vertices, markers or weights, head pose,
/// gaze, texture (decoded as it is read) and sound. `damaged` groups are an error. A stream that has been cut gives the frames
/// that it still holds; its texture may end a group before its motion, and then so does what is `textured`.
enum class Keep { textured, all };
Result<Clip> decode_stream(const StoredStream& stream, const Progress& progress = {}, Keep keep = Keep::textured,
                           std::size_t highest_rung = StoredStream::kAllRungs);

}  // namespace mien::tools
