#include <fmt/format.h>
#include <zstd.h>

#include <cassert>
#include <set>

#include "core/environment_error.hpp"
#include "protocol/bodies.hpp"

namespace mien::protocol {

namespace {

constexpr std::uint8_t kRaw = 0, kZstd = 1;

/// Empty when packing does not pay.
Bytes pack(const Bytes& bytes) {
    // Written once and sent often: the slow levels, as long as they take seconds.
    const int level = bytes.size() <= (8u << 20) ? 19 : 12;
    Bytes packed(ZSTD_compressBound(bytes.size()));
    const std::size_t size = ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), level);
    if (ZSTD_isError(size)) throw EnvironmentError(fmt::format("zstd cannot pack {} bytes: {}", bytes.size(), ZSTD_getErrorName(size)));
    if (size >= bytes.size()) return {};
    packed.resize(size);
    return packed;
}

Result<Bytes> unpack(ByteView packed, std::uint64_t size) {
    if (ZSTD_getFrameContentSize(packed.data(), packed.size()) != size)
        return damaged("its packed size is not what it announces");
    Bytes bytes(size);
    const std::size_t got = ZSTD_decompress(bytes.data(), bytes.size(), packed.data(), packed.size());
    if (ZSTD_isError(got) || got != size) return damaged("it cannot be unpacked");
    return bytes;
}

bool known(std::uint8_t kind) {
    return kind >= static_cast<std::uint8_t>(BlobKind::manifest) && kind <= static_cast<std::uint8_t>(BlobKind::lid);
}

}  // namespace

std::string_view name_of(BlobKind kind) {
    switch (kind) {
        case BlobKind::manifest: return "model manifest";
        case BlobKind::shape: return "shape";
        case BlobKind::connectivity: return "connectivity";
        case BlobKind::texcoords: return "texture coordinates";
        case BlobKind::motion_basis: return "motion basis";
        case BlobKind::blend: return "blend coefficients";
        case BlobKind::blendshapes: return "blendshapes";
        case BlobKind::texture: return "texture";
        case BlobKind::eyes: return "eyes";
        case BlobKind::contact: return "contact";
        case BlobKind::shell: return "shell";
        case BlobKind::marker_domain: return "marker domain";
        case BlobKind::texel_mask: return "texel mask";
        case BlobKind::detail_map: return "detail map";
        case BlobKind::refinement: return "detail refinement";
        case BlobKind::driving_markers: return "driving markers";
        case BlobKind::lid: return "lid";
    }
    return {};
}

void write_body(ByteWriter& out, const Catalogue& catalogue) {
    assert(catalogue.blobs.size() <= kMaxBlobs);
    ByteWriter rest;
    rest.varint(catalogue.blobs.size());
    for (const BlobInfo& blob : catalogue.blobs) {
        rest.hash(blob.hash);
        rest.u8(static_cast<std::uint8_t>(blob.kind));
        rest.varint(blob.size);
    }
    write_checked(out, rest.view());
}

Result<Catalogue> read_catalogue(ByteView body) {
    ByteReader in(body);
    if (!read_checked(in, body)) return damaged("its checksum does not match");
    const std::uint64_t count = in.varint();
    if (count > kMaxBlobs) return too_large(fmt::format("{} static blobs; at most {} are taken", count, kMaxBlobs));
    Catalogue catalogue;
    std::set<Hash> seen;
    for (std::uint64_t b = 0; b < count && in.ok(); ++b) {
        BlobInfo blob;
        blob.hash = in.hash();
        const std::uint8_t kind = in.u8();
        blob.size = in.varint();
        if (!in.ok()) break;
        if (!known(kind)) return damaged(fmt::format("static blob {} is of unknown kind {}", b, kind));
        if (blob.size > kMaxBlobBytes) return too_large(fmt::format("static blob {} has {} bytes", b, blob.size));
        if (!seen.insert(blob.hash).second) return damaged(fmt::format("static blob {} is listed twice", b));
        blob.kind = static_cast<BlobKind>(kind);
        catalogue.blobs.push_back(blob);
    }
    MIEN_CHECK(check_end(in));
    return catalogue;
}

void write_body(ByteWriter& out, const StaticBlob& blob) {
    assert(blob.bytes.size() <= kMaxBlobBytes);
    const Bytes packed = pack(blob.bytes);
    out.hash(blob.hash);
    out.u8(static_cast<std::uint8_t>(blob.kind));
    out.u8(packed.empty() ? kRaw : kZstd);
    out.varint(blob.bytes.size());
    out.bytes(packed.empty() ? blob.bytes : packed);
}

