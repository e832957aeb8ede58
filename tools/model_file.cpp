#include "tools/model_file.hpp"

namespace mien::tools {

Result<encoder::EncodedModel> model_of(const StoredStream& stream) {
    encoder::EncodedModel model;
    model.manifest = stream.header().model;
    MIEN_TRY(face, stream.model());
    model.model = std::move(face);
    for (const protocol::BlobInfo& blob : stream.reader().catalogue().blobs)
        if (const Bytes* bytes = stream.blob(blob.hash); bytes && blob.kind != protocol::BlobKind::motion_basis)
            model.blobs.push_back({blob.hash, blob.kind, *bytes});
    return model;
}

Result<encoder::EncodedModel> read_model(const std::string& path) {
    MIEN_TRY(stream, StoredStream::open(path));
    if (!stream.header().tracks.empty()) return Error{ErrorCode::invalid, "'" + path + "' is a stream, not a model file"};
    return model_of(stream);
}

}  // namespace mien::tools
