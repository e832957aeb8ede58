#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/messages.hpp"

/// A stored stream: HEADER, CATALOGUE, BLOBs, GROUPs ordered by group and then slot, END, INDEX, TRAILER.
namespace mien::protocol {

/// Appends to the file being written; throws EnvironmentError when it cannot.
using Append = std::function<void(ByteView bytes)>;

/// Writes a stored stream front to back; nothing is kept in memory but the index.
class StreamFileWriter {
public:
    /// Writes header, catalogue and blobs. The header's `frames` and the blobs (the manifest among them) must be final.
    StreamFileWriter(Append append, const StreamHeader& header, const std::vector<StaticBlob>& blobs);

    /// Groups come ordered by group number and, within one, by slot; slots as the header names them.
    void add(const Group& group);
    /// Writes END, INDEX and TRAILER. Without it the file still plays, as a truncated one does.
    void finish();

    std::uint64_t size() const { return size_; }  ///< bytes written so far

private:
    void write(const Bytes& bytes);

    Append append_;
    std::uint64_t size_ = 0;
    std::uint64_t frames_ = 0;
    std::uint64_t slots_ = 0;  ///< bit per slot the header names
    Index index_;
};

/// Sorts by group, then slot: the order in which StreamFileWriter wants them.
void order_groups(std::vector<Group>& groups);

/// Reads up to into.size() bytes from `offset`; fewer only at the end of the file. Called from any thread that calls the
/// reader, so it must keep no position (pread).
using ReadAt = std::function<Result<std::size_t>(std::uint64_t offset, std::span<std::byte> into)>;

/// Reads a stored stream. After open() all methods are const and may be called from several threads when `ReadAt` may.
///
/// A truncated file opens and plays to its last whole object; a missing or damaged index is rebuilt by scanning; damage in
/// header, catalogue or a static blob is refused, naming the part.
class StreamFileReader {
public:
    static Result<StreamFileReader> open(ReadAt read_at, std::uint64_t file_size);

    const StreamHeader& header() const { return header_; }
    const Catalogue& catalogue() const { return catalogue_; }
    const Manifest& manifest() const { return manifest_; }
    /// The unpacked bytes of a static blob, checked against its hash.
    Result<Bytes> blob(const Hash& hash) const;
    /// The BLOB message as stored, for sending on. Only its framing is checked.
    Result<Bytes> blob_message(const Hash& hash) const;
    /// Up to `bytes` bytes of that message from `offset` on; the last ones where it ends, `invalid` behind its end.
    Result<BlobPart> blob_part(const Hash& hash, std::uint64_t offset, std::uint32_t bytes) const;

    /// All groups, in file order: by group, then slot.
    const std::vector<IndexEntry>& index() const { return index_; }
    /// Numbers of the groups there are, ascending.
    const std::vector<std::uint32_t>& groups() const { return groups_; }
    /// The entry of (slot, group); null when the file has none.
    const IndexEntry* find(std::uint8_t slot, std::uint32_t group) const;
    /// Index of the first entry of index() whose group number is at least `group`.
    std::size_t first_entry(std::uint32_t group) const;
    /// Number of the group that contains `seconds`: the last one that starts at or before it (the first one before all).
    std::uint32_t group_at(double seconds) const;
    /// When an entry's first object is due, seconds.
    double start_of(const IndexEntry& entry) const;
    double seconds() const;  ///< the stream's length by its visual frames

    /// Objects of one group of one rung. `missing` when there is none, `damaged` when its checksum does not match. The
    /// last group of a truncated file gives its leading whole objects.
    Result<Group> read_group(std::uint8_t slot, std::uint32_t group) const;
    Result<Group> read_group(const IndexEntry& entry) const;
    /// The GROUP message as stored, for sending on; a cut group is made into a whole message of its whole objects.
    Result<Bytes> group_message(const IndexEntry& entry) const;

    /// The file ended inside this entry: it yields its leading objects, and no checksum vouches for them.
    bool is_cut(const IndexEntry& entry) const { return cut_ && entry.offset == cut_; }
    /// END, INDEX and TRAILER are there and sound.
    bool complete() const { return complaint_.empty(); }
    /// Why the index was rebuilt, one sentence; empty when complete().
    const std::string& complaint() const { return complaint_; }

    /// Where the file's bytes go. All sum up to `total`, except for bytes no message claims (damage).
    struct Accounting {
        struct Blob {
            BlobInfo info;
            std::uint64_t stored = 0;   ///< bytes of the packed content
        };
        struct Slot {
            std::uint64_t payload = 0;  ///< bytes of the objects themselves
            std::uint64_t groups = 0;
            std::uint64_t damaged = 0;  ///< groups that cannot be read
            std::uint64_t objects = 0;
        };
        std::uint64_t total = 0;        ///< the file
        std::vector<Blob> blobs;        ///< in catalogue order
        std::map<std::uint8_t, Slot> slots;
        std::uint64_t framing = 0;      ///< the rest: heads, header, catalogue, hashes, lengths, checksums, index, trailer
        std::uint64_t group_framing = 0;  ///< of `framing`: GROUP heads and index, what the budget of docs/format.md speaks of
    };
    /// Reads every group's lengths; damaged groups count as framing.
    Result<Accounting> account() const;

private:
    struct StoredBlob {
        std::uint64_t offset = 0;    ///< of the message
        std::uint64_t size = 0;      ///< of the whole message
        BlobHead head;
    };
    StreamFileReader() = default;
    Result<Bytes> read(std::uint64_t offset, std::uint64_t size) const;
    Result<MessageHead> read_head(std::uint64_t offset) const;
    Result<Message> read_message(std::uint64_t offset, MessageType type, std::uint64_t& next) const;
    Result<void> read_front();
    Result<void> read_blob_places(std::uint64_t at);
    Result<void> read_stored_index();
    Result<void> check_index(const Index& index, std::uint64_t end) const;
    void rebuild_index();
    void use_index(std::vector<IndexEntry> entries);

    ReadAt read_at_;
    std::uint64_t file_size_ = 0;
    StreamHeader header_;
    Catalogue catalogue_;
    Manifest manifest_;
    std::map<Hash, StoredBlob> blobs_;
    std::uint64_t front_ = 0;        ///< bytes of header, catalogue and blobs: the groups follow
    std::vector<IndexEntry> index_;
    std::vector<std::uint32_t> groups_;
    std::vector<IndexEntry> marks_;  ///< entries of the slot that seeking goes by
    std::uint64_t cut_ = 0;          ///< offset of the cut group; 0: none
    std::string complaint_;
};

}  // namespace mien::protocol
