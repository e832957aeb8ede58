#pragma once

#include <filesystem>
#include <map>
#include <mutex>

#include "net/group_walk.hpp"
#include "net/source.hpp"
#include "protocol/stream_file.hpp"

namespace mien::net {

/// Plays a stored stream from disk. next() reads when it is called and never waits.
class FileSource final : public StreamSource {
public:
    /// Reads header and all static blobs.
    static Result<std::unique_ptr<FileSource>> open(const std::filesystem::path& path, SourceOptions options);

    Result<void> wait_ready(std::chrono::milliseconds timeout) override;
    const protocol::StreamHeader& header() const override { return reader_.header(); }
    const protocol::Catalogue& catalogue() const override { return reader_.catalogue(); }
    const Bytes* blob(const Hash& hash) const override;
    std::uint64_t wait_model(std::uint64_t, std::chrono::milliseconds) const override { return statistics_.model_size; }
    std::optional<Arrival> next(std::chrono::milliseconds timeout) override;
    std::uint32_t seek(double seconds) override;
    void pause(bool) override {}
    void set_rate(double) override {}
    void select(std::uint64_t slots) override;
    SourceStatus status() const override;
    SourceStatistics statistics() const override;

    const protocol::StreamFileReader& reader() const { return reader_; }

private:
    FileSource(protocol::StreamFileReader reader, SourceOptions options);

    const protocol::StreamFileReader reader_;
    const SourceOptions options_;
    std::map<Hash, Bytes> blobs_;
    mutable std::mutex mutex_;      ///< of everything below
    GroupWalk walk_{reader_};
    std::uint32_t generation_ = 0;
    SourceState state_ = SourceState::playing;
    SourceStatistics statistics_;
};

}  // namespace mien::net
