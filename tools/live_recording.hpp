#pragma once

#include <filesystem>
#include <map>
#include <optional>

#include "io/file.hpp"
#include "protocol/stream_file.hpp"

namespace mien::tools {

/// A live stream on its way to a file. While it lasts, what there is so far is in PATH.recording, which plays like any file that was cut off; finish()
/// makes the whole file of it. Of a stream that never brought a group nothing is left. Throws EnvironmentError.
class LiveRecording {
public:
    /// header.frames is 0.
    LiveRecording(std::filesystem::path path, const protocol::StreamHeader& header, const std::vector<protocol::StaticBlob>& blobs);

    void add(const protocol::Group& group);
    /// The header's frame count and bit rates are known now.
    void finish(std::uint64_t frames);

private:
    /// Takes the file away again as long as there is nothing in it worth keeping.
    struct Part {
        std::filesystem::path path;
        bool keep = true;
        ~Part();
    };
    std::filesystem::path path_;
    Part part_;
    protocol::StreamHeader header_;
    const std::vector<protocol::StaticBlob> blobs_;
    std::FILE* file_ = nullptr;
    io::FileHandle owner_;
    std::optional<protocol::StreamFileWriter> writer_;
    std::map<std::uint8_t, std::uint64_t> payload_;   ///< bytes by slot
    std::int64_t sound_end_ = 0;                     ///< samples
};

}  // namespace mien::tools