Result<BlobHead> parse_blob_head(ByteView body) {
    ByteReader in(body);
    BlobHead head;
    head.hash = in.hash();
    const std::uint8_t kind = in.u8(), packing = in.u8();
    head.unpacked = in.varint();
    head.size = in.position();
    if (!in.ok()) return Error{ErrorCode::truncated, "ends early"};
    if (!known(kind) || packing > kZstd) return damaged("its kind or packing is unknown");
    if (head.unpacked > kMaxBlobBytes) return too_large(fmt::format("{} bytes; at most {} are taken", head.unpacked, kMaxBlobBytes));
    head.kind = static_cast<BlobKind>(kind);
    head.packed = packing == kZstd;
    return head;
}

Result<StaticBlob> read_blob(ByteView body) {
    MIEN_TRY(head, parse_blob_head(body));
    const ByteView stored = body.subspan(head.size);
    StaticBlob blob{head.hash, head.kind, {}};
    if (head.packed) {
        MIEN_TRY(bytes, unpack(stored, head.unpacked));
        blob.bytes = std::move(bytes);
    } else {
        if (stored.size() != head.unpacked) return damaged("its size is not what it announces");
        blob.bytes.assign(stored.begin(), stored.end());
    }
    if (sha256(blob.bytes) != blob.hash) return damaged("its bytes do not have the hash that names it");
    return blob;
}

void write_body(ByteWriter& out, const BlobPart& part) {
    assert(!part.bytes.empty() && part.bytes.size() <= part.total && part.bytes.size() <= kMaxPartBytes);
    out.varint(part.total);
    out.bytes(part.bytes);
}

Result<BlobPart> read_blob_part(ByteView body) {
    ByteReader in(body);
    BlobPart part{in.varint(), {}};
    if (!in.ok()) return Error{ErrorCode::truncated, "ends early"};
    const ByteView bytes = body.subspan(in.position());
    if (part.total > kMaxMessageBytes + kMaxHeadBytes || bytes.size() > kMaxPartBytes) return too_large(fmt::format("{} of {} bytes", bytes.size(), part.total));
    if (bytes.empty() || bytes.size() > part.total) return damaged("it holds nothing, or more than the whole");
    part.bytes.assign(bytes.begin(), bytes.end());
    return part;
}

Bytes encode_manifest(const Manifest& manifest) {
    assert(manifest.actor.size() <= kMaxName && manifest.layers.size() <= kMaxLayers);
    ByteWriter out;
    out.u8(kVersion);
    out.text(manifest.actor);
    out.varint(manifest.layers.size());
    for (const Layer& layer : manifest.layers) {
        assert(layer.blobs.size() <= kMaxBlobs);
        out.u8(static_cast<std::uint8_t>(layer.kind));
        out.varint(layer.blobs.size());
        for (const Hash& hash : layer.blobs) out.hash(hash);
    }
    return out.take();
}

Result<Manifest> parse_manifest(ByteView bytes) {
    ByteReader in(bytes);
    const std::uint8_t version = in.u8();
    if (in.ok() && version != kVersion)
        return Error{ErrorCode::unsupported_version,
                     fmt::format("the model manifest has version {}, this program reads version {}", version, kVersion)};
    Manifest manifest;
    manifest.actor = in.text(kMaxName);
    const std::uint64_t layers = in.varint();
    if (layers > kMaxLayers) return too_large(fmt::format("the model manifest has {} layers", layers));
    for (std::uint64_t l = 0; l < layers && in.ok(); ++l) {
        Layer layer;
        const std::uint8_t kind = in.u8();
        const std::uint64_t blobs = in.varint();
        if (!in.ok()) break;
        if (kind < 1 || kind > static_cast<std::uint8_t>(LayerKind::lid))
            return damaged(fmt::format("layer {} of the model manifest is of unknown kind {}", l, kind));
        if (blobs > kMaxBlobs) return too_large(fmt::format("layer {} of the model manifest names {} blobs", l, blobs));
        layer.kind = static_cast<LayerKind>(kind);
        for (std::uint64_t b = 0; b < blobs && in.ok(); ++b) layer.blobs.push_back(in.hash());
        manifest.layers.push_back(std::move(layer));
    }
    if (auto end = check_end(in); !end) return Error{end.error().code, "the model manifest: " + end.error().message};
    return manifest;
}

}  // namespace mien::protocol
