#include "net/file_source.hpp"

#include <thread>

#include "net/client.hpp"
#include "net/stored_stream.hpp"
#include "net/url.hpp"
#include "protocol/fetch_order.hpp"

namespace mien::net {

FileSource::FileSource(protocol::StreamFileReader reader, SourceOptions options)
    : reader_(std::move(reader)), options_(std::move(options)) {}

Result<std::unique_ptr<FileSource>> FileSource::open(const std::filesystem::path& path, SourceOptions options) {
    MIEN_TRY(reader, open_stored_stream(path));
    std::unique_ptr<FileSource> source(new FileSource(std::move(reader), std::move(options)));
    for (const protocol::BlobInfo& info : source->reader_.catalogue().blobs) {
        auto bytes = source->reader_.blob(info.hash);
        if (!bytes) return Error{bytes.error().code, path.string() + ": " + bytes.error().message};
        source->blobs_[info.hash] = std::move(*bytes);
    }
    source->statistics_.model_bytes = source->statistics_.model_size = protocol::total_bytes(source->reader_.catalogue());
    if (!source->reader_.complete()) source->statistics_.incomplete = source->reader_.complaint();
    source->seek(source->options_.start);
    source->generation_ = 0;
    return source;
}

Result<void> FileSource::wait_ready(std::chrono::milliseconds) { return {}; }

const Bytes* FileSource::blob(const Hash& hash) const {
    const auto found = blobs_.find(hash);
    return found == blobs_.end() ? nullptr : &found->second;
}

std::optional<Arrival> FileSource::next(std::chrono::milliseconds timeout) {
    std::unique_lock lock(mutex_);
    if (state_ == SourceState::ended) {
        lock.unlock();
        std::this_thread::sleep_for(timeout);  // nothing comes until somebody seeks
        return {};
    }
    while (const protocol::IndexEntry* next = walk_.peek()) {
        const protocol::IndexEntry& entry = *next;
        walk_.pop();
        auto group = reader_.read_group(entry);
        statistics_.bytes += entry.size;
        if (!group) {
            ++statistics_.damaged_groups;
            continue;
        }
        ++statistics_.groups;
        return Arrival{generation_, std::move(*group)};
    }
    const Arrival end{generation_, {}};
    state_ = SourceState::ended;
    lock.unlock();
    if (options_.on_status) options_.on_status({SourceState::ended, {}});
    return end;
}

std::uint32_t FileSource::seek(double seconds) {
    std::unique_lock lock(mutex_);
    walk_.start(reader_.group_at(seconds));
    const std::uint32_t generation = ++generation_;
    const bool again = state_ == SourceState::ended;
    state_ = SourceState::playing;
    lock.unlock();
    if (again && options_.on_status) options_.on_status({SourceState::playing, {}});
    return generation;
}

void FileSource::select(std::uint64_t slots) {
    const std::lock_guard lock(mutex_);
    walk_.select(slots);
}

SourceStatus FileSource::status() const {
    const std::lock_guard lock(mutex_);
    return {state_, {}};
}

SourceStatistics FileSource::statistics() const {
    const std::lock_guard lock(mutex_);
    return statistics_;
}

Result<std::unique_ptr<StreamSource>> open_source(std::string_view url_or_path, SourceOptions options) {
    if (!looks_like_url(url_or_path)) {
        MIEN_TRY(source, FileSource::open(url_or_path, std::move(options)));
        return std::unique_ptr<StreamSource>(std::move(source));
    }
    MIEN_TRY(url, parse_url(url_or_path));
    if (url.name.empty())
        return Error{ErrorCode::invalid, std::string(url_or_path) + " names a server but no stream; add /NAME"};
    return std::unique_ptr<StreamSource>(std::make_unique<Client>(std::move(url), std::move(options)));
}

}  // namespace mien::net
