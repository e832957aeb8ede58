#pragma once

#include <asio/steady_timer.hpp>
#include <deque>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "net/wire.hpp"

/// The streams that publishers send, as a server holds them. Internal to this room; on the server's thread only.
namespace mien::net {

/// One live stream: what a viewer needs to open it, and the last objects, in memory that is bounded. It outlives its publisher as
/// long as viewers wait for another one.
class LiveStream {
public:
    /// ring_bytes: messages kept for viewers, at most; what is older goes, the newest group last.
    LiveStream(std::string name, protocol::StreamHeader header, protocol::Catalogue catalogue, std::uint64_t ring_bytes);

    const std::string& name() const { return name_; }
    const protocol::StreamHeader& header() const { return header_; }
    const protocol::Catalogue& catalogue() const { return catalogue_; }
    bool same_as(const protocol::StreamHeader& header, const protocol::Catalogue& catalogue) const;

    /// BLOB messages as they came, by hash.
    std::map<Hash, std::shared_ptr<const Bytes>> blobs;
    std::vector<Hash> missing() const;

    // ---- the publisher's side ----
    void set_live(bool live);
    /// Nobody will go on with this stream: another one has its name.
    void supersede();
    /// Errors: a slot that the header lacks, a group or time that goes back.
    Result<void> start_group(const protocol::GroupStart& start);
    /// Errors: no group of this slot has been started.
    Result<void> append(const protocol::LiveBytes& object);

    // ---- the viewers' side ----
    /// A message of the stream; `number` counts all there ever were.
    struct Record {
        std::uint8_t slot = 0;
        bool start = false;            ///< GROUP START
        std::uint32_t group = 0;
        std::shared_ptr<const Bytes> message;
    };
    /// Null when it is still to come. `number` is at least first().
    const Record* at(std::uint64_t number) const;
    std::uint64_t first() const { return first_; }
    /// Where a viewer begins: the start of the newest group that is still here whole, or else what comes next.
    std::uint64_t newest() const;
    std::uint32_t newest_group() const;
    std::uint32_t next_group() const { return next_group_; }
    std::uint64_t frames() const;      ///< visual frames there have been
    bool live() const { return live_; }
    bool superseded() const { return superseded_; }

    /// Rings whenever something has changed.
    void watch(asio::steady_timer& bell) { bells_.insert(&bell); }
    void leave(asio::steady_timer& bell) { bells_.erase(&bell); }

private:
    struct Slot {
        bool visual = false;
        std::optional<std::uint32_t> group;
        std::uint32_t frames = 1;      ///< of each object of that group
        std::int64_t next_time = 0;    ///< ticks
        std::uint32_t packet_ticks = 1;
    };
    void keep(Record record);
    void ring() const;

    const std::string name_;
    const protocol::StreamHeader header_;
    const protocol::Catalogue catalogue_;
    const std::uint64_t ring_bytes_;
    std::map<std::uint8_t, Slot> slots_;
    std::deque<Record> records_;
    std::uint64_t first_ = 0;          ///< number of records_.front()
    std::uint64_t bytes_ = 0;          ///< of records_
    std::uint64_t group_start_ = 0;    ///< number of the first GROUP START of the newest group
    std::uint32_t next_group_ = 0;
    std::uint32_t least_group_ = 0;    ///< of this publisher
    bool live_ = false, superseded_ = false;
    std::set<asio::steady_timer*> bells_;
};

/// Live streams by name, and who publishes.
class LiveStreams {
public:
    /// The stream that viewers open under this name; null when nobody publishes it.
    std::shared_ptr<LiveStream> find(const std::string& name) const;
    std::vector<protocol::StreamEntry> list() const;

    bool claim(const std::string& name) { return claimed_.insert(name).second; }
    void release(const std::string& name) { claimed_.erase(name); }
    std::size_t publishers() const { return claimed_.size(); }
    /// The stream to go on with: the one that viewers still hold when it is the same, else a new one.
    std::shared_ptr<LiveStream> resume(const std::string& name, protocol::StreamHeader header, protocol::Catalogue catalogue,
                                       std::uint64_t ring_bytes);
    /// Viewers find it from now on; those of another one under this name are told.
    void show(const std::shared_ptr<LiveStream>& stream);

private:
    std::map<std::string, std::weak_ptr<LiveStream>> streams_;
    std::set<std::string> claimed_;
};

/// What one publisher sends, message by message, checked: PUBLISH has been accepted, HEADER comes next. Knows no socket.
class Publication {
public:
    /// `name` has been claimed; it is released at the end, and viewers see the stream end.
    Publication(LiveStreams& streams, std::string name, std::uint64_t ring_bytes)
        : streams_(streams), name_(std::move(name)), ring_bytes_(ring_bytes) {}
    ~Publication();
    Publication(const Publication&) = delete;
    Publication& operator=(const Publication&) = delete;

    static constexpr std::uint64_t kMaxFront = 1u << 20;             ///< HEADER or CATALOGUE, bytes
    static constexpr std::uint64_t kMaxBlobs = protocol::kMaxBlobBytes;  ///< unpacked bytes of all static blobs together

    const std::string& name() const { return name_; }
    /// The largest body that may come next.
    std::uint64_t limit() const;
    /// What to answer. Errors end the connection, and say why.
    Result<std::vector<protocol::Message>> take(const protocol::Message& message, const RawMessage& raw);
    /// END has come; nothing may follow.
    bool ended() const { return stage_ == Stage::ended; }
    bool awaits_blob() const { return stage_ == Stage::blobs; }
    bool streaming() const { return stage_ == Stage::streaming; }

private:
    enum class Stage { header, catalogue, blobs, streaming, ended };
    Result<std::vector<protocol::Message>> take_catalogue(const protocol::Catalogue& catalogue);
    Result<std::vector<protocol::Message>> take_blob(const protocol::StaticBlob& blob, const RawMessage& raw);
    protocol::Message go_live();

    LiveStreams& streams_;
    const std::string name_;
    const std::uint64_t ring_bytes_;
    Stage stage_ = Stage::header;
    protocol::StreamHeader header_;
    std::shared_ptr<LiveStream> stream_;
    std::deque<Hash> awaited_;         ///< BLOBs, in the order asked for
};

}  // namespace mien::net
